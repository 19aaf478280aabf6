"""The rig of any system: a shipped one, or what the FMUs of anybody's declare, in SI units."""

from __future__ import annotations

from pathlib import Path
from types import MappingProxyType

from warmlink.fmus.component import Component, Input, Output, Parameter
from warmlink.fmus.component.units import BASE_UNITS
from warmlink.orchestration.catalogue import controller, reduced_link_in
from warmlink.orchestration.console import remark
from warmlink.orchestration.diagnosis.data.own import Own, Paths, to_si
from warmlink.orchestration.diagnosis.data.rig import Rig, rig
from warmlink.orchestration.fmu_store import store
from warmlink.orchestration.scenarios.own_system import blueprint_of
from warmlink.orchestration.system.assemble import read_system
from warmlink.orchestration.system.check import own_unit
from warmlink.orchestration.system.description import ModelInfo, read_description
from warmlink.orchestration.system.replacement import NOTHING_REPLACED, Replacements
from warmlink.orchestration.system.units import Unit, meaning


def rig_of(
    name: str,
    folder: Path = Path(),
    paths: Paths = MappingProxyType({}),
    looped: bool = False,
    replaced: Replacements | None = None,
) -> Rig:
    """Rig of a system that an experiment names: a shipped one, or an .ssp file in a folder.

    With heat paths that causes may add, or FMUs in place of its parts; `looped` as of `rig_of_own`.
    InputError is raised where there is no such system, or something does not fit it.
    """
    changed = replaced or NOTHING_REPLACED
    if name.lower().endswith((".ssp", ".ssd")):
        base = read_system(folder / name)
    elif paths or looped or changed.fmus:
        shipped, none = rig(name).blueprint, controller("none").name
        kinds = set(shipped.components_with(none).values())
        base = shipped.system(store(None, sorted(kinds), remark).files(kinds), none)
    else:
        return rig(name)
    return rig_of_own(Own(changed.in_system(base), paths), looped)


def rig_of_own(own: Own, looped: bool = False) -> Rig:
    """Rig of a system of one's own; `looped`: in a loop of its FMUs, even where every part is known."""
    parts = own.system.components
    blueprint, files = blueprint_of(own.system)
    infos = {name: read_description(held.fmu) for name, held in parts.items()}
    foreign = {
        name: reduced_link_in(files[kind]) or _declaration(infos[name])
        for name, kind in blueprint.components.items()
        if kind in files
    }
    values = {
        name: {
            key: value if isinstance(value, str) else to_si(infos[name], key)(float(value))
            for key, value in held.values.items()
        }
        for name, held in parts.items()
    }
    return Rig(blueprint, values=values, foreign=foreign, looped=looped, own=own)


def _declaration(info: ModelInfo) -> Component:
    """What an FMU says of itself, as a component without equations, in SI units."""
    inputs: list[Input] = []
    parameters: list[Parameter] = []
    outputs: list[Output] = []
    for name, variable in info.variables.items():
        kind = "Integer" if variable.kind == "Enumeration" else variable.kind
        if kind not in ("Real", "Integer", "Boolean") or variable.dimensions:
            continue
        own, about = meaning(own_unit(info, variable) or Unit("1")), variable.description
        powers = zip(BASE_UNITS, own.exponents or (), strict=False)
        plain = ".".join(base if n == 1 else f"{base}{n}" for base, n in powers if n) or "1"
        unit = own.name if (own.factor, own.offset) == (1.0, 0.0) else plain
        display = "degC" if unit == "K" and not variable.relative else None
        start = to_si(info, name)(float(variable.start or 0.0))
        if variable.causality == "input":
            inputs.append(Input(name, unit, about, start=start, display=display, type=kind))
        elif variable.causality == "parameter" and variable.settable:
            tunable = variable.variability == "tunable"
            parameters.append(
                Parameter(name, unit, start, about, display=display, type=kind, tunable=tunable)
            )
        elif variable.causality == "output":
            outputs.append(Output(name, unit, about, display=display, type=kind))
    parts = tuple(inputs), tuple(parameters)
    return Component(info.model_name, info.description, lambda x, u, p, t: {}, *parts, outputs=tuple(outputs))
