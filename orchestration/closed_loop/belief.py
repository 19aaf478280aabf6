"""Whether a controller was designed for the cell that it runs in, and what to do if it was not."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path

from warmlink.controllers.start_values import by_scalar, design_file
from warmlink.fmus.component import Component
from warmlink.fmus.names import listed
from warmlink.orchestration.closed_loop.load import load_scenario
from warmlink.orchestration.scenarios.overrides import start_value, start_values
from warmlink.orchestration.system.model import Value
from warmlink.orchestration.system.shipped import COMPENSATOR

PLANT = ("motor", "link")
THERMOMETERS = "sensors"

SUBSTITUTE = "observer"
"""Law that can be designed for any cell; it is proposed if the one in use cannot be designed."""

_NO_PART_OF_A_DESIGN = {"sample_time", "tolerance"}

Written = Mapping[str, str | float]
"""Start values as written, by `instance.variable`."""


def advice(
    controller: str, components: Mapping[str, Component], believed: Written, file: Path | None = None
) -> str | None:
    """Advise what to do if a law was designed for another cell than the one that it runs in.

    Parameters
    ----------
    controller : name of a shipped law
    components : declaration behind each instance of the cell
    believed : start values of the law, and of the cell as its designer may know it (without mismatches)
    file : the scenario's, in which the start values stand

    Returns
    -------
    str or None
        A sentence with the command that designs the law anew; None if the law suits the cell.

    Raises
    ------
    InputError
        If a start value does not exist or is refused.
    """
    changed = _changed(believed, components, PLANT)
    made_for = {name: believed[name] for name in changed}
    differing = f"differs in {listed(changed)}" if changed else "is the nominal one"
    if has_design(controller):
        if knows(controller, components, believed):
            return None
        return (
            f"{controller} was designed for another cell; this one {differing}; design it anew: "
            f"{_command(controller, made_for, file)}; then add --parameters {controller}.ssv"
        )
    own = {name.partition(".")[2] for name in _changed(believed, components, (COMPENSATOR,))}
    if not changed or own - _NO_PART_OF_A_DESIGN or _is_nominal(SUBSTITUTE, components, believed):
        return None
    return (
        f"the parameters of {controller} suit the nominal cell; this one {differing}; tune them, or use a "
        f"law that is designed for this cell: {_command(SUBSTITUTE, made_for, file)}; then run with "
        f"--controller {SUBSTITUTE} --parameters {SUBSTITUTE}.ssv"
    )


def has_design(controller: str) -> bool:
    """Whether a shipped law's parameters come from a design; this is found out without loading the design."""
    return design_file(controller).is_file()


def knows(controller: str, components: Mapping[str, Component], parameters: Written) -> bool:
    """Whether a law that can be designed was designed for the motor and link in `parameters`.

    Raises
    ------
    InputError
        If a start value does not exist or is refused.
    """
    if not _changed(parameters, components, (*PLANT, COMPENSATOR)):
        return True
    own = _values(parameters, components).get(COMPENSATOR, {})
    held = {scalar.name: scalar.start for scalar in components[COMPENSATOR].scalars()} | own
    facts = _facts(controller, components, parameters)
    return all(math.isclose(float(held[n] or 0.0), v, rel_tol=1e-6, abs_tol=1e-12) for n, v in facts.items())


def is_ideal(controller: str, components: Mapping[str, Component], parameters: Written) -> bool:
    """Whether a law runs in exactly the cell that it was designed for, with thermometers without errors.

    Raises
    ------
    InputError
        If a start value does not exist or is refused.
    """
    perfect = not _changed(parameters, components, (THERMOMETERS,))
    return has_design(controller) and perfect and knows(controller, components, parameters)


def _is_nominal(controller: str, components: Mapping[str, Component], parameters: Written) -> bool:
    """Whether a design for this cell would equal the design for the nominal cell."""
    return _facts(controller, components, parameters) == _facts(controller, components, {})


def _facts(controller: str, components: Mapping[str, Component], parameters: Written) -> dict[str, float]:
    from warmlink.controllers.design.plant import cell_plant
    from warmlink.controllers.design.shipped import PLANT_FACTS

    values = _values(parameters, components)
    motor, link = (
        {name: float(v) for name, v in values.get(part, {}).items() if name in components[part].p.index}
        for part in PLANT
    )
    return by_scalar(PLANT_FACTS[controller](cell_plant(motor, link)))


def _values(parameters: Written, components: Mapping[str, Component]) -> dict[str, dict[str, Value]]:
    return start_values(parameters, components, "start values")


def _changed(
    parameters: Written, components: Mapping[str, Component], instances: tuple[str, ...]
) -> list[str]:
    """Names of start values that differ from what the components declare."""
    declared = {
        f"{part}.{scalar.name}": scalar.start
        for part in instances
        for scalar in components[part].scalars()
        if scalar.name in components[part].p.index
    }
    return [
        name
        for name, written in parameters.items()
        if name in declared and start_value(name, written, components, "start values") != declared[name]
    ]


def _command(law: str, plant: Written, file: Path | None) -> str:
    """The command that designs a law, with `--set` for each value that is not in the scenario's file."""
    known = {} if file is None else load_scenario(str(file)).parameters
    beside = {name: value for name, value in plant.items() if known.get(name) != value}
    settings = "".join(f' --set "{name}={value}"' for name, value in beside.items())
    return f"warmlink design {file or 'WarmupCell'} --law {law}{settings} --out {law}.ssv"
