"""Anybody's system, and the heat paths that causes add between its FMUs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from warmlink.fmus.errors import InputError
from warmlink.fmus.heat_path.component import COMPONENT as HEAT_PATH
from warmlink.fmus.names import instead
from warmlink.orchestration.console import remark
from warmlink.orchestration.diagnosis.causes.declared import AddsTable
from warmlink.orchestration.fmu_store import store
from warmlink.orchestration.system.assemble import component, connect
from warmlink.orchestration.system.check import own_unit, variable_of
from warmlink.orchestration.system.description import ModelInfo, read_description
from warmlink.orchestration.system.model import Component as Part
from warmlink.orchestration.system.model import System, Value
from warmlink.orchestration.system.units import Conversion, Unit, meaning

Paths = Mapping[str, AddsTable]
"""Heat paths by the name of their cause, which is that of their instance."""


class Own:
    """A system of one's own, with the heat paths that causes may add to its `base`.

    `moved` is the input of a heat path that stands for each input before which one was put. InputError is
    raised where a path does not fit.
    """

    def __init__(self, base: System, paths: Paths) -> None:
        self.base, self.paths = base, paths
        self.system, self.moved = _with_paths(base, paths)

    def extended(self, values: Mapping[str, float]) -> System:
        """The system with values in SI by full name, and with those heat paths that carry heat."""
        used = {name: path for name, path in self.paths.items() if values.get(f"{name}.{path.parameter}")}
        system, moved = _with_paths(self.base, used)
        by_part: dict[str, dict[str, Value]] = {name: dict(c.values) for name, c in system.components.items()}
        back = {path: end for end, path in self.moved.items()}
        for name, value in values.items():
            end = back.get(name, name)
            end = moved.get(end, end)
            part = _owner(by_part, end)
            if part:
                info, key = read_description(system.components[part].fmu), end[len(part) + 1 :]
                by_part[part][key] = from_si(info, key, value)
        parts = {name: component(name, c.fmu, by_part[name]) for name, c in system.components.items()}
        return replace(system, components=parts)


def to_si(info: ModelInfo, name: str) -> Conversion:
    """Conversion of a variable's values from its own unit to SI."""
    variable = info.variables[name]
    unit = meaning(own_unit(info, variable) or Unit("1"))
    return Conversion(unit.factor, 0.0 if variable.relative else unit.offset)


def from_si(info: ModelInfo, name: str, value: float) -> Value:
    """A value in SI as the FMU takes it."""
    given, kind = to_si(info, name), info.variables[name].kind
    own = (value - given.offset) / given.factor
    return bool(own) if kind == "Boolean" else own if kind == "Real" else round(own)


def _with_paths(system: System, paths: Paths) -> tuple[System, dict[str, str]]:
    """A system with heat paths before inputs, and the input of a path that stands for each such input."""
    if not paths:
        return system, {}
    parts, connections = dict(system.components), list(system.connections)
    file = store(None, {HEAT_PATH.name}, remark).files({HEAT_PATH.name})[HEAT_PATH.name]
    moved: dict[str, str] = {}
    for name, path in paths.items():
        if name in parts:
            raise InputError(f"{name}: {system.name} has a component of this name; rename the cause")
        parts[name] = component(name, file)
        for end, target in path.totals.items():
            before = next((each for each in connections if each.target == target), None)
            info, variable, value = _variable(parts, target, f"{name}.adds")
            own, taken = to_si(info, variable), f"{end}_heat_flow"
            if before is None:
                parts[name].values[taken] = own(float(value or 0.0))
            else:
                whole = Conversion(before.factor, before.offset).then(own.factor, own.offset)
                connections[connections.index(before)] = replace(
                    before,
                    target_component=name,
                    target_variable=taken,
                    factor=whole.factor,
                    offset=whole.offset,
                )
            connections.append(connect(parts, f"{name}.total_{taken}", target))
            moved.setdefault(target, f"{name}.{taken}")
        for end, source in path.sources.items():
            # A signal may be named by the input that it feeds.
            fed = next((each.source for each in connections if each.target == source), source)
            info, variable, _ = _variable(parts, fed, f"{name}.adds")
            if info.variables[variable].causality == "input":
                raise InputError(
                    f"{name}.adds: {fed}: is an input that nothing feeds in {system.name}, so that nothing "
                    "passes its signal on; feed it there, from a DutyCycle for example"
                )
            connections.append(connect(parts, fed, f"{name}.{end}"))
    return replace(system, components=parts, connections=tuple(connections)), moved


def _variable(parts: Mapping[str, Part], target: str, where: str) -> tuple[ModelInfo, str, Value | None]:
    """The FMU of a variable, the variable's name there and its start value."""
    owner = _owner(parts, target)
    if not owner:
        raise InputError(f"{where}: {target}: there is no component of this name; {instead(target, parts)}")
    info, name = read_description(parts[owner].fmu), target[len(owner) + 1 :]
    found = variable_of(info, name, f"{where}: {target}")
    return info, name, parts[owner].values.get(name, found.start)


def _owner(parts: Mapping[str, object], name: str) -> str:
    """Part whose variable a full name is; empty where it is none's."""
    return max((each for each in parts if name.startswith(f"{each}.")), key=len, default="")
