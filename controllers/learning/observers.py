"""The observers taught the same map from temperatures to growth as the regression.

An observer's growth is linear in its modes, and so are the temperatures at its sensors. In place of the
model's own expansion it gets the learnt coefficients of these temperatures. Its model of motor and link then
serves to smooth them and to see that a reading cannot be; the structure that it lacks is in the covariance of
each mode (`profile_std`), large enough that thermometers outweigh the duty.
"""

from __future__ import annotations

import numpy as np

from warmlink.controllers.design.gains import Unknown, design_controller
from warmlink.controllers.design.plant import Plant
from warmlink.controllers.interface import SENSED
from warmlink.controllers.learning.duty import duty_std
from warmlink.controllers.learning.learnt import LearntMap
from warmlink.controllers.start_values import Values
from warmlink.fmus.component.quantities import ROOM_TEMPERATURE

PROFILE = 0.3
"""K by which each mode may be off where it is largest: a model of other structure is."""

MODEL_SHARE, RECEIVED_SHARE = 1.0, 0.2
"""Shares of the link's losses, and of the motor's heat, that may enter or leave the link unknown."""

EXPANSION, OFFSET = 0.01, 1e-6
"""Share of the growth, and growth in m, by which what a log taught may be off: a camera shows them."""

UNTOLD = 5e-6
"""m; how far growth by duty alone is taken to be off where no log holds the duty."""

SMOOTHING_TIME = 15.0
"""s; as of the regression."""


def taught(
    law: str,
    learnt: LearntMap,
    sample_time: float,
    plant: Plant | None = None,
    camera_std: float | None = None,
) -> Values:
    """Parameter set of an observer by what a log taught.

    Parameters
    ----------
    law : observer or observer_drift
    learnt : from logs of the machine
    sample_time : in s
    plant : a model of the machine; the nominal cell by default
    camera_std : noise of the camera in m; by default that with which the logs read the growth
    """
    sensors = {name: float(std) for name, std in zip(SENSED, learnt.sensor_std, strict=True) if std > 0}
    unknown = Unknown(profile=PROFILE, quiet_share=1.0, expansion=EXPANSION, offset=OFFSET)
    noise = learnt.growth_noise or None if camera_std is None else camera_std
    design = design_controller(law, list(sensors), sensors, sample_time, plant, unknown, noise)
    values = dict(design.parameters)
    rows = np.array(values["sensor_rows"]).reshape(len(SENSED), -1)
    by_all = float(learnt.coefficients.sum())
    found = {
        **values,
        "elongation_row": (learnt.coefficients @ rows).tolist(),
        "elongation_per_kelvin": by_all,
        "reference_temperature": ROOM_TEMPERATURE - learnt.intercept / by_all,
        "model_std": learnt.near,
        "mean_temperature": (learnt.mean_rise + ROOM_TEMPERATURE).tolist(),
        "coefficient_spread": learnt.coefficient_spread,
        "model_share": MODEL_SHARE,
        "received_share": RECEIVED_SHARE,
        "smoothing_time": SMOOTHING_TIME,
        "learnt": 1.0,
        "relative_std": 0.0,
    }
    off = duty_std(learnt.logs, found)
    return {**found, "duty_std": UNTOLD if off is None else off}
