"""A rig of anybody's system: what its FMUs declare, and the heat paths that causes add between them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType

from warmlink.fmus.component import Component, Input, Output, Parameter
from warmlink.fmus.component.units import BASE_UNITS
from warmlink.fmus.errors import InputError
from warmlink.fmus.heat_path.component import COMPONENT as HEAT_PATH
from warmlink.fmus.names import instead
from warmlink.orchestration.catalogue import controller
from warmlink.orchestration.console import remark
from warmlink.orchestration.diagnosis.causes.declared import AddsTable
from warmlink.orchestration.diagnosis.data.rig import Rig, rig
from warmlink.orchestration.fmu_store import store
from warmlink.orchestration.scenarios.own_system import parts_of
from warmlink.orchestration.system.assemble import component, connect
from warmlink.orchestration.system.check import own_unit, variable_of
from warmlink.orchestration.system.description import ModelInfo, Variable, read_description
from warmlink.orchestration.system.model import Component as Part
from warmlink.orchestration.system.model import System, Value
from warmlink.orchestration.system.read import read_system
from warmlink.orchestration.system.replacement import Replacements
from warmlink.orchestration.system.shipped import Blueprint
from warmlink.orchestration.system.units import Conversion, Unit, meaning

Paths = Mapping[str, AddsTable]
"""Heat paths by the name of their cause, which is that of their instance."""


@dataclass(frozen=True, eq=False)
class Own:
    """A system of one's own.

    Attributes
    ----------
    base : as it was given
    paths : heat paths that causes may add
    system : with all of these
    moved : input of a heat path that stands for each input before which one was put
    """

    base: System
    paths: Paths
    system: System
    moved: Mapping[str, str]

    @classmethod
    def of(cls, base: System, paths: Paths) -> Own:
        """A system and the heat paths that causes may add to it; raises InputError where one does not fit."""
        system, moved = _with_paths(base, paths)
        return cls(base, paths, system, moved)

    def rig(self, looped: bool = False) -> Rig:
        """Rig of the system; `looped`: in a loop of its FMUs, even where every part is known."""
        kinds, files = parts_of(self.system)
        infos = {name: read_description(held.fmu) for name, held in self.system.components.items()}
        foreign = {name: _declaration(infos[name]) for name, kind in kinds.items() if kind in files}
        values = {
            name: {key: in_si(infos[name], key, value) for key, value in held.values.items()}
            for name, held in self.system.components.items()
        }
        wires = tuple((each.source, each.target) for each in self.system.connections)
        step = self.system.default_experiment.step_size or 1.0
        blueprint = Blueprint(self.system.name, "", kinds, wires, step_size=step)
        return Rig(blueprint, values=values, foreign=foreign, looped=looped, moved=self.moved, own=self)

    def extended(self, values: Mapping[str, float]) -> System:
        """The system with values in SI by full name, and with those heat paths that carry heat."""
        used = {name: path for name, path in self.paths.items() if values.get(f"{name}.{path.parameter}")}
        system, moved = _with_paths(self.base, used)
        by_part: dict[str, dict[str, Value]] = {name: dict(c.values) for name, c in system.components.items()}
        back = {path: end for end, path in self.moved.items()}
        for name, value in values.items():
            end = back.get(name, name)
            end = moved.get(end, end)
            part = max((p for p in by_part if end.startswith(f"{p}.")), key=len, default="")
            if part:
                info, key = read_description(system.components[part].fmu), end[len(part) + 1 :]
                by_part[part][key] = from_si(info, key, value)
        parts = {name: component(name, c.fmu, by_part[name]) for name, c in system.components.items()}
        return replace(system, components=parts)


def rig_of(
    name: str,
    folder: Path = Path(),
    paths: Paths = MappingProxyType({}),
    looped: bool = False,
    replaced: Replacements | None = None,
) -> Rig:
    """Rig of a system that an experiment names.

    Parameters
    ----------
    name : of a shipped system, or of an .ssp file
    folder : in which the file is
    paths : heat paths that causes may add
    looped : whether its FMUs are simulated in a loop, even where every part is known
    replaced : FMUs in place of its parts

    Raises
    ------
    InputError
        There is no such system, or something does not fit it.
    """
    is_file = name.lower().endswith((".ssp", ".ssd"))
    changed = replaced is not None and bool(replaced.fmus)
    if not (is_file or paths or looped or changed):
        return rig(name)
    base = read_system(folder / name) if is_file else _shipped(rig(name).blueprint)
    if replaced is not None:
        base = replaced.in_system(base)
    return Own.of(base, paths).rig(looped)


def _shipped(blueprint: Blueprint) -> System:
    """A shipped system with its FMUs, and no compensation."""
    none = controller("none").name
    kinds = set(blueprint.components_with(none).values())
    return blueprint.system(store(None, sorted(kinds), remark).files(kinds), none)


def to_si(info: ModelInfo, name: str) -> Conversion:
    """Conversion of a variable's values from its own unit to SI."""
    variable = info.variables[name]
    unit = meaning(own_unit(info, variable) or Unit("1"))
    return Conversion(unit.factor, 0.0 if variable.relative else unit.offset)


