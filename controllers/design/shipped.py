"""The parameter sets that the laws' components ship with."""

import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np

from warmlink.controllers.design.gains import design_controller, plant_parameters, sensor_stds
from warmlink.controllers.design.identified import identified
from warmlink.controllers.design.linear_gains import LinearDesign, design_linear, model_parameters
from warmlink.controllers.design.plant import Plant, no_growth, plant_model
from warmlink.controllers.design.reduction import reduce_plant
from warmlink.controllers.design.regression import SENSORS, fit_regression
from warmlink.controllers.design.training import DrivenRun, excitations, training_run
from warmlink.controllers.observer.model import MODES
from warmlink.controllers.start_values import Values, design_file

LARGEST, LENGTH = (6.0, 4.0), 8 * 3600.0
"""Speed in rad/s and torque in N.m up to which the shipped linear observer is made, and s of its runs."""


def observer_facts(plant: Plant, sensors: Sequence[str] = SENSORS) -> Values:
    """What the observers know of a plant."""
    return plant_parameters(reduce_plant(plant_model(plant), MODES), plant)


def regression_facts(plant: Plant, sensors: Sequence[str] = SENSORS) -> Values:
    """What the regression knows of a plant whose temperatures are measured by these sensors."""
    found = fit_regression(training_run(plant), sensors)
    known = {name: found[name] for name in ("coefficients", "moments")}
    return {**known, "reference_temperature": no_growth(plant)}


def linear_design(plant: Plant | None = None, sensors: Sequence[str] = SENSORS) -> LinearDesign:
    """The linear observer of a plant whose equations are known, from runs of its linear model."""
    return design_linear(_driven(plant, 3), [*_driven(plant, 4)[3:], training_run(plant)], sensors)


def _driven(plant: Plant | None, count: int) -> list[DrivenRun]:
    return [training_run(plant, each) for each in excitations(*LARGEST, LENGTH)[:count]]


def linear_observer_facts(plant: Plant, sensors: Sequence[str] = SENSORS) -> Values:
    """What the linear observer knows of a plant."""
    *made_from, chooses = _driven(plant, 3)
    model = identified(made_from, chooses, np.flatnonzero(sensor_stds(sensors, 1.0)).tolist())
    return model_parameters(model)


PLANT_FACTS: Mapping[str, Callable[..., Values]] = {
    "regression": regression_facts,
    "linear_observer": linear_observer_facts,
    "observer": observer_facts,
    "observer_drift": observer_facts,
}
"""What each law that can be designed knows of the plant, by the plant and the sensors that it uses: that part
of its parameter set which does not follow from the instruments' errors."""


def shipped_values() -> dict[str, Values]:
    """Parameter sets by the law's folder, worked out now; observer_drift has the observer's besides."""
    observer = design_controller("observer").parameters
    drift = design_controller("observer_drift").parameters
    return {
        "observer": observer,
        "observer_drift": {name: value for name, value in drift.items() if observer.get(name) != value},
        "regression": fit_regression(training_run()),
        "linear_observer": linear_design().parameters,
    }


def write_all() -> list[Path]:
    """Write every law's `designed.json`, and return their paths."""
    written = []
    for law, values in shipped_values().items():
        written.append(design_file(law))
        written[-1].write_text(as_json(values), encoding="utf-8")
    return written


def as_json(values: Values) -> str:
    """Text of the file that holds a parameter set."""
    rounded = {
        name: [_rounded(each) for each in value] if isinstance(value, Sequence) else _rounded(value)
        for name, value in values.items()
    }
    return json.dumps(rounded, indent=1) + "\n"


def _rounded(value: float) -> float:
    """A number with the digits that matter: twelve are more than any plant is known to."""
    return float(f"{value:.12g}")
