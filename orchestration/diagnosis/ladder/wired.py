"""What stands beside the model that it corrects, as components of the extended system."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

from warmlink.fmus.remainder.component import COMPONENT
from warmlink.orchestration.catalogue import Entry
from warmlink.orchestration.console import remark
from warmlink.orchestration.diagnosis.ladder.predictor import Predictor
from warmlink.orchestration.diagnosis.ladder.remainder import Remainder
from warmlink.orchestration.fmu_store import FmuStore, own_file, store
from warmlink.orchestration.system.assemble import component, connected
from warmlink.orchestration.system.description import read_description
from warmlink.orchestration.system.model import System

INSTANCE, PREDICTOR = "remainder", "predictor"


def with_remainder(system: System, learnt: Remainder, built: FmuStore | None = None) -> System:
    """Put the remainder beside a system, fed by its outputs and by what feeds its inputs."""
    name = COMPONENT.name
    fmu = (built or store(None, {name}, remark)).files({name})[name]
    return _beside(system, INSTANCE, fmu, learnt.wires, learnt.values)


def with_predictor(system: System, predictor: Predictor) -> System:
    """Put plain fits beside a system, fed by what feeds its inputs; InputError if nothing compiles them."""
    return _beside(system, PREDICTOR, predictor_file(predictor), predictor.inputs)


def predictor_file(predictor: Predictor) -> Path:
    """Native FMU of plain fits, from the cache; InputError if nothing on this machine compiles one."""
    home = "warmlink.fmus.linear_predictor.component"
    return own_file(FmuStore("native"), Entry(predictor.component, home))


def _beside(
    system: System,
    instance: str,
    fmu: Path,
    wires: Mapping[str, str],
    values: Mapping[str, float] = MappingProxyType({}),
) -> System:
    """Put an FMU beside a system.

    An input of the system that nothing feeds leaves the FMU's own open too: whoever feeds one feeds both.
    """
    taken = instance
    while taken in system.components:
        taken += "_"
    parts = {**system.components, taken: component(taken, fmu, dict(values))}
    fed = {link.target: link.source for link in system.connections}
    ends = []
    for target, source in wires.items():
        giving = fed.get(source, source)
        part, _, variable = giving.rpartition(".")
        held = system.components.get(part)
        info = None if held is None else read_description(held.fmu).variables.get(variable)
        if info is not None and info.causality == "output":
            ends.append((giving, f"{taken}.{target}"))
    links = (*system.connections, *connected(parts, ends))
    return replace(system, components=parts, connections=links)