def in_si(info: ModelInfo, name: str, value: Value) -> Value:
    """A start value in SI; a text stays."""
    return value if isinstance(value, str) else to_si(info, name)(float(value))


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
            info, variable, value = _input(parts, target, f"{name}.adds")
            own, taken = to_si(info, variable), f"{end}_heat_flow"
            if before is None:
                parts[name].values[taken] = own(float(value or 0.0))
            else:
                whole = Conversion(before.factor, before.offset).then(own.factor, own.offset)
                there = replace(before, target_component=name, target_variable=taken)
                there = replace(there, factor=whole.factor, offset=whole.offset)
                connections[connections.index(before)] = there
            connections.append(connect(parts, f"{name}.total_{taken}", target))
            moved.setdefault(target, f"{name}.{taken}")
        for end, source in path.sources.items():
            # A signal may be named by the input that it feeds.
            fed = next((each.source for each in connections if each.target == source), source)
            connections.append(connect(parts, fed, f"{name}.{end}"))
    return replace(system, components=parts, connections=tuple(connections)), moved


def _input(parts: Mapping[str, Part], target: str, where: str) -> tuple[ModelInfo, str, Value | None]:
    """The FMU of an input, the input's name there and its start value."""
    owner = next((name for name in sorted(parts, key=len, reverse=True) if target.startswith(f"{name}.")), "")
    if not owner:
        raise InputError(f"{where}: {target}: there is no such component; {instead(target, parts)}")
    info, name = read_description(parts[owner].fmu), target[len(owner) + 1 :]
    found = variable_of(info, name, f"{where}: {target}")
    return info, name, parts[owner].values.get(name, found.start)


def _declaration(info: ModelInfo) -> Component:
    """What an FMU says of itself, as a component without equations, in SI units."""
    inputs: list[Input] = []
    parameters: list[Parameter] = []
    outputs: list[Output] = []
    for variable in info.variables.values():
        if variable.kind not in ("Real", "Integer", "Boolean") or variable.dimensions:
            continue
        unit, display = _unit(info, variable)
        about = variable.description
        kind = variable.kind
        start = to_si(info, variable.name)(float(variable.start or 0.0))
        if variable.causality == "input":
            inputs.append(Input(variable.name, unit, about, start=start, display=display, type=kind))
        elif variable.causality == "parameter" and variable.settable:
            tunable = variable.variability == "tunable"
            parameters.append(
                Parameter(variable.name, unit, start, about, display=display, type=kind, tunable=tunable)
            )
        elif variable.causality == "output":
            outputs.append(Output(variable.name, unit, about, display=display, type=kind))
    return Component(
        info.model_name,
        info.description,
        lambda x, u, p, time: {},
        tuple(inputs),
        tuple(parameters),
        outputs=tuple(outputs),
    )


def _unit(info: ModelInfo, variable: Variable) -> tuple[str, str | None]:
    """SI unit of a variable, and the unit in which people read it, if that is another one."""
    own = meaning(own_unit(info, variable) or Unit("1"))
    powers = [(base, n) for base, n in zip(BASE_UNITS, own.exponents or (), strict=False) if n]
    parts = [base if n == 1 else f"{base}{n}" for base, n in powers]
    name = own.name if (own.factor, own.offset) == (1.0, 0.0) else ".".join(parts) or "1"
    return name, "degC" if name == "K" and not variable.relative else None
