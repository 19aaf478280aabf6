"""Other people's masters, each in a process of its own: the same SSP, the same steps, values to compare."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

_LIBCOSIM = """
import json, sys
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimManipulator import CosimManipulator
from libcosimpy.CosimObserver import CosimObserver

path, steps, _, _, names, change = json.loads(sys.argv[1])
execution = CosimExecution.from_ssp_file(path)
observer = CosimObserver.create_last_value()
execution.add_observer(observer)
rows = []
for number in range(steps):
    if change and number == change[0]:
        overrides = CosimManipulator.create_override()
        execution.add_manipulator(overrides)
        slave = execution.slave_index_from_instance_name(change[1])
        overrides.slave_real_values(slave, [change[2]], [change[3]])
    assert execution.step()
    slaves = [execution.slave_index_from_instance_name(name.partition(".")[0]) for name, _ in names]
    rows.append([observer.last_real_values(k, [r])[0] for k, (_, r) in zip(slaves, names)])
print("ROWS", json.dumps(rows))
"""

_ECOS = """
import ctypes, json, sys
from importlib.metadata import files

# ecospy finds the library of its dependency tbb only if that is loaded already.
library = next(f for f in files("tbb") if f.name.startswith("libtbb.so."))
ctypes.CDLL(str(library.locate()), mode=ctypes.RTLD_GLOBAL)
from ecospy import EcosSimulation

path, steps, step, parameter_set, names, _ = json.loads(sys.argv[1])
with EcosSimulation(ssp_path=path, step_size=step) as simulation:
    simulation.init(**({'parameter_set': parameter_set} if parameter_set else {}))
    rows = []
    for _ in range(steps):
        simulation.step()
        rows.append([simulation.get_real(name.replace(".", "::", 1)) for name, _ in names])
print("ROWS", json.dumps(rows))
"""

Variables = Sequence[tuple[str, int]]
"""Names as `link.elongation`, each with its value reference."""


Change = tuple[int, str, int, float]
"""From a step on, counted from 0, the variable of an instance and a value reference has another value."""


def libcosim(
    ssp: Path, steps: int, variables: Variables, change: Change | None = None
) -> NDArray[np.float64]:
    """Values after each step of the SSP's own size, shape (steps, variables)."""
    _needed("libcosimpy")
    return _run(_LIBCOSIM, ssp, steps, 0.0, "", variables, change)


def ecos(
    ssp: Path, steps: int, step: float, parameter_set: str | None, variables: Variables
) -> NDArray[np.float64]:
    """Values after each step, shape (steps, variables); without a parameter set `init` is called plainly."""
    _needed("ecospy", "tbb")
    return _run(_ECOS, ssp, steps, step, parameter_set, variables)


def _needed(*packages: str) -> None:
    from importlib import metadata

    for package in packages:
        try:
            metadata.version(package)
        except metadata.PackageNotFoundError:
            pytest.skip(f"{package} is not installed")


def _run(
    script: str,
    ssp: Path,
    steps: int,
    step: float,
    parameter_set: str | None,
    variables: Variables,
    change: Change | None = None,
) -> NDArray[np.float64]:
    asked = json.dumps([str(ssp), steps, step, parameter_set, list(variables), change])
    done = subprocess.run(
        [sys.executable, "-c", script, asked], capture_output=True, text=True, timeout=240, check=False
    )
    assert "ROWS" in done.stdout, done.stdout[-2000:] + done.stderr[-2000:]
    # libcosim logs to standard output as well.
    return np.array(json.loads(done.stdout.split("ROWS", 1)[1].splitlines()[0]))
