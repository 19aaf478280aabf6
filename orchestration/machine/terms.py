"""Terms in a machine: where their heat enters, which variables they follow, and their FMUs.

A term has the connectors of a heat path, so that it is put into a system as one. Its law is written with full
names, as `spindle.speed`, or with those by which columns are called, as `speed` and `shaft_temperature`.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from importlib.resources import files
from pathlib import Path
from types import MappingProxyType

from warmlink.fmus.component import Component
from warmlink.fmus.component.quantities import SI_UNITS
from warmlink.fmus.component.units import BASE_UNITS, unit
from warmlink.fmus.errors import InputError
from warmlink.fmus.files import write_archive
from warmlink.fmus.heat_term.component import STORED, HeatTerm, heat_term, stored
from warmlink.fmus.heat_term.dimension import refuse_other_than_heat
from warmlink.fmus.heat_term.law import HeatLaw, identifier
from warmlink.fmus.names import instead, listed
from warmlink.fmus.packaging.cache import undamaged, vouch
from warmlink.orchestration.catalogue import Entry, made_module
from warmlink.orchestration.fmu_store import FmuStore
from warmlink.orchestration.machine.rig import Rig
from warmlink.orchestration.system.units import parse_unit, spelled
from warmlink.orchestration.written.quantities import number_and_unit, quantity

PLACES = {
    "shaft": ("motor", "added_shaft_heat"),
    "winding": ("motor", "added_winding_heat"),
    "base": ("link", "heat_flow"),
    "tip": ("link", "tip_heat_flow"),
}
"""Kind of part, and its input, by the place that heat may enter."""

NAMED = {
    **{name: ("motor", name) for name in ("speed", "torque", "current", "neighbour_temperature")},
    **{name: ("motor", name) for name in ("shaft_temperature", "winding_temperature")},
    **{name: ("link", name) for name in ("ambient_temperature", "base_temperature", "tip_temperature")},
    "middle_temperature": ("link", "sensor_temperature[2]"),
    **{name: ("motor", name) for name in ("pad_temperature", "pad_power", "pad_mode")},
}
"""Kind of part, and its variable, by the name of a variable in a law that is written without an instance."""

_MODULE = """from warmlink.fmus.heat_term.component import HeatTerm, heat_term

COMPONENT = heat_term(
    HeatTerm({name!r}, {heat!r}, {inputs!r}, {parameters!r}, {starts!r})
)
"""


@dataclass(frozen=True)
class PlacedTerm:
    """A term at its place in a machine.

    Attributes
    ----------
    term : the term
    into : full name of the input that takes its heat, as `link.heat_flow`
    variables : full name of the machine's variable behind each name in its law
    """

    term: HeatTerm
    into: str
    variables: Mapping[str, str]

    parameter = ""
    """It carries heat whatever its parameters are."""

    @property
    def totals(self) -> dict[str, str]:
        """Input that its end goes before."""
        return {"to": self.into}

    @property
    def sources(self) -> dict[str, str]:
        """Variable behind each of its component's inputs."""
        return {identifier(name): full for name, full in self.variables.items()}

    @cached_property
    def component(self) -> Component:
        """The term as a component."""
        return heat_term(self.term)

    def fmu(self, store: FmuStore) -> Path:
        """The term's FMU, from the store, built where it is missing."""
        return term_fmu(self.term, store)


