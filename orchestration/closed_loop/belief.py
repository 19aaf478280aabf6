"""Whether a controller was designed for the cell that it runs in, and what to do if it was not."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from warmlink.controllers.fail_safe import LIMITS
from warmlink.controllers.interface import SAMPLE_TIME, SENSED, TOLERANCE
from warmlink.controllers.start_values import by_scalar, design_file
from warmlink.fmus.arguments import argument
from warmlink.fmus.errors import InputError
from warmlink.fmus.names import listed
from warmlink.orchestration.closed_loop.load import load_scenario
from warmlink.orchestration.machine.shipped import WARMUP_CELL
from warmlink.orchestration.scenarios.overrides import start_values
from warmlink.orchestration.scenarios.scenario import NO_CONTROLLER, Scenario
from warmlink.orchestration.shell import command

if TYPE_CHECKING:
    from warmlink.controllers.design.plant import Plant

SUBSTITUTE = "observer"
"""Law that can be designed for any cell; it is proposed if the one in use cannot be designed."""

FROM_RUNS = "linear_observer"
"""Law that can be designed for any machine."""

REAL_CELLS = 1e-3
"""Relative uncertainty of a real cell's parameters; a cell that is closer to its design counts as ideal."""

_COUNTED_FROM = "reference_temperature"

_NO_PART_OF_A_DESIGN = {each.name for each in (SAMPLE_TIME, TOLERANCE, *LIMITS)}


def design_check(scenario: Scenario) -> tuple[str | None, bool]:
    """Whether a scenario's controller was designed for its system.

    The first is a sentence with the command that designs the law anew, None if the law suits the system; the
    second whether the law runs in exactly the cell that it was designed for, with thermometers without
    errors. Raises InputError if a start value does not exist or is refused.
    """
    law, machine = scenario.controller.name, scenario.machine
    if law == NO_CONTROLLER or scenario.controller.place or _learnt(scenario):
        return None, False
    if scenario.design is None:
        told = f"{law} has no design for {machine.name}; it runs with the parameters that it is shipped with"
        return told, False
    if machine.designs is not None:
        return None, False
    return _DesignCheck(scenario).advice()


def _learnt(scenario: Scenario) -> bool:
    """Whether the law was learnt from a log, or found from runs, so that no model says what it should be."""
    laws = scenario.machine.controllers
    marks = tuple(f"{law}.{name}" for law in laws for name in ("coefficient_spread", "learnt", "dynamics["))
    return any(name.startswith(marks) for name in scenario.as_believed.parameters)


