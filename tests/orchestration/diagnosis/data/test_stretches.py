"""Stretches that no temperature made: sensors that stick or are cut off, loose contacts, steps for good."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tests.command import exit_code
from warmlink.orchestration.diagnosis.data.stretches import loose, shifted, stuck
from warmlink.orchestration.diagnosis.diagnose import diagnose_experiment, read
from warmlink.orchestration.diagnosis.practice.hide import hide, write_csv

TIME = 10.0 * np.arange(600)
RANDOM = np.random.default_rng(7)
COURSE = 295 + 20 * (1 - np.exp(-TIME / 1500))
NOISY = COURSE + 0.08 * RANDOM.standard_normal(TIME.size)
COARSE = np.round(COURSE / 0.5) * 0.5
RELAY = 300 + 5.0 * (np.arange(600) // 6 % 2) + 0.05 * RANDOM.standard_normal(600)
"""A reading that leaps with what heats it, every minute."""

CHANGES = np.arange(6, 600, 6)


def test_a_reading_that_stays_where_noise_should_show_is_stuck() -> None:
    held = NOISY.copy()
    held[100:400] = held[100]
    assert stuck(TIME, held).tolist() == [*range(101, 400)], "the reading with which it stuck is right"
    short = NOISY.copy()
    short[100:104] = short[100]
    assert stuck(TIME, short).size == 0


@pytest.mark.parametrize("value", [273.15, 1123.15])
@pytest.mark.parametrize("course", [NOISY, COARSE])
def test_readings_that_leap_to_a_value_and_away_from_it_are_of_a_sensor_that_was_cut_off(
    value: float, course: np.ndarray
) -> None:
    cut = course.copy()
    cut[200:236] = value
    assert stuck(TIME, cut).tolist() == [*range(200, 236)]


@pytest.mark.parametrize("course", [NOISY, COARSE, COURSE, RELAY, np.round(RELAY), np.full(600, 295.0)])
def test_a_sound_sensor_neither_sticks_nor_is_loose_nor_moved(course: np.ndarray) -> None:
    assert stuck(TIME, course).size == 0
    assert loose(TIME, course, CHANGES).size == 0
    assert shifted(TIME, course, CHANGES) == []


def test_a_loose_contact_leaps_to_and_fro() -> None:
    burst = NOISY.copy()
    burst[300:309] += [9.0, -14, 3, 17, -2, -11, 8, 15, -6]
    assert loose(TIME, burst).tolist() == [*range(300, 309)]
    assert loose(TIME, NOISY + np.where(np.arange(600) > 300, 9.0, 0.0)).size == 0


def test_a_step_for_good_is_told_with_its_row_and_height() -> None:
    moved = NOISY + np.where(np.arange(600) >= 250, 1.5, 0.0)
    ((row, height),) = shifted(TIME, moved)
    assert row == 250
    assert height == pytest.approx(1.5, abs=0.3)
    assert shifted(TIME, moved, driven=np.array([249])) == [], "the input may have done it"
    spike = NOISY.copy()
    spike[250] += 1.5
    assert shifted(TIME, spike) == []


def test_a_stuck_thermometer_is_shown_and_no_cause_is_blamed_for_it(tmp_path: Path) -> None:
    run = hide({}, seed=11)
    name = "base_temperature [degC]"
    run[name][200:500] = run[name][200]
    write_csv(run, tmp_path / "run.csv")
    experiment = read([tmp_path / "run.csv"])
    told = next(each for each in experiment.remarks if "base_temperature stays at" in each)
    assert "rows 203 to 501" in told
    assert "taken for missing values" in told
    assert not any("was not read" in each for each in experiment.remarks), "it is said once"
    assert diagnose_experiment(experiment).verdict == "adequate"


def test_a_long_stretch_without_readings_is_told(tmp_path: Path) -> None:
    run = hide({}, seed=11)
    names = [
        name for name in run if "_temperature [degC]" in name and "ambient" not in name and "pad" not in name
    ]
    for name in (*names, "elongation [um]"):
        run[name][200:320] = np.nan
    run["tip_temperature [degC]"][500:600] = np.nan
    write_csv(run, tmp_path / "run.csv")
    said = "\n".join(read([tmp_path / "run.csv"]).remarks)
    assert said.count("was read") == said.count("was not read") == 1
    assert "run.csv: nothing was read for 20 min from 33.3" in said
    assert "run.csv: tip_temperature was not read for 16.7 min from 83.3" in said


_PULSED = """
system = "BenchMotor"
[[run]]
data = "run.csv"
[channels]
"room" = "motor.ambient_temperature"
"body" = "motor.shaft_temperature"
[known]
"motor.speed" = 0
"""


@pytest.mark.parametrize(
    ("channel", "why"),
    [('"amps" = "motor.current"', "with a pulse of an input that is too short"), ("", "as no heat does")],
)
def test_a_pulse_of_the_input_may_make_a_reading_leap_in_one_row(
    channel: str, why: str, tmp_path: Path
) -> None:
    hour = np.arange(200)
    heating = np.where(hour % 50 == 20, 3.0, 0.0)
    body = 27 + 4 * np.sin(hour / 25) + 0.05 * RANDOM.standard_normal(200) + 10 * heating
    columns = {"time [h]": hour, "amps [A]": heating, "room [degC]": 0 * heating + 22, "body [degC]": body}
    pd.DataFrame(columns).to_csv(tmp_path / "run.csv", index=False)
    (tmp_path / "e.toml").write_text(_PULSED.replace('"body"', f'{channel}\n"body"'))
    (told,) = (each for each in read([tmp_path / "e.toml"]).remarks if "leaps away and back" in each)
    assert why in told


def test_check_says_what_columns_look_like(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    run = hide({}, seed=12)
    base, tip, growth = "base_temperature [degC]", "tip_temperature [degC]", "elongation [um]"
    every = {
        "look at this first: base_temperature and tip_temperature look swapped": {
            base: run[tip],
            tip: run[base],
        },
        "a diagnosis refuses this: run: column 'tip_temperature' never changes": {tip: 0 * run[tip] + 22.3},
        "elongation falls where it should rise": {growth: -run[growth]},
    }
    for told, changed in every.items():
        write_csv({**run, **changed}, tmp_path / "run.csv")
        assert exit_code(["diagnose", str(tmp_path / "run.csv"), "--check"], monkeypatch) == 0
        assert told in capsys.readouterr().out
