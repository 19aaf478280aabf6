"""Jacobi against two independent masters, step by step, a direct feedthrough within the loop."""

from __future__ import annotations

import ctypes
import sys
from pathlib import Path

import numpy as np
import pytest

from warmlink.orchestration.master.algorithms.explicit import Jacobi
from warmlink.orchestration.master.run import simulate
from warmlink.orchestration.system.model import FmuPart, System

from .pairs import wire

WIRES = ("a.y -> b.u", "b.y -> c.u", "c.z -> a.u")
START = {"a": {"y": 1.0}, "b": {"rate": 0.7}, "c": {"gain": -0.4, "rate": 0.1}}
WATCHED = ("a.y", "b.y", "c.y", "c.z")
STEPS, STEP = 50, 0.125
REFERENCE = {"u": 0, "y": 1, "z": 2, "rate": 3, "gain": 4}


def ours(fmu: Path) -> np.ndarray:
    components = {n: FmuPart(n, fmu, {}, dict(v)) for n, v in START.items()}
    system = System("loop", components, tuple(wire(w) for w in WIRES))
    result = simulate(system, STEPS * STEP, STEP, Jacobi())
    return np.column_stack([result[name] for name in WATCHED])


@pytest.mark.platform
def test_libcosim(trivial2: Path) -> None:
    cosim = pytest.importorskip("libcosimpy", reason="libcosimpy is not installed")
    execution_module = pytest.importorskip("libcosimpy.CosimExecution")
    slave_module = pytest.importorskip("libcosimpy.CosimSlave")
    observer_module = pytest.importorskip("libcosimpy.CosimObserver")
    assert cosim is not None
    execution = execution_module.CosimExecution.from_step_size(int(STEP * 1e9))
    slaves = {n: slave_module.CosimLocalSlave(fmu_path=str(trivial2), instance_name=n) for n in START}
    index = {n: execution.add_local_slave(slave) for n, slave in slaves.items()}
    for name, values in START.items():
        for variable, value in values.items():
            execution.real_initial_value(index[name], REFERENCE[variable], value)
    for text in WIRES:
        w = wire(text)
        execution.connect_real_variables(
            index[w.source_component],
            REFERENCE[w.source_variable],
            index[w.target_component],
            REFERENCE[w.target_variable],
        )
    observer = observer_module.CosimObserver.create_last_value()
    execution.add_observer(observer)
    rows = []
    for _ in range(STEPS):
        execution.step()
        row = []
        for name in WATCHED:
            component, variable = name.split(".")
            row += observer.last_real_values(index[component], [REFERENCE[variable]])
        rows.append(row)
    np.testing.assert_allclose(ours(trivial2)[1:], rows, rtol=1e-12)


@pytest.mark.platform
def test_ecos(trivial2: Path) -> None:
    for candidate in (Path(sys.prefix) / "lib" / "libtbb.so.12",):
        if candidate.exists():
            ctypes.CDLL(str(candidate), mode=ctypes.RTLD_GLOBAL)
    try:
        import ecospy
    except (ImportError, OSError) as error:
        pytest.skip(f"ecospy does not load: {error}")
    with ecospy.EcosSimulationStructure() as structure:
        for name in START:
            structure.add_model(name, str(trivial2))
        for text in WIRES:
            source, target = text.replace(".", "::").split(" -> ")
            structure.make_real_connection(source, target)
        structure.add_parameter_set(
            "p", {f"{n}::{v}": x for n, values in START.items() for v, x in values.items()}
        )
        rows = []
        with ecospy.EcosSimulation(structure=structure, step_size=STEP) as simulation:
            simulation.init(parameter_set="p")
            for _ in range(STEPS):
                simulation.step(1)
                rows.append([simulation.get_real(name.replace(".", "::")) for name in WATCHED])
            simulation.terminate()
    # Ecos is asked after its exchange, so that c.z is already that of the new input; the states show
    # that what it exchanged was the same.
    np.testing.assert_allclose(ours(trivial2)[1:, :3], np.array(rows)[:, :3], rtol=1e-12)
