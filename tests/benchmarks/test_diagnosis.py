from pathlib import Path

import numpy as np
import pytest

from benchmarks import diagnosis
from benchmarks.diagnosis import bench_diagnosis
from benchmarks.diagnosis_trial import Trial
from benchmarks.hidden_effects import KINDS, drawn, weakened, with_gaps
from warmlink.orchestration.diagnosis.practice.effects import effect_of
from warmlink.orchestration.diagnosis.practice.hide import hide


@pytest.mark.slow
def test_the_bench_counts_and_writes(tmp_path: Path) -> None:
    bench = bench_diagnosis({"moving": 1, "none": 1}, seed=1)
    bench.write(tmp_path)
    assert {p.name for p in tmp_path.iterdir()} == {"bench_diagnosis.csv", "confusion.csv", "trials.csv"}
    rows = {row["kind"]: row for row in bench.table()}
    assert rows["moving"]["runs"] == 1
    assert rows["moving"]["right_percent"] == 100
    assert rows["none"]["runs"] == rows["none"]["adequate"] == 1


def test_every_trial_is_made_and_counted_once(monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[tuple[str, int, int]] = []

    def trial(task: tuple[str, int, int]) -> Trial:
        made.append(task)
        kind, _, number = task
        verdict = "adequate" if kind == "none" else "unknown"
        right = kind == "none" or number == 0
        return Trial(kind, number, (), (), verdict, (), (), 0.5, right, False, (), None, None, None, 1.0)

    monkeypatch.setattr(diagnosis, "trial", trial)
    rows = {row["kind"]: row for row in bench_diagnosis({"single": 4, "none": 2}, seed=1).table()}
    assert sorted(made) == [("none", 1, 0), ("none", 1, 1), *(("single", 1, i) for i in range(4))]
    assert rows["single"]["runs"] == rows["single"]["unknown"] == 4
    assert rows["single"]["right_percent"] == 25
    assert rows["none"]["runs"] == rows["none"]["adequate"] == 2


def test_fresh_seeds_give_fresh_trials_and_the_same_seed_the_same() -> None:
    kind = KINDS["pair"]
    assert drawn(kind, np.random.default_rng(1)) == drawn(kind, np.random.default_rng(1))
    assert drawn(kind, np.random.default_rng(1)) != drawn(kind, np.random.default_rng(2))
    assert len(drawn(kind, np.random.default_rng(3))) == 2


def test_weak_effects_are_weak() -> None:
    random = np.random.default_rng(4)
    weak = weakened({"radiation": 0.6}, KINDS["weak"], random)["radiation"]
    assert 0 < weak < 0.05 * effect_of("radiation").size


def test_gaps_keep_every_change_of_the_inputs() -> None:
    whole = hide({"radiation": 0.6}, seed=2)
    holed = with_gaps(whole, {"radiation": 0.6}, np.random.default_rng(5))
    assert len(holed) == len(whole) - 2
    assert holed["time [s]"].size < whole["time [s]"].size
    assert any(np.isnan(values).mean() > 0.1 for name, values in holed.items() if "pad" not in name)
    held = np.searchsorted(holed["time [s]"], whole["time [s]"], side="right") - 1
    for name in list(whole)[1:5]:
        np.testing.assert_array_equal(holed[name][held], whole[name])
