"""The parameter sets that the laws' components ship with, as modules that are written, not edited."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from warmlink.controllers.design.gains import design_controller, plant_parameters
from warmlink.controllers.design.plant import Plant, plant_model
from warmlink.controllers.design.reduction import reduce_plant
from warmlink.controllers.design.regression import fit_regression, training_run
from warmlink.controllers.observer.model import MODES
from warmlink.controllers.start_values import Values

_CONTROLLERS = Path(__file__).resolve().parent.parent

_HEAD = '''"""The parameter set that ships, written by `python -m warmlink.controllers.design`."""

from __future__ import annotations

'''


def observer_facts(plant: Plant) -> Values:
    """What the observers know of a plant."""
    return plant_parameters(reduce_plant(plant_model(plant), MODES), plant)


PLANT_FACTS: Mapping[str, Callable[[Plant], Values]] = {
    "regression": lambda plant: {"moments": fit_regression(training_run(plant))["moments"]},
    "observer": observer_facts,
    "observer_drift": observer_facts,
}
"""What each law that can be designed knows of the plant: that part of its parameter set which follows from
the plant alone, whatever sensors it goes by."""


def shipped_values() -> dict[str, Values]:
    """Parameter sets by the law's folder, worked out now; observer_drift has the observer's besides."""
    observer = design_controller("observer").parameters
    drift = design_controller("observer_drift").parameters
    return {
        "observer": observer,
        "observer_drift": {name: value for name, value in drift.items() if observer.get(name) != value},
        "regression": fit_regression(training_run()),
    }


def write_all(folder: Path = _CONTROLLERS) -> list[Path]:
    """Write every law's `designed.py` below a folder, and return their paths."""
    written = []
    for law, values in shipped_values().items():
        path = folder / law / "designed.py"
        path.write_text(as_module(values), encoding="utf-8")
        written.append(path)
    return written


def as_module(values: Values) -> str:
    """Source of a module that holds the values as `DESIGNED`."""
    lines = ["DESIGNED: dict[str, float | tuple[float, ...]] = {"]
    for name, value in values.items():
        if isinstance(value, Sequence):
            lines += [f'    "{name}": (', *(f"        {_shown(each)}," for each in value), "    ),"]
        else:
            lines.append(f'    "{name}": {_shown(value)},')
    return _HEAD + "\n".join([*lines, "}"]) + "\n"


def _shown(value: float) -> str:
    """A number with the digits that matter: twelve are more than any plant is known to."""
    return repr(float(f"{value:.12g}"))
