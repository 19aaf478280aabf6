"""The next experiment: chances, and that carrying it out tells apart what it said it would."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from warmlink.fmus.errors import InputError
from warmlink.orchestration.closed_loop.load import load_scenario
from warmlink.orchestration.diagnosis.answer.next_experiment import (
    LONGEST,
    Proposed,
    _surest,
    next_experiment,
)
from warmlink.orchestration.diagnosis.answer.separation import DUTIES, chances, indistinguishable, run_of
from warmlink.orchestration.diagnosis.data.experiment import Experiment, read_experiment, read_runs, together
from warmlink.orchestration.diagnosis.diagnose import DUTY, SCENARIO, write_next
from warmlink.orchestration.diagnosis.fit.verdict import Assessment, assess
from warmlink.orchestration.diagnosis.practice.hide import STILL, duty_of, hide, write_csv
from warmlink.orchestration.machine.rig import rig
from warmlink.orchestration.scenarios.duties.duty import Segment, demands_at, length


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
    run = run_of(DUTIES[4], rig("WarmupCell"), ["link.elongation"], 0.7, 10.0)
    assert run.time[-1] == pytest.approx(0.7 * length(DUTIES[4]))
    assert run.inputs["motor.pad_temperature"][0] == DUTIES[4][0].pad_temperature
    assert np.isnan(run.inputs["motor.pad_temperature"][151])
    assert run.inputs["motor.speed"][151] == DUTIES[4][1].speed


def written(folder: Path, name: str, columns: dict[str, np.ndarray]) -> Path:
    path = folder / f"{name}.csv"
    write_csv(columns, path)
    return path


HIDDEN = {"still_air_convection": 1.2}


@pytest.fixture(scope="module")
def at_rest(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Experiment, Assessment]:
    """An hour in which the machine cools, and what is found in it."""
    path = written(tmp_path_factory.mktemp("rest"), "first", hide(HIDDEN, STILL, seed=2))
    experiment = read_experiment(path)
    return path, experiment, assess(experiment)


@pytest.mark.slow
def test_carried_out_it_names_what_an_hour_at_rest_left_open(
    at_rest: tuple[Path, Experiment, Assessment], tmp_path: Path
) -> None:
    first, experiment, found = at_rest
    assert found.word == "ambiguous"
    proposed = next_experiment(found, experiment)
    assert proposed is not None
    assert 0 < length(proposed.duty) <= LONGEST
    assert proposed.expected_chance > 0.9
    write_next(proposed, experiment.rig, experiment.known, tmp_path)
    second = written(tmp_path, "second", hide(HIDDEN, duty_of(str(tmp_path / SCENARIO)), seed=3))
    both = read_runs([first, second])
    assert [run.name for run in both.runs] == ["first", "second"]
    again = assess(both)
    assert again.word == "named"
    assert again.best.key == set(HIDDEN)


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


def test_a_run_given_twice_is_refused(tmp_path: Path) -> None:
    columns = hide({}, STILL, seed=4)
    one, other = (written(tmp_path, name, columns) for name in ("one", "other"))
    with pytest.raises(
        InputError, match=r"other\.csv: the same readings as in .*one\.csv; give each run once"
    ):
        read_runs([one, other])


LABELLED = """
system = "WarmupCell"
[causes]
per = ["fan"]
[[run]]
data = "on.csv"
labels = {fan = "on", lamp = "on"}
[[run]]
data = "off.csv"
labels = {fan = "off"}
"""


@pytest.mark.slow
def test_runs_with_labels_lead_to_a_next_one(tmp_path: Path) -> None:
    """Also where a label is given of one run alone."""
    for seed, name in enumerate(("on", "off")):
        written(tmp_path, name, hide(HIDDEN, STILL, seed=seed))
    (tmp_path / "lab.toml").write_text(LABELLED)
    experiment = read_experiment(tmp_path / "lab.toml")
    found = assess(experiment)
    assert found.word == "ambiguous"
    proposed = next_experiment(found, experiment)
    assert proposed is not None
    assert proposed.duty
    assert 0.9 < proposed.expected_chance <= 1.0
    assert ("still_air_convection per fan", "still_air_convection") in {
        *proposed.alike,
        *((b, a) for a, b in proposed.alike),
    }


def test_a_next_run_starts_cold_where_others_start_from_what_was_measured(
    at_rest: tuple[Path, Experiment, Assessment],
) -> None:
    _, experiment, found = at_rest
    nominal, measured = (
        next_experiment(found, replace(experiment, initial_measured=given)) for given in (False, True)
    )
    assert nominal is not None
    assert nominal == measured


@pytest.mark.slow
def test_what_no_duty_tells_is_said_without_what_is_certain(tmp_path: Path) -> None:
    """A wrong scale of the camera and a wrong expansion coefficient are one; the resistance is certain."""
    hidden = {"joint_resistance": 0.3, "expansion_coefficient": 1.03}
    experiment = read_experiment(written(tmp_path, "pair", hide(hidden, seed=5)))
    found = assess(experiment)
    proposed = next_experiment(found, experiment)
    assert proposed is not None
    assert not proposed.duty
    assert "elongation_scale" in proposed.why
    assert "joint_resistance" not in proposed.why
    assert len(proposed.alike) == 1


HEATED = Proposed(
    (Segment(600), Segment.with_pad(900, 320.15, 3.43, 2.5, ambient_temperature=297.15)) * 3,
    'It tells "a".',
    5,
    0.9,
)


def test_the_proposal_is_written_as_a_scenario_and_as_rows(tmp_path: Path) -> None:
    """Both give the proposed segments again, and what is known of the cell goes with them."""
    write_next(HEATED, rig("WarmupCell"), {"link.length": 0.8, "motor.ambient_temperature": 300.0}, tmp_path)
    times = np.arange(0.0, length(HEATED.duty), 150.0)
    wanted = demands_at(HEATED.duty, times)
    for name in (SCENARIO, DUTY):
        for demand, values in demands_at(duty_of(str(tmp_path / name)), times).items():
            np.testing.assert_allclose(values, wanted[demand], rtol=1e-12)
    scenario = load_scenario(str(tmp_path / SCENARIO))
    assert scenario.stop_time == length(HEATED.duty)
    assert scenario.parameters == {"link.length": "0.8 m"}


def test_what_nothing_tells_apart_is_said_once() -> None:
    alike = [
        (frozenset(one.split("+")), frozenset(other.split("+")))
        for one, other in (("a+x", "b+x"), ("a+y", "b+y"), ("b+z", "a+z"), ("c+x", "d+x"))
    ]
    assert indistinguishable(alike) == " Nothing tells a from b, nor c from d."


def test_rounds_that_make_nothing_surer_are_not_asked_for() -> None:
    """Of a pair that no duty cycle tells apart by itself a day was proposed, where two hours tell as much."""

    class Stuck:
        def chance(self, separations: np.ndarray) -> float:
            return 0.5

        def separations(self, duty: Sequence[Segment]) -> np.ndarray:
            return np.ones((2, 2))

    design: Any = Stuck()
    duties = DUTIES[:3]
    duty, _, chance = _surest(design, duties, np.ones((3, 2, 2)), np.zeros((2, 2), dtype=bool))
    assert chance == 0.5
    assert length(duty) == min(map(length, duties))
