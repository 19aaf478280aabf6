"""The rig of anybody's system: what its FMUs declare, in SI units."""

from __future__ import annotations

from pathlib import Path
from types import MappingProxyType

from warmlink.fmus.component import Component, Input, Output, Parameter
from warmlink.fmus.component.units import BASE_UNITS
from warmlink.orchestration.catalogue import controller, reduced_link_in
from warmlink.orchestration.console import remark
from warmlink.orchestration.diagnosis.data.own.system import Own, Paths, in_si, to_si
from warmlink.orchestration.diagnosis.data.rig import Rig, rig
from warmlink.orchestration.fmu_store import store
from warmlink.orchestration.scenarios.own_system import parts_of
from warmlink.orchestration.system.check import own_unit
from warmlink.orchestration.system.description import ModelInfo, Variable, read_description
from warmlink.orchestration.system.model import System
from warmlink.orchestration.system.read import read_system
from warmlink.orchestration.system.replacement import Replacements
from warmlink.orchestration.system.shipped import Blueprint
from warmlink.orchestration.system.units import Unit, meaning


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
    return rig_of_own(Own.of(base, paths), looped)


def rig_of_own(own: Own, looped: bool = False) -> Rig:
    """Rig of a system of one's own; `looped`: in a loop of its FMUs, even where every part is known."""
    kinds, files = parts_of(own.system)
    infos = {name: read_description(held.fmu) for name, held in own.system.components.items()}
    foreign = {
        name: reduced_link_in(files[kind]) or _declaration(infos[name])
        for name, kind in kinds.items()
        if kind in files
    }
    values = {
        name: {key: in_si(infos[name], key, value) for key, value in held.values.items()}
        for name, held in own.system.components.items()
    }
    wires = tuple((each.source, each.target) for each in own.system.connections)
    step = own.system.default_experiment.step_size or 1.0
    blueprint = Blueprint(own.system.name, "", kinds, wires, step_size=step)
    return Rig(blueprint, values=values, foreign=foreign, looped=looped, moved=own.moved, own=own)


def _shipped(blueprint: Blueprint) -> System:
    """A shipped system with its FMUs, and no compensation."""
    none = controller("none").name
    kinds = set(blueprint.components_with(none).values())
    return blueprint.system(store(None, sorted(kinds), remark).files(kinds), none)


def _declaration(info: ModelInfo) -> Component:
    """What an FMU says of itself, as a component without equations, in SI units."""
    inputs: list[Input] = []
    parameters: list[Parameter] = []
    outputs: list[Output] = []
    for variable in info.variables.values():
        kind = "Integer" if variable.kind == "Enumeration" else variable.kind
        if kind not in ("Real", "Integer", "Boolean") or variable.dimensions:
            continue
        unit, display = _unit(info, variable)
        about = variable.description
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
