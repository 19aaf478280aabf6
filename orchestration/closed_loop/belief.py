"""Whether a controller was designed for the cell that it runs in, and what to do if it was not."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cached_property

from warmlink.controllers.start_values import by_scalar, design_file
from warmlink.fmus.component import Component
from warmlink.fmus.names import listed
from warmlink.fmus.records import dataclass
from warmlink.orchestration.closed_loop.load import load_scenario
from warmlink.orchestration.own_law import OwnLaw
from warmlink.orchestration.scenarios.overrides import start_value, start_values
from warmlink.orchestration.scenarios.scenario import NO_CONTROLLER, Scenario
from warmlink.orchestration.scenarios.setup import CELL
from warmlink.orchestration.system.model import StartValues
from warmlink.orchestration.system.shipped import COMPENSATOR

PLANT = ("motor", "link")
THERMOMETERS = "sensors"

SUBSTITUTE = "observer"
"""Law that can be designed for any cell; it is proposed if the one in use cannot be designed."""

_NO_PART_OF_A_DESIGN = {"sample_time", "tolerance"}


def judged(scenario: Scenario) -> tuple[str | None, bool]:
    """Judge whether a scenario's controller was designed for its system.

    The first is a sentence with the command that designs the law anew, None if the law suits the system; the
    second whether the law runs in exactly the cell that it was designed for, with thermometers without
    errors. Raises InputError if a start value does not exist or is refused.
    """
    name, setup = scenario.controller.name, scenario.setup
    if name == NO_CONTROLLER or isinstance(scenario.controller, OwnLaw):
        return None, False
    if scenario.design is None:
        told = f"{name} has no design for {setup.name}; it runs with the parameters that it is shipped with"
        return told, False
    if setup.name != CELL.name:
        return None, False
    real = _Cell(scenario.declared, scenario.parameters)
    perfect = scenario.in_use.noise is None and not real.changed(THERMOMETERS)
    return _advice(scenario), perfect and has_design(name) and real.known_to(name)


def has_design(controller: str) -> bool:
    """Whether a shipped law's parameters come from a design; this is found out without loading the design."""
    return design_file(controller).is_file()


@dataclass(frozen=True)
class _Cell:
    """Declaration behind each instance of a cell, and start values as written, by `instance.variable`."""

    components: Mapping[str, Component]
    written: Mapping[str, str | float]

    def changed(self, *instances: str) -> list[str]:
        """Names of start values that differ from what the components declare."""
        declared = {
            f"{part}.{scalar.name}": scalar.start
            for part in instances
            for scalar in self.components[part].scalars()
            if scalar.name in self.components[part].p.index
        }
        named = {name: text for name, text in self.written.items() if name in declared}
        given = {n: start_value(n, text, self.components, "start values") for n, text in named.items()}
        return [name for name, value in given.items() if value != declared[name]]

    @cached_property
    def values(self) -> StartValues:
        """The start values in SI units."""
        return start_values(self.written, self.components, "start values")

    def facts(self, law: str) -> dict[str, float]:
        """What a design of a law for this motor and link knows of them."""
        from warmlink.controllers.design.plant import cell_plant
        from warmlink.controllers.design.shipped import PLANT_FACTS

        known = ((self.values.get(part, {}), self.components[part].p.index) for part in PLANT)
        motor, link = ({n: float(v) for n, v in held.items() if n in names} for held, names in known)
        return by_scalar(PLANT_FACTS[law](cell_plant(motor, link)))

    def known_to(self, law: str) -> bool:
        """Whether a law that can be designed was designed for this motor and link."""
        if not self.changed(*PLANT, COMPENSATOR):
            return True
        declared = {scalar.name: scalar.start for scalar in self.components[COMPENSATOR].scalars()}
        held = {**declared, **self.values.get(COMPENSATOR, {})}
        return all(
            math.isclose(float(held[name] or 0.0), fact, rel_tol=1e-6, abs_tol=1e-12)
            for name, fact in self.facts(law).items()
        )


def _advice(scenario: Scenario) -> str | None:
    """What to do if the law was designed for another cell than its designer may know, mismatches apart."""
    law, believed = scenario.controller.name, scenario.as_believed.parameters
    cell = _Cell(scenario.declared, believed)
    changed = cell.changed(*PLANT)
    differing = f"differs in {listed(changed)}" if changed else "is the nominal one"

    def command(law: str) -> str:
        known = {} if scenario.file is None else load_scenario(str(scenario.file)).parameters
        settings = "".join(f' --set "{n}={believed[n]}"' for n in changed if known.get(n) != believed[n])
        return f"warmlink design {scenario.file or 'WarmupCell'} --law {law}{settings} --out {law}.ssv"

    if has_design(law):
        if cell.known_to(law):
            return None
        return (
            f"{law} was designed for another cell; this one {differing}; design it anew: "
            f"{command(law)}; then add --parameters {law}.ssv"
        )
    own = {name.partition(".")[2] for name in cell.changed(COMPENSATOR)}
    nominal = _Cell(scenario.declared, {})
    if not changed or own - _NO_PART_OF_A_DESIGN or cell.facts(SUBSTITUTE) == nominal.facts(SUBSTITUTE):
        return None
    return (
        f"the parameters of {law} suit the nominal cell; this one {differing}; tune them, or use a "
        f"law that is designed for this cell: {command(SUBSTITUTE)}; then run with "
        f"--controller {SUBSTITUTE} --parameters {SUBSTITUTE}.ssv"
    )
