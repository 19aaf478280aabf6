"""A learnt remainder as a component of the extended system, beside the model that it corrects."""

from __future__ import annotations

from dataclasses import replace

from warmlink.fmus.remainder.component import COMPONENT
from warmlink.orchestration.console import remark
from warmlink.orchestration.diagnosis.ladder.remainder import Remainder
from warmlink.orchestration.fmu_store import FmuStore, store
from warmlink.orchestration.system.assemble import component, connected
from warmlink.orchestration.system.description import read_description
from warmlink.orchestration.system.model import System

INSTANCE = "remainder"


def with_remainder(system: System, learnt: Remainder, built: FmuStore | None = None) -> System:
    """Put the remainder beside a system, fed by its outputs and by what feeds its inputs.

    An input of the system that nothing feeds leaves the remainder's own open too: whoever feeds one feeds
    both.
    """
    name = COMPONENT.name
    fmu = (built or store(None, {name}, remark)).files({name})[name]
    taken = INSTANCE
    while taken in system.components:
        taken += "_"
    parts = {**system.components, taken: component(taken, fmu, dict(learnt.values))}
    fed = {link.target: link.source for link in system.connections}
    ends = []
    for target, source in learnt.wires.items():
        giving = fed.get(source, source)
        part, _, variable = giving.rpartition(".")
        held = system.components.get(part)
        info = None if held is None else read_description(held.fmu).variables.get(variable)
        if info is not None and info.causality == "output":
            ends.append((giving, f"{taken}.{target}"))
    links = (*system.connections, *connected(parts, ends))
    return replace(system, components=parts, connections=links)
