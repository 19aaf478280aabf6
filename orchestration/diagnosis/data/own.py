"""Anybody's system, and the heat paths that causes add between its FMUs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

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
        self.base, self.paths, self.system = base, paths, base
        self.moved: dict[str, str] = {}
        if paths:
            fmu = store(None, {HEAT_PATH.name}, remark).files({HEAT_PATH.name})[HEAT_PATH.name]
            for name, path in paths.items():
                self._add(name, path, fmu)

    def _add(self, name: str, path: AddsTable, fmu: Path) -> None:
        """Put a heat path before the inputs that it changes."""
        parts, links = dict(self.system.components), list(self.system.connections)
        if name in parts:
            raise InputError(f"{name}: {self.base.name} has a component of this name; rename the cause")
        parts[name] = component(name, fmu)
        for end, target in path.totals.items():
            info, variable, value = _variable(parts, target, f"{name}.adds")
            own, taken = to_si(info, variable), f"{end}_heat_flow"
            before = next((each for each in links if each.target == target), None)
            if before is None:
                parts[name].values[taken] = own(float(value or 0.0))
            else:
                whole = Conversion(before.factor, before.offset).then(own.factor, own.offset)
                moved = replace(before, target_component=name, target_variable=taken)
                links[links.index(before)] = replace(moved, factor=whole.factor, offset=whole.offset)
            links.append(connect(parts, f"{name}.total_{taken}", target))
            self.moved.setdefault(target, f"{name}.{taken}")
        for end, source in path.sources.items():
            # A signal may be named by the input that it feeds.
            fed = next((each.source for each in links if each.target == source), source)
            info, variable, _ = _variable(parts, fed, f"{name}.adds")
            if info.variables[variable].causality == "input":
                raise InputError(
                    f"{name}.adds: {fed}: is an input that nothing feeds in {self.base.name}, so that "
                    "nothing passes its signal on; feed it there, from a DutyCycle for example"
                )
            links.append(connect(parts, fed, f"{name}.{end}"))
        self.system = replace(self.system, components=parts, connections=tuple(links))

    def extended(self, values: Mapping[str, float]) -> System:
        """The system with values in SI by full name, and with those heat paths that carry heat."""
        used = {name: path for name, path in self.paths.items() if values.get(f"{name}.{path.parameter}")}
        bare = Own(self.base, used)
        parts = dict(bare.system.components)
        back = {path: end for end, path in self.moved.items()}
        for name, value in values.items():
            end = back.get(name, name)
            end = bare.moved.get(end, end)
            part = _owner(parts, end)
            if part:
                held, key = parts[part], end[len(part) + 1 :]
                own = from_si(read_description(held.fmu), key, value)
                parts[part] = replace(held, values={**held.values, key: own})
        checked = {name: component(name, held.fmu, held.values) for name, held in parts.items()}
        return replace(bare.system, components=checked)


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
