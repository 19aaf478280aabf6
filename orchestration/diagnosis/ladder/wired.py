"""Adds to a system what diagnosis learnt.

That is the remainder that corrects its outputs, or plain fits (linear regressions on logged signals) that
predict them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

from warmlink.fmus.errors import InputError
from warmlink.fmus.remainder.component import COMPONENT
from warmlink.orchestration.catalogue import Entry
from warmlink.orchestration.console import remark
from warmlink.orchestration.diagnosis.ladder.predictor import Predictor
from warmlink.orchestration.diagnosis.ladder.remainder import Remainder
from warmlink.orchestration.fmu_store import FmuStore, own_file
from warmlink.orchestration.system.assemble import component, connected, owner_of
from warmlink.orchestration.system.description import read_description
from warmlink.orchestration.system.model import System

REMAINDER, PREDICTOR = "remainder", "predictor"


def with_remainder(system: System, learnt: Remainder, fmus: FmuStore) -> System:
    """Add the remainder to a system. It reads the system's outputs, and the signals that drive its inputs.

    InputError where it takes what no output of the system is: the correction would be another one.
    """
    sources = {target: _source(system, name) for target, name in learnt.wires.items()}
    for target, name in learnt.wires.items():
        if sources[target] is None:
            raise InputError(
                f"{system.name} has no output {name}, which the remainder's {target} takes; add a component "
                "whose output it is, and name that"
            )
    return _beside(system, REMAINDER, fmus.files({COMPONENT.name})[COMPONENT.name], sources, learnt.values)


def with_predictor(system: System, predictor: Predictor) -> System:
    """Add plain fits to a system. They read the signals that drive its inputs.

    A logged signal that is none of the system's stays for others to connect, as a remark says. InputError if
    nothing on this machine compiles plain fits.
    """
    sources = {target: _source(system, name) for target, name in predictor.inputs.items()}
    for target, name in predictor.inputs.items():
        if sources[target] is None:
            remark(f"{PREDICTOR}.{target}: {system.name} has no {name}, which it takes; connect it in a run")
    return _beside(system, PREDICTOR, predictor_file(predictor), sources)


def predictor_file(predictor: Predictor) -> Path:
    """Native FMU of plain fits, from the cache; InputError if nothing on this machine compiles one."""
    home = "warmlink.fmus.linear_predictor.component"
    return own_file(FmuStore("native"), Entry(predictor.component, home))


def _source(system: System, name: str) -> str | None:
    """Output of a system that is a signal, or feeds the input that it is; None if the system has neither.

    Empty where nothing feeds that input.
    """
    giving = {link.target: link.source for link in system.connections}.get(name, name)
    owner = owner_of(system.components, giving)
    variables = read_description(system.components[owner].fmu).variables if owner else {}
    found = variables.get(giving[len(owner) + 1 :])
    if found is None or found.causality not in ("input", "output"):
        return None
    return giving if found.causality == "output" else ""


def _beside(
    system: System,
    instance: str,
    fmu: Path,
    sources: Mapping[str, str | None],
    values: Mapping[str, float] = MappingProxyType({}),
) -> System:
    """Add an FMU to a system, with the output that each of its inputs takes.

    Where nothing feeds that input of the system, the FMU's input stays unconnected as well; whoever connects
    the one must connect the other.
    """
    taken = instance
    while taken in system.components:
        taken += "_"
    parts = {**system.components, taken: component(taken, fmu, dict(values))}
    ends = [(source, f"{taken}.{target}") for target, source in sources.items() if source]
    return replace(system, components=parts, connections=(*system.connections, *connected(parts, ends)))
