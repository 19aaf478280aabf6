"""The loop that one writes with FMPy: every slave steps, every output is read, every input is set."""

from __future__ import annotations

import tempfile
import time
from collections import defaultdict
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from benchmarks.hosts import Finished, Job
from warmlink.fmus.errors import InputError
from warmlink.orchestration.system.assemble import read_system
from warmlink.orchestration.system.model import System


@dataclass
class _Group:
    """Variables of one type of one slave."""

    references: list[int] = field(default_factory=list)
    places: list[int] = field(default_factory=list)


_Groups = dict[str, dict[str, _Group]]
"""By slave and by type."""


def run(job: Job) -> Finished:
    """Jacobi, as the other masters do it."""
    with tempfile.TemporaryDirectory(prefix="warmlink-") as work:
        system = read_system(Path(job.ssp), Path(work) / "ssp")
        slaves, types = _instantiate(system, Path(work))
        outputs, inputs = _groups(system, types)
        values: list[Any] = [None] * len(system.connections)
        for slave in slaves.values():
            slave.setupExperiment(startTime=0.0, stopTime=job.stop_time)
            slave.enterInitializationMode()
        # As often as a value can pass on directly.
        for _ in slaves:
            _exchange(slaves, outputs, inputs, values)
        for slave in slaves.values():
            slave.exitInitializationMode()
        _exchange(slaves, outputs, inputs, values)
        stepping = list(slaves.values())
        began = time.perf_counter()
        for i in range(job.steps):
            now = i * job.step_size
            for slave in stepping:
                slave.doStep(now, job.step_size)
            _exchange(slaves, outputs, inputs, values)
        took = time.perf_counter() - began
        value = slaves[job.instance].getReal([job.reference])[0]
        for slave in stepping:
            slave.terminate()
            slave.freeInstance()
    return Finished(took / job.steps * 1e6, float(value))


def _instantiate(system: System, work: Path) -> tuple[dict[str, Any], dict[str, dict[str, Any]]]:
    from fmpy import extract, read_model_description
    from fmpy.fmi2 import FMU2Slave

    slaves, types = {}, {}
    for name, component in system.components.items():
        folder = work / name
        extract(str(component.fmu), str(folder))
        description = read_model_description(str(folder), validate=False)
        slave = FMU2Slave(
            guid=description.guid,
            unzipDirectory=str(folder),
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName=name,
        )
        slave.instantiate()
        variables = {v.name: v for v in description.modelVariables}
        for variable, value in component.values.items():
            about = variables[variable]
            getattr(slave, f"set{about.type}")([about.valueReference], [value])
        slaves[name], types[name] = slave, variables
    return slaves, types


def _groups(system: System, types: dict[str, dict[str, Any]]) -> tuple[_Groups, _Groups]:
    outputs: _Groups = {name: defaultdict(_Group) for name in system.components}
    inputs: _Groups = {name: defaultdict(_Group) for name in system.components}
    for place, link in enumerate(system.connections):
        if (link.factor, link.offset) != (1.0, 0.0):
            raise InputError(f"{link.source} -> {link.target}: the plain loop converts nothing")
        for groups, name, variable in (
            (outputs, link.source_component, link.source_variable),
            (inputs, link.target_component, link.target_variable),
        ):
            about = types[name][variable]
            group = groups[name][about.type]
            group.references.append(about.valueReference)
            group.places.append(place)
    return outputs, inputs


def _exchange(slaves: dict[str, Any], outputs: _Groups, inputs: _Groups, values: list[Any]) -> None:
    for name, slave in slaves.items():
        for kind, group in outputs[name].items():
            found = getattr(slave, "get" + kind)(group.references)
            for place, value in zip(group.places, found, strict=True):
                values[place] = value
    for name, slave in slaves.items():
        for kind, group in inputs[name].items():
            getattr(slave, "set" + kind)(group.references, [values[place] for place in group.places])
