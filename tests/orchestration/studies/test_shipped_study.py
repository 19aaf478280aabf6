"""The shipped study shows what tuning is good for: with as many runs it ends well below a sweep.

A run of the lag law is here what it is in the cell, but without the cell: the growth of each duty cycle is
simulated once, and the law's equation is followed over its losses.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import lfilter

pytest.importorskip("optuna")

from benchmarks.rollout import demand_table
from tests.pages import plots
from warmlink.orchestration.cli import main
from warmlink.orchestration.machine.shipped import WARMUP_CELL
from warmlink.orchestration.master.algorithms.named import algorithm
from warmlink.orchestration.master.run import simulate
from warmlink.orchestration.studies.case import Case, Outcome, figures
from warmlink.orchestration.studies.points import best
from warmlink.orchestration.studies.storage import JOURNAL, Storage, import_optuna
from warmlink.orchestration.studies.study import Study, load_study
from warmlink.orchestration.studies.sweep import points_of, sweep
from warmlink.orchestration.studies.tune import tune
from warmlink.orchestration.studies.workers import FmuSet

Array = np.ndarray[tuple[int, ...], np.dtype[np.float64]]

import_optuna()


class Followed:
    """Workers for the lag law in the nominal cell."""

    def __init__(self, study: Study, fmus: FmuSet) -> None:
        self.growth: dict[str, Array] = {}
        # A sample sees the demands that begin with it.
        self.demands = {duty.name: demand_table(duty.duty, duty.step_size)[1:] for duty in study.scenarios}
        assert study.shipped is not None
        for case in study.cases(study.shipped, ""):
            system = WARMUP_CELL.system(fmus.files(), case.law, case.values)
            result = simulate(
                system,
                case.stop_time,
                case.step_size,
                algorithm(case.master),
                record=(
                    *("link.elongation", "link.discretisation_error"),
                    *("compensator.correction", "compensator.ready"),
                ),
                balances=(),
                unpacked=fmus.unpacked,
            )
            self.growth[case.label[1]] = np.asarray(result["link.elongation"])
            outcome = figures(case, result)
            assert self.outcome(case).max_abs_um == pytest.approx(outcome.max_abs_um, abs=1e-6)

    def outcome(self, case: Case) -> Outcome:
        law = case.values["compensator"]
        speed, torque = np.abs(self.demands[case.label[1]][:, 0]), self.demands[case.label[1]][:, 1]
        friction = (1.5 + float(law["viscous_friction"]) * speed) * speed
        heat = 2.0 * (torque / 1.2) ** 2 + 0.15 * speed**2 + friction
        kept = math.exp(-case.step_size / float(law["time_constant"]))
        correction = lfilter([1 - kept], [1, -kept], float(law["gain"]) * heat)
        error = 1e6 * float(np.abs(self.growth[case.label[1]][1:] - correction).max())
        rate = 1e6 * float(np.abs(np.diff(correction)).max())
        return Outcome(error, error, error, None, 0.0, 0.0, rate, 0.0)

    def run(self, cases: Sequence[Case]) -> Iterator[tuple[int, Outcome]]:
        for place, case in enumerate(cases):
            yield place, self.outcome(case)


@pytest.fixture(scope="module")
def followed(fmus: FmuSet) -> Followed:
    return Followed(load_study("lag_law"), fmus)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_tuning_ends_well_below_a_sweep_of_as_many_runs(
    seed: int, followed: Followed, tmp_path: Path
) -> None:
    study = replace(load_study("lag_law"), seed=seed)
    storage = Storage(study, "fmus", f"{JOURNAL}{tmp_path / 'study.log'}")
    trials = tune(study, followed, storage, lambda done, leader: None).trials
    swept = sweep(study, points_of(study), followed, lambda done: None)
    assert len(trials) == len(swept)
    winner = best(trials)
    assert winner is not None
    assert winner.objective < 0.92 * min(point.objective for point in swept if point.feasible)
    assert winner.objective < 0.55 * trials[0].objective


def test_tune_and_sweep_leave_each_others_results_alone(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(folder)
    text = (folder / "study.toml").read_text()
    (folder / "study.toml").write_text(
        text.replace("trials = 14", "trials = 2").replace("points = 3", "points = 1")
    )
    for name in ("tune", "sweep"):
        monkeypatch.setattr("sys.argv", ["warmlink", name, "study.toml"])
        with pytest.raises(SystemExit) as stop:
            main()
        assert stop.value.code == 0
    tuned, swept = ((folder / "out" / "study" / name / "report.html") for name in ("tune", "sweep"))
    assert "best so far" in plots(tuned)
    assert "best so far" not in plots(swept)
