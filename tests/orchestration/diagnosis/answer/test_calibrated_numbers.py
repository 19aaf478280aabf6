"""Numbers of a calibration as an answer shows them."""

from types import SimpleNamespace
from typing import cast

import numpy as np

from warmlink.orchestration.diagnosis.answer.diagnosis import Diagnosis
from warmlink.orchestration.diagnosis.answer.profile import calibration, met_bounds
from warmlink.orchestration.diagnosis.fit.candidates import FreeNumber
from warmlink.orchestration.diagnosis.fit.fitting import Fit, FitPoint
from warmlink.orchestration.diagnosis.ladder.judged import CALIBRATED
from warmlink.orchestration.machine.heat_paths import rig_of


def plainly() -> Diagnosis:
    """Three usual numbers of a cell: one that is not there, one at its bound, and how far off the air is."""
    freed = (
        FreeNumber("link.hub_heat_capacity", (0,), (0,), 0.0, 2000.0, 0.0),
        FreeNumber("motor.winding_conductance", (1,), (0,), 0.16, 3.2, 0.8),
        FreeNumber("motor.ambient_offset", (2,), (0,), -15.0, 15.0, 0.0, added=True),
    )
    point = FitPoint(0.0, (np.diag([1e-2, 1e4, 1e2]),), (np.zeros(3),))
    fit = Fit((), freed, np.array([1e-6, 0.16, 0.5]), point, (False,) * 3)
    experiment = SimpleNamespace(rig=rig_of("WarmupCell"))
    delivery = SimpleNamespace(model=CALIBRATED)
    return cast("Diagnosis", SimpleNamespace(delivery=delivery, calibration=fit, experiment=experiment))


def test_what_is_usually_not_there_and_is_not_lies_on_no_bound() -> None:
    said = met_bounds(plainly())
    assert "motor.winding_conductance (0.16 W/K)" in said
    assert "hub_heat_capacity" not in said


def test_the_surroundings_are_shown_if_they_were_fitted() -> None:
    numbers = {each.name: each for each in calibration(plainly())}
    assert numbers["motor.ambient_offset"].value == 0.5
    assert numbers["motor.ambient_offset"].unit == "K"
