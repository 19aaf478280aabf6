import numpy as np

from warmlink.orchestration.diagnosis.bench import KINDS, bench_diagnosis, drawn, weakened
from warmlink.orchestration.diagnosis.hide import effect_of


def test_the_bench_counts_and_writes(tmp_path) -> None:  # type: ignore[no-untyped-def]
    bench = bench_diagnosis({"single": 2, "none": 1}, seed=1)
    bench.write(tmp_path)
    assert {p.name for p in tmp_path.iterdir()} == {"bench_diagnosis.csv", "confusion.csv", "trials.csv"}
    rows = {row["kind"]: row for row in bench.table()}
    assert rows["single"]["runs"] == 2
    assert rows["single"]["right_percent"] == 100
    assert rows["none"]["adequate"] == 1


def test_fresh_seeds_give_fresh_trials_and_the_same_seed_the_same() -> None:
    kind = KINDS["pair"]
    assert drawn(kind, np.random.default_rng(1)) == drawn(kind, np.random.default_rng(1))
    assert drawn(kind, np.random.default_rng(1)) != drawn(kind, np.random.default_rng(2))
    assert len(drawn(kind, np.random.default_rng(3))) == 2


def test_weak_effects_are_weak() -> None:
    random = np.random.default_rng(4)
    weak = weakened({"radiation": 0.6}, KINDS["weak"], random)["radiation"]
    assert 0 < weak < 0.05 * effect_of("radiation").size
