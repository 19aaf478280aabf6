"""Whether a controller was designed for the cell that it runs in, and what to do if it was not."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from pathlib import Path

from warmlink.controllers.start_values import by_scalar, design_file
from warmlink.fmus.arguments import argument
from warmlink.fmus.names import listed
from warmlink.orchestration.closed_loop.load import load_scenario
from warmlink.orchestration.scenarios.overrides import start_values
from warmlink.orchestration.scenarios.scenario import NO_CONTROLLER, Scenario
from warmlink.orchestration.scenarios.setup import CELL
from warmlink.orchestration.shell import command
from warmlink.orchestration.system.shipped import COMPENSATOR

PLANT, THERMOMETERS, LAW = ("motor.", "link."), "sensors.", f"{COMPENSATOR}."

SUBSTITUTE = "observer"
"""Law that can be designed for any cell; it is proposed if the one in use cannot be designed."""

REAL_CELLS = 1e-3
"""Share to which nobody knows the parameters of a real cell; one that is closer to its design is ideal."""

_COUNTED_FROM = "reference_temperature"

_NO_PART_OF_A_DESIGN = {"sample_time", "tolerance"}


def judged(scenario: Scenario) -> tuple[str | None, bool]:
    """Judge whether a scenario's controller was designed for its system.

    The first is a sentence with the command that designs the law anew, None if the law suits the system; the
    second whether the law runs in exactly the cell that it was designed for, with thermometers without
    errors. Raises InputError if a start value does not exist or is refused.
    """
    law, setup = scenario.controller.name, scenario.setup
    if law == NO_CONTROLLER or scenario.controller.place:
        return None, False
    if scenario.design is None:
        told = f"{law} has no design for {setup.name}; it runs with the parameters that it is shipped with"
        return told, False
    if setup.name != CELL.name:
        return None, False
    real, known = (_differing(scenario, e.parameters) for e in (scenario, scenario.as_believed))
    changed = [name for name in known if name.startswith(PLANT)]
    own = {name.removeprefix(LAW) for name in known if name.startswith(LAW)}
    told = f"differs in {listed(changed)}" if changed else "is the nominal one"
    if design_file(law).is_file():  # its parameters come from a design, which is not loaded to find out
        noisy = scenario.in_use.noise is not None or any(name.startswith(THERMOMETERS) for name in real)
        ideal = not noisy and _suits(scenario, real, REAL_CELLS)
        if _suits(scenario, known):
            return None, ideal
        said = f"{law} was designed for another cell; this one {told}"
        anew = _command(scenario, changed, law)
        if own & _facts(law, {}).keys():
            remedy = f"leave out the design that is given, or put that of this cell in its place: {anew}"
            other = f"say so by its values, as {argument('parameters')} or in a scenario"
            return f"{said}; {remedy}; if the cell is that other one, {other}", ideal
        return f"{said}; design it anew: {anew}; then add {_file_of(law)}", ideal
    if not changed or own - _NO_PART_OF_A_DESIGN:
        return None, False
    # What these laws go by is no temperature, or the rise of one since the start.
    mine, nominal = ({**_facts(SUBSTITUTE, each), _COUNTED_FROM: 0.0} for each in (known, {}))
    if mine == nominal:
        return None, False
    return (
        f"the parameters of {law} suit the nominal cell; this one {told}; tune them, or use a "
        f"law that is designed for this cell: {_command(scenario, changed, SUBSTITUTE)}; then run with "
        f"{argument('controller', SUBSTITUTE)} {_file_of(SUBSTITUTE)}"
    ), False


def _file_of(law: str) -> str:
    return argument("parameters", Path(f"{law}.ssv"))


def _command(scenario: Scenario, changed: Iterable[str], law: str) -> str:
    """Command that designs a law for a scenario's cell, of which so much is changed."""
    known = {} if scenario.file is None else load_scenario(str(scenario.file)).parameters
    given = scenario.as_believed.parameters
    settings = [w for n in changed if known.get(n) != given[n] for w in ("--set", f"{n}={given[n]}")]
    words = scenario.file or CELL.name, "--law", law, *settings, "--out", f"{law}.ssv"
    return command("warmlink", "design", *words)


def _differing(scenario: Scenario, written: Mapping[str, str | float]) -> dict[str, float]:
    """Parameters in SI units, of those that are written, that differ from what the components declare."""
    components, found = scenario.declared, {}
    values = start_values(written, components, "start values")
    for full in written:
        instance, _, name = full.rpartition(".")
        part, value = components[instance], float(values[instance][name])
        if name in part.p.index and value != part.start_values()[0][part.p.index[name]]:
            found[full] = value
    return found


def _facts(law: str, differing: Mapping[str, float]) -> dict[str, float]:
    """What a design of a law for a motor and a link that differ so knows of them."""
    from warmlink.controllers.design.plant import cell_plant
    from warmlink.controllers.design.shipped import PLANT_FACTS

    motor, link = (
        {name.removeprefix(each): value for name, value in differing.items() if name.startswith(each)}
        for each in PLANT
    )
    return by_scalar(PLANT_FACTS[law](cell_plant(motor, link)))


def _suits(scenario: Scenario, differing: Mapping[str, float], share: float = 1e-6) -> bool:
    """Whether a law that can be designed was designed for a cell that differs so, to within a share."""
    if not any(name.startswith((*PLANT, LAW)) for name in differing):
        return True
    law = scenario.controller.component
    held = dict(zip(law.p.names, law.start_values()[0].tolist(), strict=True))
    held |= {name.removeprefix(LAW): value for name, value in differing.items()}
    facts = _facts(scenario.controller.name, differing).items()
    return all(math.isclose(held[name], fact, rel_tol=share, abs_tol=1e-12) for name, fact in facts)
