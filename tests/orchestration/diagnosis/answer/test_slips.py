"""Slips of whoever logged a run are said before any cause; a sound log has none."""

from pathlib import Path

import numpy as np
import pytest

from tests.orchestration.diagnosis.fit.two_lumps import BOUNDS, log
from tests.orchestration.diagnosis.fit.two_lumps import experiment as bench
from tests.orchestration.diagnosis.loggers import Logger, logged_file
from tests.shared_data import given
from warmlink.orchestration.cli import main
from warmlink.orchestration.diagnosis.answer.slips import Slips, slips
from warmlink.orchestration.diagnosis.answer.words import summary
from warmlink.orchestration.diagnosis.data.experiment import Experiment
from warmlink.orchestration.diagnosis.data.measured import read_run
from warmlink.orchestration.diagnosis.diagnose import diagnose_experiment, read
from warmlink.orchestration.diagnosis.practice.effects import EFFECTS
from warmlink.orchestration.diagnosis.practice.hide import INFORMATIVE, hide, write_csv
from warmlink.orchestration.machine.rig import rig

Columns = dict[str, np.ndarray]
SPEED, TORQUE, PAD = "speed [rad/s]", "torque [N.m]", "pad_temperature [degC]"
CHANNELS = '[channels]\n"shaft_temperature" = "motor.shaft_temperature"\n'
WINDING, BASE = "winding_temperature [degC]", "base_temperature [degC]"


@pytest.fixture(scope="module")
def sound() -> Columns:
    return hide({}, seed=4)


def experiment(folder: Path, columns: Columns) -> Experiment:
    write_csv(columns, folder / "run.csv")
    return read([folder / "run.csv"])


def shifted(columns: Columns, early: float) -> Columns:
    """Columns whose inputs are stamped early by a time in s."""
    time = columns["time [s]"]
    rows = np.clip(np.searchsorted(time, time + early, side="right") - 1, 0, time.size - 1)
    return {**columns, **{name: columns[name][rows] for name in (SPEED, TORQUE, PAD) if name in columns}}


@pytest.mark.parametrize(("early", "said"), [(200.0, "too late: they were logged"), (-90.0, "too early")])
def test_inputs_that_were_logged_early_or_late_are_said(
    sound: Columns, early: float, said: str, tmp_path: Path
) -> None:
    (sentence,) = slips(experiment(tmp_path, shifted(sound, early))).wrong
    assert said in sentence
    by = float(sentence.partition("follows the inputs ")[2].partition(" s ")[0])
    assert by == pytest.approx(abs(early), abs=25.0)


@pytest.mark.parametrize("header", [WINDING, BASE])
def test_a_reversed_sign_is_said(sound: Columns, header: str, tmp_path: Path) -> None:
    (sentence,) = slips(experiment(tmp_path, {**sound, header: 2 * sound[header][0] - sound[header]})).wrong
    assert sentence.startswith(f"{header.partition(' ')[0]} falls where it should rise")


@pytest.mark.parametrize("effect", ["", *EFFECTS])
def test_a_sound_log_has_no_slip(effect: str, tmp_path: Path) -> None:
    """Whatever is wrong with the cell."""
    name = effect if not effect or not EFFECTS[effect].per_channel else f"{effect}:tip_temperature"
    hidden = {name: EFFECTS[effect].size} if effect else {}
    columns = hide(hidden, INFORMATIVE[:6], seed=len(effect), interval=15.0)
    assert slips(experiment(tmp_path, columns)) == Slips()


def test_a_log_of_uneven_rows_has_no_slip(tmp_path: Path) -> None:
    logger = Logger(interval=10.0, jitter=2.4, room=0.3, pad_noise=0.2)
    assert slips(read([logged_file(tmp_path, {}, logger, 3)])) == Slips()


def test_torque_that_was_not_logged_comes_first_and_no_experiment_is_proposed(tmp_path: Path) -> None:
    columns = hide({}, INFORMATIVE[:7], interval=20.0, seed=4)
    del columns[TORQUE]
    found = diagnose_experiment(experiment(tmp_path, columns))
    assert found.verdict == "unknown"
    assert summary(found).splitlines()[1].startswith("Likely slip: torque or motor.current was not logged")
    assert found.proposed is None


