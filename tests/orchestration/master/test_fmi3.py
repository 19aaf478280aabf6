"""FMI 3.0 slaves, alone and beside FMI 2.0 ones."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from warmlink.orchestration.master.algorithms.explicit import Jacobi
from warmlink.orchestration.master.algorithms.iterated import FixedPoint
from warmlink.orchestration.master.assembly import assemble
from warmlink.orchestration.master.run import simulate
from warmlink.orchestration.master.slaves.slave import RunSpan
from warmlink.orchestration.system.model import FmuPart, System, Value

from .pairs import wire


def mixed(first: Path, second: Path, **values: dict[str, Value]) -> System:
    wires = (wire("a.y -> b.u"), wire("b.z -> a.u", factor=-1.0), wire("a.off -> b.on"))
    fmus = {"a": first, "b": second}
    return System(
        "s",
        {n: FmuPart(n, fmu, {}, values.get(n, {})) for n, fmu in fmus.items()},
        wires,
    )


def test_all_types_states_and_polynomial_inputs(trivial3: Path) -> None:
    assembly = assemble(System("s", {"a": FmuPart("a", trivial3)}))
    (slave,) = assembly.slaves
    names = ("u", "fail_status", "on", "label", "rate")
    slave.set(names, [0.25, 0, True, "größe", 2.0])
    assert slave.get(names) == [0.25, 0, True, "größe", 2.0]
    slave.setup(RunSpan(0.0, 10.0))
    slave.enter_initialization()
    slave.exit_initialization()
    state, data = slave.state(), slave.serialize()
    slave.set(("u",), [1.0])
    slave.set_input_derivatives(("u",), 1, [3.0])
    slave.step(0.0, 2.0)
    # Exact, because the slave's micro steps ask for the input in their middle.
    assert slave.get(("y", "u")) == [2.0 * (2.0 + 6.0), 7.0]
    slave.restore(state)
    assert slave.get(("y",)) == [0.0]
    slave.step(0.0, 2.0)
    slave.deserialize(data)
    assert slave.get(("y", "u")) == [0.0, 0.25]
    slave.free(state)
    slave.terminate()
    slave.terminate()
    assembly.close()


@pytest.mark.parametrize("algorithm", [Jacobi(), FixedPoint(interpolation=0)])
def test_mixed_versions_give_what_equal_ones_give(trivial2: Path, trivial3: Path, algorithm: Jacobi) -> None:
    values: dict[str, dict[str, Value]] = {"a": {"y": 1.0, "rate": 0.5}, "b": {"gain": 0.3, "on": True}}
    both = [
        simulate(mixed(*fmus, **values), 4.0, 0.25, algorithm)
        for fmus in ((trivial2, trivial2), (trivial2, trivial3), (trivial3, trivial2))
    ]
    assert [r.status for r in both] == ["completed"] * 3
    for other in both[1:]:
        np.testing.assert_allclose(other.table.values, both[0].table.values, rtol=1e-13)


def test_interpolated_inputs_reach_the_accuracy_of_fmi2(trivial2: Path, trivial3: Path) -> None:
    # x' = v, v' = -x with quadratic integrators: both versions integrate linear inputs exactly.
    wires = (wire("a.y -> b.u"), wire("b.y -> a.u", factor=-1.0))
    start = {"y": 1.0}
    results = []
    for fmu in (trivial2, trivial3):
        system = System("s", {"a": FmuPart("a", fmu, {}, start), "b": FmuPart("b", fmu)}, wires)
        results.append(simulate(system, 5.0, 0.125, FixedPoint()))
    np.testing.assert_allclose(results[0]["a.y"], results[1]["a.y"], rtol=1e-8, atol=1e-8)
    assert np.max(np.abs(results[1]["a.y"] - np.cos(results[1].times))) < 2e-2


def test_bad_status_is_told_in_the_slaves_words(trivial3: Path) -> None:
    values: dict[str, Value] = {"fail_at": 3.5, "fail_status": 3}
    system = System("s", {"a": FmuPart("a", trivial3, {}, values)})
    result = simulate(system, 10.0, 1.0)
    assert result.reason == "a: error at 3 s: fmi3DoStep answered error; it logged: it fails from 3.5"
    np.testing.assert_array_equal(result.times, [0, 1, 2, 3])
