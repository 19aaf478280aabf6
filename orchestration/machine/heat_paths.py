"""Rigs of FMUs: what they declare, and the heat paths that causes add between them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

from warmlink.fmus.component import Component, Input, Output, Parameter
from warmlink.fmus.component.units import BASE_UNITS
from warmlink.fmus.errors import InputError
from warmlink.fmus.heat_path.component import COMPONENT as HEAT_PATH
from warmlink.orchestration.catalogue import controller
from warmlink.orchestration.console import remark, remark_once
from warmlink.orchestration.fmu_store import FmuStore, store
from warmlink.orchestration.machine.added_heat import HeatPath, Paths
from warmlink.orchestration.machine.machine import Machine
from warmlink.orchestration.machine.read import NamedMachine, machine_of, with_roles
from warmlink.orchestration.machine.rig import Rig, rig
from warmlink.orchestration.system.assemble import component, connected, end_of, owner_of, read_system
from warmlink.orchestration.system.check import own_unit, variable_of
from warmlink.orchestration.system.description import ModelInfo, read_description
from warmlink.orchestration.system.model import Connection, FmuPart, System, Value
from warmlink.orchestration.system.replacement import NOTHING_REPLACED, Replacements
from warmlink.orchestration.system.units import Conversion, Unit, meaning


def rig_of(
    name: str,
    folder: Path = Path(),
    paths: Paths = MappingProxyType({}),
    looped: bool = False,
    replaced: Replacements | None = None,
) -> Rig:
    """Rig of a system that an experiment names: a shipped one, or an .ssp file in a folder.

    With heat paths that causes may add, or FMUs in place of its parts; `looped` as of `rig_in`.
    InputError is raised if there is no such system, or something does not fit it.
    """
    changed = replaced or NOTHING_REPLACED
    named = NamedMachine(name, None, name, folder).followed()
    if named.path is None and not (paths or looped or changed.fmus):
        return rig(named.system)
    if named.path is None:
        base = built_system(rig(named.system).machine)
    else:
        base = read_system(named.path, variant=named.variant)
    for told in base.remarks:
        remark_once(told)
    return rig_in(changed.in_system(base), paths, looped, named)


def built_system(machine: Machine, built: FmuStore | None = None) -> System:
    """FMUs of a machine with no controller at work; by default of the kind that can be built."""
    none = controller("none").name
    kinds = sorted(set(machine.parts_with(none).values()) - machine.foreign.keys())
    return machine.system((built or store(None, kinds, remark)).files(kinds), none)


def rig_in(
    base: System, paths: Paths = MappingProxyType({}), looped: bool = False, named: NamedMachine | None = None
) -> Rig:
    """Rig of a system of FMUs, with the heat paths that causes may add.

    `looped`: in a loop of its FMUs, even where every part is known; `named`: the file with its roles, if any.
    InputError where a path or a role does not fit.
    """
    parts = _parts_of(paths)
    system, moved = _wired(base, paths, parts)
    machine = _with_roles_of(named, system)
    foreign: dict[str, Component] = {}
    nominal: dict[str, dict[str, Value]] = {}
    for name, part in system.components.items():
        info, kind, given = read_description(part.fmu), machine.parts[name], part.values.items()
        if kind in machine.foreign:
            foreign[name] = machine.reduced.get(kind) or machine.terms.get(kind) or _declaration(info)
        nominal[name] = {k: v if isinstance(v, str) else _to_si(info, k)(float(v)) for k, v in given}
    return Rig(
        replace(machine, nominal=nominal),
        foreign=foreign,
        looped=looped or bool(machine.scaled),
        system=system,
        base=base,
        paths=paths,
        parts_of_paths=parts,
        moved=moved,
        source=None if named is None else named.source,
    )


def _with_roles_of(named: NamedMachine | None, system: System) -> Machine:
    if named is None or (named.path is not None and named.roles is None):
        return machine_of(system)
    if named.roles is not None:
        return with_roles(system, named.roles, f"{named.where}: roles")
    shipped = rig(named.system).machine
    return replace(machine_of(system, shipped.controllers), roles=shipped.roles)


def _declaration(info: ModelInfo) -> Component:
    """What an FMU says of itself, as a component without equations, in SI units."""
    found: dict[str, list[Any]] = {"input": [], "parameter": [], "output": []}
    for name, variable in info.variables.items():
        kind = "Integer" if variable.kind == "Enumeration" else variable.kind
        if kind not in ("Real", "Integer", "Boolean") or variable.dimensions:
            continue
        own, causality = meaning(own_unit(info, variable) or Unit("1")), variable.causality
        powers = zip(BASE_UNITS, own.exponents or (), strict=False)
        plain = ".".join(base if n == 1 else f"{base}{n}" for base, n in powers if n) or "1"
        unit = own.name if (own.factor, own.offset) == (1.0, 0.0) else plain
        how: dict[str, Any] = {"description": variable.description, "type": kind}
        how["display"] = "degC" if unit == "K" and not variable.relative else None
        start = _to_si(info, name)(float(variable.start or 0.0))
        if causality == "input":
            found[causality].append(Input(name, unit, start=start, **how))
        elif causality == "parameter" and variable.settable:
            tunable = variable.variability == "tunable"
            found[causality].append(Parameter(name, unit, start, tunable=tunable, **how))
        elif causality == "output":
            found[causality].append(Output(name, unit, **how))
    inputs, parameters, outputs = map(tuple, found.values())
    return Component(
        info.model_name, info.description, lambda x, u, p, t: {}, inputs, parameters, outputs=outputs
    )


def with_paths(base: System, paths: Paths) -> tuple[System, dict[str, str]]:
    """A system with heat paths that causes may add, and terms; and the new name of each input behind one.

    InputError where one does not fit.
    """
    return _wired(base, paths, _parts_of(paths))


def _parts_of(paths: Paths) -> dict[str, FmuPart]:
    """The FMUs of heat paths, built where they are missing, by the names of the paths."""
    built = store(None, {HEAT_PATH.name}, remark) if paths else None
    return {} if built is None else {name: component(name, path.fmu(built)) for name, path in paths.items()}


def _wired(base: System, paths: Paths, parts: Mapping[str, FmuPart]) -> tuple[System, dict[str, str]]:
    """As `with_paths`, with FMUs that are there."""
    system, moved = base, dict[str, str]()
    for name, path in paths.items():
        system = _with_path(system, name, path, parts[name], moved)
    return system, moved


def _with_path(system: System, name: str, path: HeatPath, part: FmuPart, moved: dict[str, str]) -> System:
    """Put a heat path before the inputs that it changes, and note in `moved` what they are called then."""
    where = f"{name}.adds"
    if name in system.components:
        raise InputError(f"{name}: {system.name} has a component of this name; rename the cause")
    parts = {**system.components, name: replace(part, values=dict(part.values))}
    links = {each.target: each for each in system.connections}
    for end, target in path.totals.items():
        unit, taken = unit_of(system, target), f"{end}_heat_flow"
        if target in links:
            led = links[target]
            whole = Conversion(led.factor, led.offset).then(unit.factor, unit.offset)
            links[f"{name}.{taken}"] = Connection(*led.ends[0], name, taken, whole.factor, whole.offset)
        else:
            parts[name].values[taken] = value_of(system, target)
        (links[target],) = connected(parts, [(f"{name}.total_{taken}", target)])
        moved.setdefault(target, f"{name}.{taken}")
    for end, source in path.sources.items():
        # A signal may be named by the input that it feeds.
        fed = links[source].source if source in links else source
        _, info, variable = _located(system, fed, where)
        if info.variables[variable].causality == "input" and not path.parameter:
            continue  # whoever feeds the one input feeds the term's too
        if info.variables[variable].causality == "input":
            raise InputError(
                f"{where}: {fed}: is an input that nothing feeds in {system.name}, so that "
                "nothing passes its signal on; feed it there, from a DutyCycle for example"
            )
        (links[f"{name}.{end}"],) = connected(parts, [(fed, f"{name}.{end}")])
    return replace(system, components=parts, connections=tuple(links.values()))


def extended(rig: Rig, values: Mapping[str, float], built: FmuStore) -> System:
    """The rig's FMUs with values in SI by full name, and with those heat paths that carry heat.

    What a shipped machine lacks of FMUs is built into a store.
    """
    base = rig.base or built_system(rig.machine, built)
    used = {
        name: path
        for name, path in rig.paths.items()
        if not path.parameter or values.get(f"{name}.{path.parameter}")
    }
    # A term that a diagnosis found is built now; what causes may add was built with the rig.
    own = {n: component(n, path.fmu(built)) for n, path in used.items() if n not in rig.parts_of_paths}
    bare, moved = _wired(base, used, {**rig.parts_of_paths, **own})
    back = {path: end for end, path in rig.moved.items()}
    ends = {back.get(name, name): value for name, value in values.items()}
    found = with_values(bare, {moved.get(end, end): value for end, value in ends.items()})
    checked = {name: component(name, held.fmu, held.values) for name, held in found.components.items()}
    return replace(found, components=checked)


def with_values(system: System, values: Mapping[str, float]) -> System:
    """A system with start values in SI by full name; names that match no part are ignored."""
    parts = dict(system.components)
    for name, value in values.items():
        if part := owner_of(parts, name):
            held, key = parts[part], name[len(part) + 1 :]
            info = read_description(held.fmu)
            unit, kind = _to_si(info, key), info.variables[key].kind
            own = (value - unit.offset) / unit.factor
            given: Value = bool(own) if kind == "Boolean" else own if kind == "Real" else round(own)
            parts[part] = replace(held, values={**held.values, key: given})
    return replace(system, components=parts)


def value_of(system: System, name: str) -> float:
    """Start value of a variable in SI, by its full name: that of the system, or what its FMU declares."""
    part, info, variable = _located(system, name, system.name)
    given = system.components[part].values.get(variable, info.variables[variable].start)
    return _to_si(info, variable)(float(given or 0.0))


def unit_of(system: System, name: str) -> Conversion:
    """Conversion of the values of a variable, by its full name, from its own unit to SI."""
    return _to_si(*_located(system, name, system.name)[1:])


def _to_si(info: ModelInfo, name: str) -> Conversion:
    variable = info.variables[name]
    unit = meaning(own_unit(info, variable) or Unit("1"))
    return Conversion(unit.factor, 0.0 if variable.relative else unit.offset)


def _located(system: System, name: str, where: str) -> tuple[str, ModelInfo, str]:
    """Part of a system whose variable a full name is, its FMU, and the variable's name there."""
    part, key = end_of(system.components, name, where)
    info = read_description(system.components[part].fmu)
    variable_of(info, key, f"{where}: {name}")
    return part, info, key
