"""The bench of the observers: what it counts, and its words."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.innovations import whiteness
from benchmarks.laws import WITH_CAMERA, Counts, bench_laws, laws_table
from warmlink.fmus.errors import InputError


@pytest.mark.slow
@pytest.mark.xdist_group("closed_loop")
def test_a_small_bench_counts_what_it_was_asked_for() -> None:
    counts = Counts(coverage=1, whiteness=1, mismatch=1, faults=2)
    trials = bench_laws(counts, seed=7)
    for law in WITH_CAMERA:
        kinds = [trial.kind for trial in trials if trial.law == law]
        assert [kinds.count(kind) for kind in ("coverage", "mismatch", "faults")] == [1, 1, 2]
    assert sum(trial.kind == "whiteness" for trial in trials) == 1
    # What a seed draws for one kind of runs does not depend on how many others there are.
    faulty = Counts(coverage=0, whiteness=0, mismatch=0, faults=1)
    again, other = bench_laws(faulty, seed=7), bench_laws(faulty, seed=8)
    assert again == [trial for trial in trials if trial.kind == "faults"][::2]
    assert all(a.fault != b.fault for a, b in zip(again, other, strict=True))
    text = laws_table(trials)
    assert "at 2 sigma" in text
    assert "2 runs, worse than uncompensated by" in text


def test_no_process_is_refused() -> None:
    with pytest.raises(InputError, match="--jobs 0"):
        bench_laws(Counts(), 0, jobs=0)


def test_white_noise_is_white_and_a_moving_average_is_not() -> None:
    noise = np.random.default_rng(3).standard_normal(3000)
    values = [whiteness(np.random.default_rng(seed).standard_normal(3000)).p for seed in range(200)]
    # Of the size stated: five in a hundred, give or take three standard deviations of a binomial.
    assert 0.0 <= np.mean(np.array(values) < 0.05) <= 0.05 + 3 * np.sqrt(0.05 * 0.95 / 200)
    found = whiteness(noise[1:] + 0.3 * noise[:-1])
    assert found.p < 1e-6
    assert found.neighbours == pytest.approx(0.3 / 1.09, abs=0.06)