def placed_term(
    rig: Rig,
    name: str,
    heat: str,
    into: str,
    parameters: Mapping[str, str | float],
    where: str,
    inputs: Mapping[str, str | float] = MappingProxyType({}),
) -> PlacedTerm:
    """Place a term that somebody wrote.

    Parameters
    ----------
    rig : the machine
    name : of the term's instance
    heat : its law, see `fmus/heat_term/law.py`
    into : `shaft`, `winding`, `base`, `tip`, or the full name of an input in W
    parameters : values by name, with units; bare numbers are in SI and take the unit that is due
    where : the place in a file that stands before an error message
    inputs : values by name, as the parameters', of what a column of the log may drive, as `name.input`

    Raises
    ------
    InputError
        The name is taken, the law is no expression for heat, or it names what is not there.
    """
    if not name.isidentifier():
        raise InputError(f"{where}: {name!r} is no name; use letters, digits and underscores")
    if name in rig.machine.parts:
        raise InputError(f"{where}: {rig.name} has a part called {name}; rename the term")
    law = HeatLaw(heat, f"{where}.heat")
    given = {key: _parameter(text, f"{where}.parameters.{key}") for key, text in parameters.items()}
    driven = {key: _parameter(text, f"{where}.inputs.{key}") for key, text in inputs.items()}
    for table, held in (("parameters", given), ("inputs", driven)):
        for key in held:
            if key not in law.variables:
                raise InputError(f"{where}.{table}: {key} is not in the law {heat!r}; leave it out")
    if both := [key for key in given if key in driven]:
        raise InputError(f"{where}: {listed(both)} cannot be a parameter and an input; name it once")
    variables = {
        each: _variable(rig, each, (*given, *driven), f"{where}.heat")
        for each in law.variables
        if each not in given and each not in driven
    }
    own = {key: unit for key, (_, unit) in driven.items()}
    units = {each: _scalar_unit(rig, full) for each, full in variables.items()} | own
    bare = {key for key, text in parameters.items() if not number_and_unit(text, "1")[1]}
    known = {**units, **{key: None if key in bare else each for key, (_, each) in given.items()}}
    refuse_other_than_heat(law, known)
    called = "".join(part[:1].upper() + part[1:] for part in name.split("_")) + "Term"
    starts = {key: value for key, (value, _) in driven.items()}
    term = HeatTerm(called, heat, units, given, starts)
    placed = PlacedTerm(term, _into(rig, into, f"{where}.into"), variables)
    _ = placed.component
    return placed


def with_terms(rig: Rig, terms: Mapping[str, PlacedTerm]) -> Rig:
    """The same rig with the equations of terms in it, by the names of their instances; no FMU is built."""
    machine, foreign = rig.machine, dict(rig.foreign)
    wires, parts = dict(machine.fed), dict(machine.parts)
    signals, scaled = dict(machine.signals), dict(machine.scaled)
    for name, placed in terms.items():
        parts[name], foreign[name] = placed.term.name, placed.component
        ahead = f"{name}.to_heat_flow"
        if placed.into in wires:
            wires[ahead] = wires[placed.into]
        if placed.into in scaled:
            scaled[ahead] = scaled.pop(placed.into)
        wires[placed.into] = f"{name}.total_to_heat_flow"
        for variable, full in placed.sources.items():
            target = f"{name}.{variable}"
            group = next((key for key, ends in signals.items() if full in ends), full)
            if full in rig.variables and rig.variables[full].start is None:
                wires[target] = full
            elif full in wires:
                wires[target] = wires[full]
            else:
                signals[group] = (*signals.get(group, (full,)), target)
    changed = replace(
        machine,
        parts=parts,
        wires=tuple((source, target) for target, source in wires.items()),
        signals=signals,
        scaled=scaled,
    )
    return replace(rig, machine=changed, foreign=foreign)


