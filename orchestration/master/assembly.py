"""A system's slaves, instantiated and ready to be initialized."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import field
from functools import partial
from pathlib import Path
from typing import cast

from warmlink.fmus.errors import InputError
from warmlink.fmus.packaging.cache import cache_folder
from warmlink.fmus.records import dataclass
from warmlink.orchestration.master.slaves.fmi import FmiSlave
from warmlink.orchestration.master.slaves.isolation import IsolatedSlave, Isolation, OtherProcess, start
from warmlink.orchestration.master.slaves.slave import Slave, SlaveError
from warmlink.orchestration.master.slaves.versions import Fmi2Slave, Fmi3Slave
from warmlink.orchestration.system.archive import unpack
from warmlink.orchestration.system.description import ModelInfo, read_description
from warmlink.orchestration.system.model import Connection, System, Value

# What FMI gives for reading and compiling alone.
NOT_FOR_RUNNING = ("documentation", "sources")


@dataclass
class Assembly:
    """Slaves in the system's order and connections; used once, then closed.

    Start values are by slave and variable, in the variables' own units; files are those of slaves that come
    from one; the folder, where FMUs were unpacked, is removed on closing.
    """

    slaves: Sequence[Slave]
    connections: Sequence[Connection] = ()
    values: Mapping[str, Mapping[str, Value]] = field(default_factory=dict)
    files: Mapping[str, Path] = field(default_factory=dict)
    folder: Path | None = None

    def close(self) -> None:
        """End the slaves and remove what was unpacked."""
        for slave in self.slaves:
            with suppress(SlaveError):  # which changes nothing about the run that lies behind
                slave.terminate()
        if self.folder is not None:
            shutil.rmtree(self.folder, ignore_errors=True)


def assemble(system: System, isolation: Isolation | None = None, unpacked: Path | None = None) -> Assembly:
    """Unpack and instantiate every FMU of a system, in the folder `unpacked` where it is to be kept.

    With an isolation every FMU gets a process of its own. InputError where a file is not an FMU that can run
    here, SlaveError where an FMU does not instantiate.
    """
    infos = {name: read_description(component.fmu) for name, component in system.components.items()}
    home = unpacked or Path(tempfile.mkdtemp(prefix="warmlink-"))
    slaves: list[Slave] = []
    values = {name: component.values for name, component in system.components.items()}
    files = {name: component.fmu for name, component in system.components.items()}
    found = Assembly(slaves, system.connections, values, files, home if unpacked is None else None)
    started: dict[str, OtherProcess] = {}
    try:
        for name, fmu in files.items():
            folder = unpack(fmu, _home(fmu, home), without=NOT_FOR_RUNNING)
            if isolation is None:
                slaves.append(open_slave(name, infos[name], folder))
            else:
                started[name] = start(name, partial(open_slave, name, infos[name], folder), isolation)
        for name, process in started.items():
            slaves.append(cast(Slave, IsolatedSlave(name, process, isolation or Isolation())))
    except BaseException:
        found.close()
        for process in started.values():
            process.end()
        raise
    return found


def _home(fmu: Path, other: Path) -> Path:
    """Where an FMU is unpacked: one that warmlink keeps is so beside it, once; any other elsewhere."""
    with suppress(InputError):  # where there is no folder to keep anything in
        if fmu.is_relative_to(cache_folder()) and os.access(fmu.parent, os.W_OK):
            return fmu.parent / "unpacked"
    return other


def open_slave(name: str, info: ModelInfo, folder: Path) -> FmiSlave:
    """Instantiate an FMU that was unpacked into `folder`."""
    return (Fmi3Slave if info.fmi_version == "3.0" else Fmi2Slave)(name, info, folder)
