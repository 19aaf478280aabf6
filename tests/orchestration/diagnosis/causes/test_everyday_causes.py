"""Wrong logs, late loggers, moved sensors, friction and free convection are found by their own names."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.fuzz.targets import SPECIMENS
from warmlink.orchestration.diagnosis.answer.next_experiment import next_experiment
from warmlink.orchestration.diagnosis.data.experiment import read_experiment
from warmlink.orchestration.diagnosis.fit.problem import Problem
from warmlink.orchestration.diagnosis.fit.verdict import assess, fitted_part
from warmlink.orchestration.diagnosis.practice.hidden import Course, Truth, simulate
from warmlink.orchestration.diagnosis.practice.hidden_terms import hidden_term
from warmlink.orchestration.diagnosis.practice.hide import hide, write_csv
from warmlink.orchestration.scenarios.duties.duty import Segment

Columns = dict[str, NDArray[np.float64]]
LINK = ("base_temperature [degC]", "middle_temperature [degC]", "tip_temperature [degC]")


def late_link(columns: Columns) -> None:
    for name in LINK:
        columns[name] = np.concatenate([np.full(2, columns[name][0]), columns[name][:-2]])


def high_torque(columns: Columns) -> None:
    columns["torque [N.m]"] = 1.05 * columns["torque [N.m]"]


def leaking_current(columns: Columns) -> None:
    columns["shaft_temperature [degC]"] = columns["shaft_temperature [degC]"] + 0.3 * columns["torque [N.m]"]


def nothing(columns: Columns) -> None:
    pass


@pytest.mark.parametrize(
    ("mislog", "truth", "name"),
    [
        (late_link, Truth(), "clock_offset:link"),
        (high_torque, Truth(), "input_scale:torque"),
        (leaking_current, Truth(), "crosstalk:shaft_temperature"),
        (nothing, Truth(shift=(0.0, 0.005, 0.0)), "sensor_position:middle_temperature"),
        (nothing, Truth(thinning=0.02), "lubricant_thinning"),
        (nothing, Truth(coulomb=1.9, viscous=0.45), "coulomb_friction+viscous_friction"),
        (nothing, Truth(housing=0.8), "housing_heat_loss"),
        (nothing, Truth(free_exponent=0.25), "free_convection"),
    ],
)
def test_what_is_wrong_is_found_by_its_own_name(
    tmp_path: Path, mislog: Callable[[Columns], None], truth: Truth, name: str
) -> None:
    def solver(nominal: Truth, duty: list[Segment], times: NDArray[np.float64]) -> Course:
        return simulate(truth, duty, times)

    columns = hide({}, interval=20.0, seed=4, solver=solver, at_changes=True)
    mislog(columns)
    write_csv(columns, tmp_path / "run.csv")
    found = assess(read_experiment(tmp_path / "run.csv"))
    assert found.word in ("named", "ambiguous")
    assert name in {fit.name for fit in (found.best, *found.rivals)}
    covered = {"coulomb_friction", "viscous_friction"}
    assert not any("friction_level" in key and key & covered for key in found.search.fits)


def test_a_cause_that_calibration_takes_up_hides_no_other(tmp_path: Path) -> None:
    # A torque log that is off by a factor is what a calibrated torque constant explains to the last digit.
    write_csv(hide({"forced_convection": 1.6}, interval=60.0, seed=8), tmp_path / "run.csv")
    (tmp_path / "experiment.toml").write_text(
        'system = "WarmupCell"\n[[run]]\ndata = "run.csv"\n'
        '[calibrate]\n"motor.torque_constant" = { min = "1 N.m/A", max = "1.5 N.m/A", start = "1.2 N.m/A" }\n'
    )
    found = assess(read_experiment(tmp_path / "experiment.toml"))
    assert (found.word, found.best.name) == ("named", "forced_convection")


def test_heat_of_play_is_told_from_friction_by_no_log_of_one_stroke(tmp_path: Path) -> None:
    play = [hidden_term("shaft: 0.6 * speed")]
    write_csv(hide({}, interval=60.0, seed=4, terms=play), tmp_path / "run.csv")
    experiment = read_experiment(tmp_path / "run.csv")
    found = assess(experiment)
    assert (found.word, found.best.name) == ("ambiguous", "coulomb_friction")
    assert [fit.name for fit in found.rivals] == ["backlash_heat"]
    proposed = next_experiment(found, experiment)
    assert proposed is not None
    assert "half the stroke" in proposed.why
    assert proposed.alike == (("coulomb_friction", "backlash_heat"),)


def test_play_takes_no_heat_away(tmp_path: Path) -> None:
    write_csv(hide({"coulomb_friction": 0.7}, interval=60.0, seed=4), tmp_path / "run.csv")
    found = assess(read_experiment(tmp_path / "run.csv"))
    assert found.best.name == "coulomb_friction"
    assert not any("backlash_heat" in fit.key for fit in found.rivals)


def test_a_rod_is_offered_no_cause_of_what_it_has_not() -> None:
    problem = Problem(fitted_part(read_experiment(SPECIMENS / "experiment.toml")))
    titles = {item.title for item in problem.items}
    assert "ambient_offset" in titles
    assert not {t for t in titles if t.startswith(("link_air_offset", "input_offset", "input_scale"))}


def test_the_derivative_by_every_cause_is_that_of_the_readings(tmp_path: Path) -> None:
    write_csv(hide({}, interval=60.0, seed=5), tmp_path / "run.csv")
    problem = Problem(fitted_part(read_experiment(tmp_path / "run.csv")))
    z = problem.neutral[0] + 0.0
    z[[problem.slots.index("record.clock_offset"), problem.slots.index("record.clock_drift")]] = 11.0, 0.001
    _, by_slot = problem.predict(0, z)
    freed = {index: f.upper - f.lower for item in problem.items for f in item.freed for index in f.slots}
    for index, span in freed.items():
        if problem.slots[index].endswith(("tip_position", "offset:motor.speed")):
            continue  # moves with the length alone; at rest friction has a corner
        step = np.zeros(z.size)
        step[index] = 1e-4 * span
        there, back = (problem.predict(0, each)[0] for each in (z + step, z))
        change = (there - back) / step[index]
        size = np.abs(change).max(axis=0)
        away = np.abs(change - by_slot[:, :, index])
        # A step holds its matrix, and a shifted clock crosses corners of the inputs.
        assert np.all(np.quantile(away, 0.9, axis=0) <= 0.1 * size + 1e-12), problem.slots[index]


def test_a_joint_that_depends_on_temperature_and_one_that_does_not(tmp_path: Path) -> None:
    slope = replace(Truth(), joint_slope=0.015)
    columns = hide({}, interval=20.0, seed=6, solver=lambda truth, duty, times: simulate(slope, duty, times))
    write_csv(columns, tmp_path / "run.csv")
    found = assess(read_experiment(tmp_path / "run.csv"))
    assert "joint_temperature_dependence" in {fit.name for fit in (found.best, *found.rivals)}