def term_fmu(term: HeatTerm, store: FmuStore) -> Path:
    """FMU of a term, which holds the term itself and whose documentation holds the equation."""
    from warmlink.fmus.packaging.native.compile import compilers, platforms_named
    from warmlink.fmus.packaging.native.fmu import native_fmu_files
    from warmlink.fmus.packaging.python.fmu import python_fmu_files

    content = stored(term)
    digest = hashlib.sha256(content).hexdigest()[:16]
    place = Path("terms") / digest / f"{term.name}.fmu"
    path = store.file(place)
    if undamaged(path):
        return path
    about = (files("warmlink.fmus.heat_term") / "README.md").read_text("utf-8")
    about = about.replace("# HeatTerm", f"# {term.name}", 1).replace(
        "## Assumptions", f"The equation of this term:\n\n{term.equation}\n\n## Assumptions", 1
    )
    fields = {each: dict(getattr(term, each)) for each in ("inputs", "parameters", "starts")}
    module = _MODULE.format(name=term.name, heat=term.heat, **fields)
    home = made_module(f"warmlink_term_{digest}", {"component.py": module, "README.md": about})
    entry = Entry(heat_term(term), f"{home}.component")
    if store.kind == "python":
        held = python_fmu_files(entry)
    else:
        held = native_fmu_files(entry, "2.0", compilers(platforms_named(None)))
    path = store.folder / place
    write_archive(path, {**held, STORED: content})
    vouch(path)
    return path


def _parameter(text: str | float, where: str) -> tuple[float, str]:
    """Value in SI of a parameter, and its unit."""
    _, written = number_and_unit(text, "1", where)
    if not written:
        return quantity(text, "1", where), "1"
    try:
        meant = parse_unit(spelled(written, "1"))
    except InputError as fault:
        raise InputError(f"{where}: {fault}") from None
    powers = zip(BASE_UNITS, meant.exponents or (), strict=False)
    plain = ".".join(base if power == 1 else f"{base}{power}" for base, power in powers if power) or "1"
    return quantity(text, _readable(written, plain), where), _readable(written, plain)


def _readable(written: str, plain: str) -> str:
    """The unit as it was written if that is an SI unit in Modelica's notation, else a usual one like it."""
    with suppress(ValueError):
        meant = unit(written)
        if (meant.factor, meant.offset) == (1, 0):
            return written
    return next((each for each in SI_UNITS if unit(each).exponents == unit(plain).exponents), plain)


def _variable(rig: Rig, name: str, parameters: tuple[str, ...], where: str) -> str:
    """Full name of the machine's variable that a name in a law stands for."""
    if "." in name:
        _scalar_unit(rig, name, where)
        return name
    kind, variable = NAMED.get(name, ("", ""))
    for part in rig.called(kind) if kind else ():
        with_part = f"{part}.{variable}"
        if _known(rig, with_part):
            return with_part
    known = (*parameters, *(each for each in NAMED if rig.called(NAMED[each][0])))
    raise InputError(
        f"{where}: {name} is neither a variable of {rig.name} nor under parameters or inputs; "
        f"{instead(name, known)}"
    )


def _known(rig: Rig, full: str) -> bool:
    part = rig.part_of(full)
    scalars = rig.components[part].scalars() if part in rig.components else ()
    return any(f"{part}.{each.name}" == full for each in scalars)


def _scalar_unit(rig: Rig, full: str, where: str = "") -> str:
    part = rig.part_of(full)
    scalars = rig.components[part].scalars() if part in rig.components else ()
    found = {f"{part}.{each.name}": each.variable.unit for each in scalars}
    if full not in found:
        raise InputError(
            f"{where}: {rig.name} has no variable {full}; {instead(full, found or rig.components)}"
        )
    return found[full]


def _into(rig: Rig, into: str, where: str) -> str:
    """Full name of the input that takes a term's heat."""
    if into in PLACES:
        kind, variable = PLACES[into]
        found = rig.called(kind)
        if not found:
            raise InputError(
                f"{where}: {rig.name} has no {kind} of warmlink's; name an input in W, as column.heat_flow"
            )
        into = f"{found[0]}.{variable}"
    if _scalar_unit(rig, into, where) != "W":
        known = instead("", PLACES, "or name an input that takes heat")
        raise InputError(f"{where}: {into} is in {_scalar_unit(rig, into)}, not in W; {known}")
    part = rig.part_of(into)
    if into.removeprefix(f"{part}.") not in rig.components[part].u.index:
        raise InputError(f"{where}: {into} is no input; name the input that takes the heat")
    return into
