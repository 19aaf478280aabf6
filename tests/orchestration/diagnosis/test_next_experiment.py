"""The next experiment: chances, and that carrying it out tells apart what it said it would."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from warmlink.orchestration.diagnosis.duties import DUTIES, length, run_of
from warmlink.orchestration.diagnosis.experiment import read_experiment, read_runs, together
from warmlink.orchestration.diagnosis.hidden import Segment
from warmlink.orchestration.diagnosis.hide import STILL, hide, write_csv
from warmlink.orchestration.diagnosis.next_experiment import LONGEST, Proposed, next_experiment
from warmlink.orchestration.diagnosis.separation import chances
from warmlink.orchestration.diagnosis.verdict import assess


def test_a_proposal_tells_its_cycle_and_how_often() -> None:
    cycle = DUTIES[0]
    assert Proposed(cycle * 3, "", 6.0, 0.9).cycle == (cycle, 3)
    assert Proposed((), "", 0.0, 0.0).cycle == ((), 1)


def test_a_chance_is_that_of_the_nearest_rival() -> None:
    """Against draws of chi-square: normal with mean d^2 and deviation 2 d."""
    separations = np.array([[np.inf, 4.0, 9.0]])
    needed = np.full((1, 3), 7.0)
    drawn = 16 + 8 * np.random.default_rng(1).standard_normal(100_000)
    assert chances(separations, needed)[0] == pytest.approx(np.mean(drawn > 7), abs=0.005)
    assert chances(np.array([[np.inf, 0.0]]), np.array([[7.0, 7.0]]))[0] == 0.0
    assert chances(np.array([[np.inf, np.inf]]), np.array([[7.0, 7.0]]))[0] == 1.0


def test_a_duty_cycle_becomes_a_run_held_from_row_to_row() -> None:
    run = run_of(DUTIES[4], ["link.elongation"], 0.7, 10.0)
    assert run.time[-1] == pytest.approx(0.7 * length(DUTIES[4]))
    assert run.inputs["motor.pad_temperature"][0] == DUTIES[4][0].pad_temperature
    assert np.isnan(run.inputs["motor.pad_temperature"][151])
    assert run.inputs["motor.speed"][151] == DUTIES[4][1].speed


def written(folder: Path, name: str, columns: dict[str, np.ndarray]) -> Path:
    path = folder / f"{name}.csv"
    write_csv(columns, path)
    return path


def test_carried_out_it_names_what_an_hour_at_rest_left_open(tmp_path: Path) -> None:
    hidden = {"still_air_convection": 1.2}
    first = written(tmp_path, "first", hide(hidden, STILL, seed=2))
    found = assess(read_experiment(first))
    assert found.word == "ambiguous"
    proposed = next_experiment(found, found.problem.experiment)
    assert proposed is not None
    assert 0 < length(proposed.duty) <= LONGEST
    assert proposed.expected_chance > 0.9
    duty = [
        Segment(s.duration_s, s.speed, s.torque, s.pad_temperature, s.ambient_temperature)
        for s in proposed.duty
    ]
    second = written(tmp_path, "second", hide(hidden, duty, seed=3))
    both = read_runs([first, second])
    assert [run.name for run in both.runs] == ["first", "second"]
    again = assess(both)
    assert again.word == "named"
    assert again.best.key == set(hidden)


def test_runs_are_joined_whatever_their_columns_and_names(tmp_path: Path) -> None:
    columns = hide({}, STILL, seed=4)
    full = read_experiment(written(tmp_path, "run", columns))
    part = read_experiment(
        written(tmp_path, "run", {k: v for k, v in columns.items() if not k.startswith("tip")})
    )
    for first, other in ((full, part), (part, full)):
        joined = together([first, other])
        assert [run.name for run in joined.runs] == ["run (1)", "run (2)"]
        assert {c.variable for c in joined.columns} == {c.variable for c in full.columns}
