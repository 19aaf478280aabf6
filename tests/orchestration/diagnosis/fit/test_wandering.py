"""A room that wanders beside its log is no cause, and hides none."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.strange_runs import LINES, measured
from warmlink.orchestration.diagnosis.answer.entries import json_content
from warmlink.orchestration.diagnosis.answer.words import summary
from warmlink.orchestration.diagnosis.data.experiment import read_experiment, together
from warmlink.orchestration.diagnosis.diagnose import diagnose_experiment, read
from warmlink.orchestration.diagnosis.fit.fitting import Fitter
from warmlink.orchestration.diagnosis.fit.noise import NoiseModel
from warmlink.orchestration.diagnosis.fit.problem import Problem
from warmlink.orchestration.diagnosis.fit.verdict import Assessment, assess
from warmlink.orchestration.diagnosis.fit.wandering import Responses, Smoothing, Wander
from warmlink.orchestration.diagnosis.practice.hidden import Course, Truth, simulate
from warmlink.orchestration.diagnosis.practice.hide import STILL, hide, write_csv
from warmlink.orchestration.report.diagnosis import write_diagnosis
from warmlink.orchestration.scenarios.duties.duty import Segment


def in_a_wandering_room(folder: Path, effects: dict[str, float], size: float, seed: int) -> Assessment:
    """Correlated over ten minutes about what was logged, with a standard deviation of `size` in K."""
    random = np.random.default_rng(seed)
    grid = np.arange(0.0, 8000.0, 60.0)
    memory = np.exp(-60.0 / 600.0)
    course = random.standard_normal(grid.size)
    for i in range(1, grid.size):
        course[i] = memory * course[i - 1] + np.sqrt(1 - memory**2) * course[i]

    def solver(truth: Truth, duty: list[Segment], times: NDArray[np.float64]) -> Course:
        return simulate(replace(truth, room=lambda t: size * float(np.interp(t, grid, course))), duty, times)

    path = folder / "run.csv"
    write_csv(hide(effects, interval=20.0, seed=seed, solver=solver), path)
    return assess(read_experiment(path))


def test_a_wandering_room_is_no_cause(tmp_path: Path) -> None:
    found = in_a_wandering_room(tmp_path, {}, 0.1, seed=1)
    assert found.word == "adequate"
    assert 0.04 < found.fitter.wander.room < 0.25


def test_a_room_that_drift_and_offset_imitate_is_still_a_room(tmp_path: Path) -> None:
    """Of a run whose weakest room is less likely than both causes, and a stronger one more."""
    line = "room 0.05 to 0.15 K"
    random = np.random.default_rng([90417, list(LINES).index(line), 1])
    write_csv(measured(LINES[line](random), random), tmp_path / "run.csv")
    found = assess(read_experiment(tmp_path / "run.csv"))
    assert found.word == "adequate"
    assert 0.05 <= found.fitter.wander.room <= 0.2


def test_a_cause_is_named_in_a_wandering_room(tmp_path: Path) -> None:
    found = in_a_wandering_room(tmp_path, {"joint_resistance": 0.3}, 0.1, seed=2)
    assert found.word == "named"
    assert found.best.key == {"joint_resistance"}
    assert found.fitter.wander.room > 0


def test_what_wanders_is_whitened_as_its_covariance_says() -> None:
    columns = np.random.default_rng(3).standard_normal((8, 3))
    root = Smoothing(columns)(np.eye(8))
    np.testing.assert_allclose(root @ root, np.linalg.inv(np.eye(8) + columns @ columns.T), atol=1e-12)


def test_each_of_several_runs_has_a_course_of_its_own(tmp_path: Path) -> None:
    runs = []
    for seed in (1, 2):
        write_csv(hide({}, STILL, interval=60.0, seed=seed), tmp_path / f"{seed}.csv")
        runs.append(read_experiment(tmp_path / f"{seed}.csv"))
    problem = Problem(together(runs))
    noise = [NoiseModel(1e-6 if name.endswith("elongation") else 0.1) for name in problem.variables]
    fitter = Fitter(problem, noise, Wander(room=0.1), Responses(problem, problem.neutral))
    plain = Fitter(problem, noise).at((), np.empty(0)).chi2
    assert 0.5 * plain < fitter.at((), np.empty(0)).chi2 < plain


@pytest.mark.slow
def test_where_no_cause_is_established_the_page_tells_when_heat_is_missing(tmp_path: Path) -> None:
    columns = hide({"brake_heat": 12.0}, interval=20.0, seed=4)
    write_csv(columns, tmp_path / "run.csv")
    found = diagnose_experiment(read([tmp_path / "run.csv"]))
    assert found.verdict in ("unknown", "empirical")
    (course,) = found.missing_heat
    share = course.time / columns["time [s]"][-1]
    braking = (share > 0.33) & (share < 0.39)
    assert np.all(np.abs(course.heat[braking] - 12) < 5)
    assert np.all(np.abs(course.heat[(share < 0.27) | (share > 0.46)]) < 4)
    write_diagnosis(found, tmp_path / "out")
    assert "When heat is missing: run" in (tmp_path / "out" / "report.html").read_text("utf-8")
    # What to measure next is proposed too: all that warms the cell up, one at a time.
    assert "one of them, or with none" in summary(found).splitlines()[-1]
    assert (tmp_path / "out" / "next_experiment.csv").is_file()
    assert json_content(found)["next_experiment"]["expected_chance"] is None