class _DesignCheck:
    """A scenario with a shipped law, and the values that differ from those that its components declare."""

    def __init__(self, scenario: Scenario) -> None:
        machine = self._machine = scenario.machine
        self._scenario = scenario
        scenario.values()  # which are refused now, if at all
        written = scenario.parameters, scenario.as_believed.parameters
        self._real, self._known = (_differing(scenario, each) for each in written)
        self._plant = tuple(f"{each}." for kind in ("motor", "link") for each in machine.called(kind))
        self._laws = tuple(f"{each}." for each in machine.controllers)
        self._sensors = tuple(f"{each}." for each in machine.called("sensors"))
        theirs, ours = ((each.parts, each.wires, each.nominal) for each in (machine, WARMUP_CELL))
        self._usual = theirs == ours

    def advice(self) -> tuple[str | None, bool]:
        """As `design_check` gives it."""
        law, known = self._scenario.controller.name, self._known
        changed = [name for name in known if name.startswith(self._plant)]
        own = {name.rpartition(".")[2] for name in known if name.startswith(self._laws)}
        told = f"this one differs in {listed(changed)}" if changed else "this one is the nominal one"
        told = told if self._usual else f"this one is {self._machine.name}"
        designed = design_file(law).is_file()  # which is not loaded to find out
        if not designed and (own - _NO_PART_OF_A_DESIGN or (self._usual and not changed)):
            return None, False
        try:
            return self._designed(law, told, own, changed) if designed else self._other(law, told, changed)
        except InputError:  # no design knows the plant, but that which is found from runs of it
            if not designed or own - _NO_PART_OF_A_DESIGN:
                return None, False
            anew = _command(self._scenario, changed, FROM_RUNS)
            then = f"then run with {argument('controller', FROM_RUNS)} {_file_of(FROM_RUNS)}"
            return (
                f"{law} was designed for another cell; {told}; find a law from runs of it: {anew}; {then}",
                False,
            )

    def _designed(self, law: str, told: str, own: set[str], changed: list[str]) -> tuple[str | None, bool]:
        from warmlink.controllers.design.plant import cell_plant

        scenario = self._scenario
        noisy = (scenario.in_use.noise or 0.0) > 0 or any(n.startswith(self._sensors) for n in self._real)
        ideal = not noisy and self._suits(scenario, self._real, REAL_CELLS)
        if self._suits(scenario.as_believed, self._known):
            return None, ideal
        said = f"{law} was designed for another cell; {told}"
        anew = _command(scenario, changed, law)
        if own & _facts(law, cell_plant()).keys():
            remedy = f"leave out the design that is given, or put that of this cell in its place: {anew}"
            other = f"say so by its values, as {argument('parameters')} or in a scenario"
            return f"{said}; {remedy}; if the cell is that other one, {other}", ideal
        return f"{said}; design it anew: {anew}; then add {_file_of(law)}", ideal

    def _other(self, law: str, told: str, changed: list[str]) -> tuple[str | None, bool]:
        # What these laws go by is no temperature, or the rise of one since the start.
        from warmlink.controllers.design.plant import cell_plant

        plants = _plant(self._scenario.as_believed), cell_plant()
        anew = _command(self._scenario, changed, SUBSTITUTE)
        mine, nominal = ({**_facts(SUBSTITUTE, each), _COUNTED_FROM: 0.0} for each in plants)
        if _alike(mine, nominal, 1e-9):
            return None, False
        return (
            f"the parameters of {law} suit the nominal cell; {told}; tune them, or use a "
            f"law that is designed for this cell: {anew}; then run with "
            f"{argument('controller', SUBSTITUTE)} {_file_of(SUBSTITUTE)}"
        ), False

    def _suits(self, scenario: Scenario, differing: Mapping[str, float], share: float = 1e-6) -> bool:
        """Whether a law that can be designed was designed for a scenario's plant, to within a share."""
        if self._usual and not any(name.startswith((*self._plant, *self._laws)) for name in differing):
            return True
        law = scenario.controller.component
        held = dict(zip(law.p.names, law.start_values()[0].tolist(), strict=True))
        held |= {n.rpartition(".")[2]: v for n, v in differing.items() if n.startswith(self._laws)}
        used = [name for i, name in enumerate(SENSED, 1) if held[f"sensor_std[{i}]"] > 0]
        return _alike(_facts(scenario.controller.name, _plant(scenario), used), held, share)


def _file_of(law: str) -> str:
    return argument("parameters", Path(f"{law}.ssv"))


def _command(scenario: Scenario, changed: Iterable[str], law: str) -> str:
    """Command that designs a law for a scenario's cell, with these parameters changed."""
    known = {} if scenario.file is None else load_scenario(str(scenario.file)).as_believed.parameters
    given = scenario.as_believed.parameters
    settings = [w for n in changed if known.get(n) != given[n] for w in ("--set", f"{n}={given[n]}")]
    words = scenario.file or scenario.machine.name, "--law", law, *settings, "--out", f"{law}.ssv"
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


def _plant(scenario: Scenario) -> Plant:
    from warmlink.orchestration.machine.plant import plant_of

    return plant_of(scenario.machine, scenario.declared, scenario.values())


def _facts(law: str, plant: Plant, sensors: Sequence[str] = SENSED) -> dict[str, float]:
    """What a design of a law for a plant knows of it, with the thermometers that it uses."""
    from warmlink.controllers.design.shipped import PLANT_FACTS

    return by_scalar(PLANT_FACTS[law](plant, sensors))


def _alike(facts: Mapping[str, float], held: Mapping[str, float], share: float) -> bool:
    """Whether every fact is held, to within a share."""
    return all(math.isclose(held[name], fact, rel_tol=share, abs_tol=1e-12) for name, fact in facts.items())
