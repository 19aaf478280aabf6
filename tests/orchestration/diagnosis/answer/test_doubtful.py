"""Columns that are swapped, stuck or in another unit are named; those of sound runs are not."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from warmlink.fmus.errors import InputError
from warmlink.orchestration.diagnosis import diagnose
from warmlink.orchestration.diagnosis.answer import findings
from warmlink.orchestration.diagnosis.answer.diagnosis import Diagnosis
from warmlink.orchestration.diagnosis.answer.doubtful import doubts, unchanging_inputs
from warmlink.orchestration.diagnosis.data.experiment import Experiment
from warmlink.orchestration.diagnosis.diagnose import diagnose_experiment, read
from warmlink.orchestration.diagnosis.fit.problem import Problem
from warmlink.orchestration.diagnosis.fit.verdict import fitted_part
from warmlink.orchestration.diagnosis.model.simulation import NotSimulatedError
from warmlink.orchestration.diagnosis.practice.effects import EFFECTS
from warmlink.orchestration.diagnosis.practice.hide import WHITE, hide, write_csv
from warmlink.orchestration.scenarios.duties.duty import Segment

Columns = dict[str, np.ndarray]

TORQUE, SPEED, BASE, TIP = (
    "torque [N.m]",
    "speed [rad/s]",
    "base_temperature [degC]",
    "tip_temperature [degC]",
)
GROWTH, AMBIENT = "elongation [um]", "ambient_temperature [degC]"


@pytest.fixture(scope="module")
def sound() -> Columns:
    return hide({}, seed=1, interval=30.0)


def experiment(folder: Path, columns: Columns) -> Experiment:
    write_csv(columns, folder / "run.csv")
    return read(
        [folder / "run.csv"],
        ["pad_temperature=off"] if not any(header.startswith("pad_") for header in columns) else [],
    )


def doubted(given: Experiment) -> tuple[str, ...]:
    problem = Problem(fitted_part(given))
    return doubts(problem, problem.neutral)


def stuck(columns: Columns) -> Columns:
    """Rounded, so that no noise tells that it is stuck, and the model has to."""
    values = np.round(2 * columns[TIP]) / 2
    values[60:110] = values[60]
    return {TIP: values}


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda c: {BASE: c[TIP], TIP: c[BASE]}, "base_temperature and tip_temperature look swapped"),
        (lambda c: {TORQUE: 1000 * c[TORQUE]}, "torque looks as if it were in N.mm, not N.m"),
        (lambda c: {TORQUE: c[TORQUE] / 1000}, "torque looks as if it were in kN.m, not N.m"),
        (lambda c: {SPEED: c[SPEED] * 30 / np.pi}, "speed looks as if it were in rpm, not rad/s"),
        (lambda c: {GROWTH: c[GROWTH] / 1000}, "elongation looks as if it were in mm, not um"),
        (
            lambda c: {BASE: c[BASE] + 273.15},
            "base_temperature looks as if it were in K, not degC: then it is off by 0.12 K instead of 270 K.",
        ),
        (lambda c: {BASE: 1.8 * c[BASE] + 32}, "base_temperature looks as if it were in degF, not degC"),
        (
            lambda c: {TIP: 22 + 0.01 * (c[TIP] - 22)},
            "tip_temperature changes by 0.047 K rms in 168 of 168 rows, the simulation by 4.7 K: is",
        ),
        (stuck, "tip_temperature changes by 0 K rms in 50 of 168 rows, the simulation by"),
    ],
)
def test_a_column_that_is_something_else_is_named(
    sound: Columns, change: Callable[[Columns], Columns], said: str, tmp_path: Path
) -> None:
    (sentence,) = doubted(experiment(tmp_path, {**sound, **change(sound)}))
    assert sentence.startswith(said)


@pytest.mark.filterwarnings("error")
def test_a_column_that_is_something_else_in_one_of_two_runs_is_named_with_the_run(
    sound: Columns, tmp_path: Path
) -> None:
    """With all runs taken together, the sound one hid what was wrong with the other."""
    other = hide({}, seed=2, interval=30.0)
    write_csv({**other, GROWTH: other[GROWTH] / 1000}, tmp_path / "gauge.csv")
    write_csv({**sound, SPEED: sound[SPEED] * 30 / np.pi, TIP: np.nan * sound[TIP]}, tmp_path / "joint.csv")
    gauge, joint = doubted(read([tmp_path / "gauge.csv", tmp_path / "joint.csv"]))
    assert gauge.startswith("gauge: elongation looks as if it were in mm, not um")
    assert joint.startswith("joint: speed looks as if it were in rpm, not rad/s")


def test_an_input_that_never_changes_is_asked_after_where_others_do(sound: Columns, tmp_path: Path) -> None:
    nothing = experiment(tmp_path, {**sound, TORQUE: 0 * sound[TORQUE]})
    told = "torque is 0 N.m in every row, while other inputs change: was it logged?"
    assert unchanging_inputs(nothing) == (told,)
    assert unchanging_inputs(experiment(tmp_path, sound)) == ()
    still = experiment(tmp_path, {**sound, TORQUE: 0 * sound[TORQUE], SPEED: 0 * sound[SPEED]})
    assert unchanging_inputs(still) == ()
    power = {header: values for header, values in sound.items() if "pad" not in header}
    power["pad_power [W]"] = np.full(sound[TORQUE].size, np.nan)
    (told,) = unchanging_inputs(experiment(tmp_path, power))
    assert told.startswith("pad_power is 0 W in every row")


def test_no_sensor_is_doubted_where_half_of_them_move_less_than_a_wrong_input_makes_the_simulation(
    sound: Columns, tmp_path: Path
) -> None:
    assert doubted(experiment(tmp_path, {**sound, AMBIENT: sound[AMBIENT] + 273.15})) == ()


@pytest.mark.parametrize("effect", ["", "joint_resistance", "copper_loss", "hub_heat_loss", "friction_level"])
@pytest.mark.parametrize("seed", range(3))
def test_no_column_of_a_sound_log_is_doubted(effect: str, seed: int, tmp_path: Path) -> None:
    """Whatever is wrong with the cell, and whatever it does."""
    random = np.random.default_rng([seed, len(effect)])
    duty = [
        Segment(900.0, *random.uniform(0.0, 5.0, 2).tolist())
        if random.random() < 0.7
        else Segment.with_pad(900.0, 295.15 + float(random.uniform(8.0, 40.0)))
        for _ in range(5)
    ]
    hidden = {effect: EFFECTS[effect].size} if effect else {}
    columns = hide(hidden, duty, noise=WHITE, seed=seed, interval=20.0)
    assert doubted(experiment(tmp_path, columns)) == ()


def test_what_cannot_be_simulated_is_refused_with_the_column_that_is_to_blame(
    sound: Columns, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refused(*given: object) -> None:
        raise NotSimulatedError("the simulation is not finite")

    monkeypatch.setattr(diagnose, "assess", refused)
    wrong = experiment(tmp_path, {**sound, TORQUE: 1000 * sound[TORQUE]})
    with pytest.raises(InputError, match=r"not finite; torque looks as if it were in N\.mm, not N\.m"):
        diagnose_experiment(wrong)
    with pytest.raises(InputError, match=r"not finite$"):
        diagnose_experiment(experiment(tmp_path, sound))


def test_no_cause_is_empirical_while_a_column_looks_like_something_else(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    found = object.__new__(Diagnosis)
    found.__dict__.update(assessment=None, _gated=("empirical", "it predicts better"))
    monkeypatch.setattr(findings, "doubts_of", lambda assessment: ("base and tip look swapped",))
    assert found.verdict_and_reason[0] == "unknown"
    assert "a column looks like something else" in found.verdict_and_reason[1]
