"""A system's slaves, instantiated and ready to be initialized."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from warmlink.orchestration.master.slave import Slave
from warmlink.orchestration.system.archive import unpack
from warmlink.orchestration.system.description import ModelInfo, read_description
from warmlink.orchestration.system.model import Component, Connection, System, Value


@dataclass
class Assembly:
    """Slaves, connections and start values; used once, then closed.

    Attributes
    ----------
    slaves : sequence of Slave
        In the system's order.
    connections : sequence of Connection
        From outputs to inputs.
    values : mapping
        Start values by slave and variable, in the variables' own units.
    folder : Path or None
        Where FMUs were unpacked; removed on closing.
    """

    slaves: Sequence[Slave]
    connections: Sequence[Connection] = ()
    values: Mapping[str, Mapping[str, Value]] = field(default_factory=dict)
    folder: Path | None = None

    def close(self) -> None:
        """Remove what was unpacked; the slaves have been terminated before."""
        if self.folder is not None:
            shutil.rmtree(self.folder, ignore_errors=True)


def assemble(system: System) -> Assembly:
    """Unpack and instantiate every FMU of a system.

    Raises
    ------
    InputError
        Where a file is not an FMU that can run here.
    SlaveError
        Where an FMU does not instantiate.
    """
    infos = {name: read_description(component.fmu) for name, component in system.components.items()}
    folder = Path(tempfile.mkdtemp(prefix="warmlink-"))
    slaves: list[Slave] = []
    try:
        for name, component in system.components.items():
            slaves.append(open_slave(component, infos[name], folder))
    except BaseException:
        for slave in slaves:
            slave.terminate()
        shutil.rmtree(folder, ignore_errors=True)
        raise
    values = {name: component.parameters.values for name, component in system.components.items()}
    return Assembly(slaves, system.connections, values, folder)


def open_slave(component: Component, info: ModelInfo, folder: Path) -> Slave:
    """Instantiate one component's FMU, unpacked under `folder`."""
    from warmlink.orchestration.master.fmi2 import Fmi2Slave

    return Fmi2Slave(component.name, info, unpack(component.fmu, folder))
