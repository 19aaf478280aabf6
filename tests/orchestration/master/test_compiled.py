"""The compiled loop gives what plain stepping gives, bit for bit, and fails as it fails."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from warmlink.fmus.errors import InputError
from warmlink.orchestration.master.algorithms.algorithm import Algorithm
from warmlink.orchestration.master.algorithms.explicit import GaussSeidel, Jacobi
from warmlink.orchestration.master.algorithms.iterated import FixedPoint
from warmlink.orchestration.master.compiled import loop as stepping
from warmlink.orchestration.master.compiled.loop import PAYS_FROM_SLAVE_STEPS, Stepping
from warmlink.orchestration.master.recording.checkpoint import LongRun
from warmlink.orchestration.master.recording.result import Result
from warmlink.orchestration.master.run import simulate
from warmlink.orchestration.system.model import FmuPart, System, Value

from .pairs import assembly, counter, interrupt_at, wire

WIRES = (
    wire("a.y -> b.u"),
    wire("b.y -> c.u", factor=0.3, offset=-0.1),
    wire("c.z -> a.u", factor=-1.0),
    wire("a.steps -> c.switched"),
    wire("b.off -> c.on"),
)

ALGORITHMS = [Jacobi(), Jacobi(settled=True), GaussSeidel(), GaussSeidel(("c", "a", "b"))]
STEPPINGS: tuple[Stepping, ...] = ("plain", "compiled")


def loop(*fmus: Path, **values: dict[str, Value]) -> System:
    given: dict[str, dict[str, Value]] = {"a": {"y": 1.0}, "b": {"rate": 0.7, "on": True}, "c": {"gain": 0.9}}
    components = {
        name: FmuPart(name, fmu, {}, {**given[name], **values.get(name, {})})
        for name, fmu in zip("abc", fmus, strict=True)
    }
    return System("loop", components, WIRES)


RECORDED = ("a.y", "b.y", "c.z", "c.u", "c.off", "c.switched", "b.steps", "a.rate")


def both(
    system: System, algorithm: Algorithm, stop: float = 80.0, record: Sequence[str] = RECORDED
) -> tuple[Result, Result]:
    plain, compiled = (
        simulate(system, stop, 0.1, algorithm, record=record, stepping=stepping) for stepping in STEPPINGS
    )
    assert not plain.statistics.compiled
    return plain, compiled


@pytest.mark.parametrize("algorithm", ALGORITHMS, ids=str)
@pytest.mark.parametrize("versions", ["222", "333", "232"])
def test_the_same_bits(trivial2: Path, trivial3: Path, versions: str, algorithm: Algorithm) -> None:
    system = loop(*({"2": trivial2, "3": trivial3}[v] for v in versions))
    plain, compiled = both(system, algorithm)
    assert compiled.statistics.compiled
    assert compiled.status == "completed"
    np.testing.assert_array_equal(plain.table.values.view(np.uint64), compiled.table.values.view(np.uint64))
    assert plain.statistics.slave_steps == compiled.statistics.slave_steps


@pytest.mark.parametrize("status", [2, 3, 7])
def test_failures_are_those_of_plain_stepping(trivial2: Path, trivial3: Path, status: int) -> None:
    for fmus in ((trivial2, trivial2, trivial2), (trivial2, trivial3, trivial3)):
        values: dict[str, Value] = {"fail_at": 20.05, "fail_status": status}
        plain, compiled = both(loop(*fmus, b=values), Jacobi())
        assert compiled.status == "stopped"
        assert compiled.reason == plain.reason
        np.testing.assert_array_equal(plain.table.values, compiled.table.values)


def test_a_discard_is_retried_as_in_plain_stepping(trivial2: Path) -> None:
    plain, compiled = both(loop(trivial2, trivial2, trivial2, b={"largest_step": 0.05}), GaussSeidel(), 30.0)
    assert compiled.status == "completed"
    assert compiled["b.steps"][-1] == 600
    np.testing.assert_array_equal(plain.table.values, compiled.table.values)


def test_it_is_chosen_by_itself_where_it_pays(trivial2: Path) -> None:
    system = loop(trivial2, trivial2, trivial2)
    long, short = PAYS_FROM_SLAVE_STEPS, PAYS_FROM_SLAVE_STEPS / 6
    assert simulate(system, float(long), 1.0, GaussSeidel(), record=["a.y"]).statistics.compiled
    assert not simulate(system, short // 1, 1.0, GaussSeidel(), record=["a.y"]).statistics.compiled
    assert not simulate(system, 2000.0, 1.0, FixedPoint(interpolation=0), record=["a.y"]).statistics.compiled
    with pytest.raises(InputError, match="cannot be compiled; choose Jacobi"):
        simulate(system, 10.0, 1.0, FixedPoint(), stepping="compiled")
    with pytest.raises(InputError, match="x is not an FMU in this process; choose plain stepping"):
        simulate(assembly([counter("x")]), 10.0, 1.0, stepping="compiled")


def test_no_python_runs_between_the_steps(trivial2: Path) -> None:
    # Its time is measured by `python -m benchmarks.masters`.
    system = loop(trivial2, trivial2, trivial2, a={"rate": 1e-3}, b={"rate": 1e-3})
    assert calls_in(system, 20_000) <= 1.5 * calls_in(system, 2_000)


def calls_in(system: System, steps: int) -> int:
    """How often Python or a C function out of it is called in a compiled run."""
    calls = 0

    def count(*_: object) -> None:
        nonlocal calls
        calls += 1

    sys.setprofile(count)
    try:
        result = simulate(system, float(steps), 1.0, Jacobi(), record=["a.y"], stepping="compiled")
    finally:
        sys.setprofile(None)
    assert result.statistics.communication_steps == steps
    return calls


@pytest.mark.parametrize("status", [2, 3, 7])
def test_failures_of_slaves_that_cannot_go_back(trivial2: Path, tmp_path: Path, status: int) -> None:
    import zipfile

    rigid = tmp_path / "rigid.fmu"
    with zipfile.ZipFile(trivial2) as old, zipfile.ZipFile(rigid, "w") as new:
        for name in old.namelist():
            data = old.read(name)
            if name.endswith(".xml"):
                data = data.replace(b'FMUstate="true"', b'FMUstate="false"')
            new.writestr(name, data)
    values: dict[str, Value] = {"fail_at": 20.05, "fail_status": status}
    plain, compiled = both(loop(rigid, rigid, rigid, b=values), Jacobi())
    assert (plain.error, compiled.error) != (None, None)
    assert plain.error is not None
    assert compiled.error is not None
    for name in ("slave", "status", "variable", "time"):
        assert getattr(plain.error, name) == getattr(compiled.error, name)
    np.testing.assert_array_equal(plain.table.values, compiled.table.values)


def test_what_gives_no_more_of_what_is_only_recorded_is_named(trivial2: Path) -> None:
    components = {
        "a": FmuPart("a", trivial2, {}, {"y": 1.0}),
        "b": FmuPart("b", trivial2, {}, {"fail_at": 20.05, "fail_status": 15}),
    }
    plain, compiled = both(System("pair", components, WIRES[:1]), Jacobi(), record=["a.y", "b.rate"])
    assert plain.reason is not None
    assert plain.reason.startswith("b.rate: error at 20 s: fmi2GetReal answered error")
    assert plain.reason == compiled.reason
    np.testing.assert_array_equal(plain.table.values, compiled.table.values)


def test_compiled_runs_stream_and_resume_as_plain_ones(
    trivial2: Path, trivial3: Path, tmp_path: Path
) -> None:
    system = loop(trivial2, trivial3, trivial2)
    whole = simulate(system, 400.0, 0.1, GaussSeidel(), stepping="plain")
    long_run = LongRun(tmp_path / "run", every=350, resume=True)
    for share in (0.3, 1.0):
        part = simulate(
            system,
            400.0,
            0.1,
            GaussSeidel(),
            stepping="compiled",
            long_run=long_run,
            progress=interrupt_at(share),
        )
        assert part.statistics.compiled
        assert part.status == ("completed" if share == 1.0 else "stopped")
    np.testing.assert_array_equal(whole.table.values, part.table.values)


def test_auto_steps_plainly_where_nothing_compiles(
    trivial2: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    system = loop(trivial2, trivial2, trivial2)
    monkeypatch.setenv("WARMLINK_CACHE", str(tmp_path))
    monkeypatch.setenv("CC", str(tmp_path / "absent"))
    monkeypatch.setattr(stepping, "library", stepping.library.__wrapped__)
    long = float(PAYS_FROM_SLAVE_STEPS)
    assert not simulate(system, long, 1.0, GaussSeidel(), record=["a.y"]).statistics.compiled
    with pytest.raises(InputError, match=r"compiled stepping: .*; choose auto"):
        simulate(system, long, 1.0, GaussSeidel(), stepping="compiled")