@pytest.mark.parametrize(
    ("name", "said"),
    [
        (
            "sign",
            "wind falls where it should rise (correlation with the simulation -0.97): its sign is reversed",
        ),
        ("shift", "wind follows the inputs 200 s too late"),
        ("spike", "spike.csv: rows 302, 303, 304, 502: body leaps away and back by up to 34.1 K"),
        ("zero", "zero.csv: row 2: nothing but zeros, taken for missing values"),
        ("base", ""),
        ("warm", ""),
        ("uneven", ""),
    ],
)
def test_strangers_slips_are_said_by_check(
    name: str, said: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    file = given(f"logs_that_fail/{name}.toml")
    monkeypatch.setattr("sys.argv", ["warmlink", "diagnose", str(file), "--check"])
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 0
    told = [line for line in capsys.readouterr().out.splitlines() if line[:2] == "- " and line[:5] != "- no "]
    assert [said in line for line in told] == [True] * bool(said)


@pytest.mark.parametrize(("conductance", "said"), [("1 W/K", True), (None, False)])
def test_a_temperature_that_nobody_logged_is_said_where_something_conducts_to_it(
    conductance: str | None, said: bool, tmp_path: Path
) -> None:
    write_csv(_motor(), tmp_path / "a.csv")
    known = "" if conductance is None else f'[known]\n"motor.joint_conductance" = "{conductance}"\n'
    (tmp_path / "a.toml").write_text(f'system = "BenchMotor"\n[[run]]\ndata = "a.csv"\n{CHANNELS}{known}')
    unlogged = slips(read([tmp_path / "a.toml"])).unlogged
    assert ["motor.link_base_temperature was not logged" in each for each in unlogged] == [True] * said


def _motor() -> Columns:
    time = np.arange(0.0, 1800.0, 10.0)
    warm = 22 + 20 * -np.expm1(-time / 600) + np.random.default_rng(0).normal(0, 0.05, time.size)
    same = np.ones(time.size)
    return {"time [s]": time, "current [A]": 4 * same, "ambient_temperature [degC]": 22 * same} | {
        "shaft_temperature [degC]": warm
    }


@pytest.mark.parametrize("rows", [[50], [50, 51, 52], [50, 51, 52, 53]])
def test_the_rows_are_named_in_which_a_reading_leaps_away_and_back(rows: list[int], tmp_path: Path) -> None:
    columns = _motor()
    columns["shaft_temperature [degC]"][rows] += 34.0
    write_csv(columns, tmp_path / "a.csv")
    run = read_run(tmp_path / "a.csv", rig("BenchMotor"), {"shaft_temperature": "motor.shaft_temperature"})
    assert len(run.remarks) == (len(rows) <= 3)  # a plateau may be what it looks like
    assert all("shaft_temperature leaps away and back by up to 3" in each for each in run.remarks)
    named = f"row{'s' * (len(rows) > 1)} {', '.join(str(row + 2) for row in rows)}:"
    assert all(named in each for each in run.remarks)


@pytest.mark.parametrize(("row", "input_then"), [(0, 4.0), (90, 4.0)])
def test_a_row_of_zeros_counts_as_missing(row: int, input_then: float, tmp_path: Path) -> None:
    columns = _motor()
    for values in columns.values():
        values[row] = values[row] if values is columns["time [s]"] else 0.0
    write_csv(columns, tmp_path / "a.csv")
    run = read_run(tmp_path / "a.csv", rig("BenchMotor"), {"shaft_temperature": "motor.shaft_temperature"})
    assert run.inputs["motor.current"][row] == input_then
    assert run.inputs["motor.ambient_temperature"][row] == pytest.approx(295.15)
    assert np.isnan(run.readings["motor.shaft_temperature"][row])
    assert f"row {row + 2}: nothing but zeros" in run.remarks[0]


def test_a_machine_that_stands_still_at_0_degc_is_no_row_of_zeros(tmp_path: Path) -> None:
    columns = _motor()
    columns["current [A]"][:] = 0.0
    columns["ambient_temperature [degC]"][:] = 0.0
    columns["shaft_temperature [degC]"] = np.round(columns["shaft_temperature [degC]"] - 22, 1)
    write_csv(columns, tmp_path / "a.csv")
    run = read_run(tmp_path / "a.csv", rig("BenchMotor"), {"shaft_temperature": "motor.shaft_temperature"})
    assert run.remarks == ()


@pytest.mark.parametrize(("rate", "said"), [(0.02, "ever later"), (-0.02, "ever earlier")])
def test_a_clock_that_runs_fast_or_slow_is_told_from_one_that_is_late(
    rate: float, said: str, tmp_path: Path, sound: Columns
) -> None:
    time = sound["time [s]"]
    driving = ("time [s]", SPEED, TORQUE, PAD, "ambient_temperature [degC]")
    read_out = {n: np.interp(time / (1 + rate), time, v) for n, v in sound.items() if n not in driving}
    (sentence,) = slips(experiment(tmp_path, {**sound, **read_out})).wrong
    assert f"follows the inputs {said}, by " in sentence
    assert f"the readings runs {'fast' if rate > 0 else 'slow'}; log both by one" in sentence


def test_heat_that_no_reading_would_show_is_not_missed(tmp_path: Path) -> None:
    """Where friction and iron loss are known to be 0, a speed that nobody logged makes no heat."""
    none = [
        f'"motor.{name}" = 0' for name in ("coulomb_friction", "viscous_friction", "iron_loss_coefficient")
    ]
    for known, lacking in (([], 1), (none, 0)):
        path = bench(tmp_path, log(1200.0), BOUNDS)
        path.write_text(path.read_text().replace("[known]", "\n".join(["[known]", *known])))
        assert len(slips(read([path])).lacking) == lacking
