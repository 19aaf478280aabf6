"""What each slave was asked for, and how long it took."""

import json
from pathlib import Path

import numpy as np
import pytest

from tests.documented import undescribed
from warmlink.fmus.errors import InputError
from warmlink.orchestration.cli import app
from warmlink.orchestration.master.algorithms.explicit import GaussSeidel
from warmlink.orchestration.master.recording.checkpoint import LongRun
from warmlink.orchestration.master.recording.result import Statistics
from warmlink.orchestration.master.run import simulate
from warmlink.orchestration.master.slaves.slave import SlaveError, SlaveStatistics

from .mock import MockSlave
from .pairs import assembly, interrupt_at
from .test_compiled import loop


def test_calls_are_counted_and_change_nothing(trivial2: Path, trivial3: Path) -> None:
    system = loop(trivial2, trivial3, trivial2, b={"largest_step": 0.05})
    usual = simulate(system, 30.0, 0.1, GaussSeidel(), stepping="plain")
    found = simulate(system, 30.0, 0.1, GaussSeidel(), statistics=True)
    np.testing.assert_array_equal(usual.table.values, found.table.values)
    statistics = found.statistics
    assert usual.statistics.slaves == ()
    assert [each.name for each in statistics.slaves] == ["a", "b", "c"]
    assert sum(each.calls["step"].count - each.calls["step"].refused for each in statistics.slaves) == (
        statistics.slave_steps
    )
    a, b, c = statistics.slaves
    assert b.calls["step"].refused == statistics.rejected_steps > 0
    assert a.calls["step"].refused == c.calls["step"].refused == 0
    assert set(b.step_sizes) == {0.1, 0.05}
    assert b.step_sizes[0.1] == b.calls["step"].refused
    assert a.calls["restore"].count == statistics.rejected_steps
    assert all(calls.seconds > 0 for calls in b.calls.values())
    told = json.loads(json.dumps(statistics.to_dict()))
    assert told["limits_the_step"] == "b"
    assert told["slaves"][1]["step_sizes"] == {"0.05": b.step_sizes[0.05], "0.1": b.step_sizes[0.1]}
    headings, rows = statistics.table()
    assert {len(row) for row in rows} == {len(headings)}
    assert "repeated in parts, most for b; memory" in statistics.summary()


def test_the_table_shows_the_most_frequent_sizes() -> None:
    sizes = {0.1 * 0.5**k: 1 for k in range(5)} | {1.0: 300}
    statistics = Statistics(slaves=(SlaveStatistics("link", step_sizes=sizes),))
    headings, ((_, _, shown, *_),) = statistics.table()
    assert headings[2] == "sizes in s"
    assert shown == "1 (300), 0.1 (1), 0.05 (1), 0.025 (1), 2 more"


def test_steps_of_before_a_run_was_resumed_are_told_apart(trivial2: Path, tmp_path: Path) -> None:
    system = loop(trivial2, trivial2, trivial2)
    for resumed, progress in ((0, interrupt_at(0.7)), (20, None)):
        long_run = LongRun(tmp_path, every=20, resume=True)
        found = simulate(system, 3.0, 0.1, statistics=True, long_run=long_run, progress=progress).statistics
        assert found.resumed_steps == resumed
    assert found.communication_steps == 30
    assert [each.calls["step"].count for each in found.slaves] == [10] * 3
    assert found.summary().startswith("10 communication steps in ")
    assert "; 20 were done before" in found.summary()


def test_who_asks_to_end_the_simulation_limits_no_step() -> None:
    def ends(x: float, u: object, t: float, h: float) -> float:
        if t >= 2.0:
            raise SlaveError("s", "terminated", t, "asks to end the simulation")
        return x + h

    slave = MockSlave("s", outputs={"y": lambda x, u, t: x}, state=0.0, advance=ends)
    found = simulate(assembly([slave]), 10.0, 1.0, statistics=True).statistics.to_dict()
    assert found["limits_the_step"] is None
    assert found["slaves"][0]["calls"]["step"]["refused"] == 0


def test_what_is_compiled_is_not_timed(trivial2: Path) -> None:
    with pytest.raises(InputError, match="statistics; leave one out"):
        simulate(loop(trivial2, trivial2, trivial2), 1.0, 0.1, stepping="compiled", statistics=True)


def test_run_tells_them_where_it_is_asked_to(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as stop:
        app(["run", "--stop", "1 min", "--no-report", "--statistics", "--out", "out"])
    assert stop.value.code == 0
    said = capsys.readouterr().out
    assert "60 communication steps" in said
    assert "compensator" in said
    metrics = json.loads(Path("out/metrics.json").read_text())
    assert not undescribed("metrics.json", metrics)
    told = metrics["statistics"]
    assert [each["calls"]["step"]["count"] for each in told["slaves"]] == [60] * 6
    assert told["limits_the_step"] is None
