"""`warmlink hide` and `warmlink diagnose` on the command line: duties, names, full and read-only disks."""

import errno
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from warmlink.fmus.errors import InputError
from warmlink.orchestration.cli import main
from warmlink.orchestration.diagnosis.answer.diagnosis import Diagnosis
from warmlink.orchestration.diagnosis.data.experiment import read_experiment
from warmlink.orchestration.diagnosis.diagnose import diagnose_experiment, read
from warmlink.orchestration.diagnosis.fit.verdict import assess
from warmlink.orchestration.diagnosis.practice.effects import EFFECTS, about_effects, effect_of, with_changes
from warmlink.orchestration.diagnosis.practice.hidden import Truth
from warmlink.orchestration.diagnosis.practice.hide import STILL, duty_of, hide, write_csv
from warmlink.orchestration.scenarios.duties.duty import length

FOLDER = "warmlink.orchestration.report.diagnosis"
DUTY = (
    "time [s],speed [rad/s],torque [N.m],pad_temperature [degC]\n0,3,2,\n613,0,0,40\n1801,1,4,\n3600,1,4,\n"
)


@pytest.fixture(autouse=True)
def _in_a_fresh_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def ended(
    arguments: list[str], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> tuple[object, str, str]:
    """Exit code, answer and remarks of a command."""
    monkeypatch.setattr("sys.argv", ["warmlink", *arguments])
    with pytest.raises(SystemExit) as stop:
        main()
    out, err = capsys.readouterr()
    return stop.value.code or 0, out, err


def test_a_run_follows_a_recorded_duty_cycle(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """What is hidden is found and nothing else, although no row stands where the duty changes."""
    Path("shift.csv").write_text(DUTY)
    arguments = ["hide", "joint_resistance", "--duty", "shift.csv", "--out", "run.csv"]
    code, out, _ = ended(arguments, monkeypatch, capsys)
    assert code == 0
    assert "1 h with joint_resistance" in out
    table = pd.read_csv("run.csv").set_index("time [s]")
    assert table.loc[612.9:613.1].empty
    assert table["pad_temperature [degC]"].notna().sum() == pytest.approx(119, abs=2)
    assert assess(read_experiment(Path("run.csv"))).best.key == {"joint_resistance"}


def test_what_bends_the_link_is_its_true_gradient_in_any_order() -> None:
    true = {
        "elongation": np.full(3, 1e-4),
        "base_temperature": np.full(3, 310.0),
        "tip_temperature": np.full(3, 300.0),
    }
    bent = EFFECTS["bending"].on_readings, 0.08e-6, "elongation"
    off = EFFECTS["sensor_offset"].on_readings, 5.0, "base_temperature"
    for changes in ([bent, off], [off, bent]):
        found = with_changes(np.arange(3.0), true, changes)
        assert found["elongation"] == pytest.approx(108e-6)
        assert found["base_temperature"] == pytest.approx(315.0)
    assert true["base_temperature"].tolist() == [310.0] * 3


def test_what_moves_the_room_adds_up() -> None:
    both = Truth()
    for name in ("open_door", "air_conditioning"):
        change = EFFECTS[name].on_truth
        assert change is not None
        both = change(both, EFFECTS[name].size, 7200.0)
    assert both.room(1875.0) == pytest.approx(-4.0 + 2.0)


def test_pieces_of_a_repeated_duty_cycle_may_be_shorter_than_a_step() -> None:
    parts = "".join(
        f'[[segment]]\nduration = "{lasts} s"\nspeed = "{speed} rad/s"\n'
        for lasts, speed in ((7.3, 1), (2.9, 2), (1.8, 0))
    )
    Path("rep.toml").write_text(f'stop_time = "1800 s"\nrepeat = true\n{parts}')
    duty = duty_of("rep.toml")
    assert len(duty) == 450
    assert length(duty) == pytest.approx(1800.0)
    Path("fast.csv").write_text("time [s],speed [rad/s]\n0,1\n0.0005,2\n30,2\n")
    assert len(hide({}, duty_of("fast.csv"))["time [s]"]) >= 2


@pytest.mark.parametrize("scenario", [(), ("--scenario", "still_with_pad")])
def test_a_duty_cycle_that_is_too_short_for_two_rows_is_refused(
    scenario: tuple[str, ...], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("short.toml").write_text('stop_time = "8 s"\n[[segment]]\nduration = "8 s"\nspeed = "1 rad/s"\n')
    arguments = ["hide", "joint_resistance", "--duty", "short.toml", *scenario]
    code, _, err = ended(arguments, monkeypatch, capsys)
    assert (code, err.count("\n")) == (2, 1)
    assert "duty: it makes a run of one row" in err
    assert "give at least 20 s" in err


@pytest.mark.parametrize("size", [0.0, 0.0005, -0.1])
def test_a_sensor_that_is_stuck_for_no_reading_is_refused(size: float) -> None:
    with pytest.raises(InputError, match=r"effect: stuck_sensor=.*: no reading falls into .*; give 0\.15"):
        hide({"stuck_sensor:tip_temperature": size})


def test_a_scenario_s_duty_cycle_lasts_as_long_as_the_scenario() -> None:
    Path("shift.toml").write_text(
        'stop_time = "50 min"\nrepeat = true\n[[segment]]\nduration = "20 min"\nspeed = "3 rad/s"\n'
        '[[segment]]\nduration = "10 min"\ntorque = "2 N.m"\n'
    )
    assert [(s.duration, s.speed, s.torque) for s in duty_of("shift.toml")] == [
        (1200, 3, 0),
        (600, 0, 2),
        (1200, 3, 0),
    ]
    assert sum(s.duration for s in duty_of("windshield_wiper")) == 7200


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--duty", "absent.csv"], "absent.csv"),
        (["--duty", "nowhere"], "nowhere: no such scenario"),
        (["--duty", "power.toml"], "give pad_temperature"),
        (["--duty", "long.toml"], "give at most 100"),
        (["--duty", "shift.csv", "--axis", "3"], "leave --duty shift.csv out"),
        (["radiatoin"], "did you mean radiation"),
        (["radiation:tip_temperature"], "write radiation"),
        (["radiation=nan"], "radiation=nan: is not finite"),
        (["radiation=1e999"], "radiation=inf: is not finite"),
    ],
)
def test_hide_refuses_in_one_sentence(
    arguments: list[str],
    said: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    Path("shift.csv").write_text(DUTY)
    Path("power.toml").write_text('stop_time = "1 h"\n[[segment]]\nduration = "1 h"\npad_power = "20 W"\n')
    Path("long.toml").write_text('stop_time = "8000 h"\n[[segment]]\nduration = "1 h"\n')
    Path("short.toml").write_text('stop_time = "1 h"\nrepeat = true\n[[segment]]\nduration = "1e-9 s"\n')
    code, _, err = ended(["hide", *arguments], monkeypatch, capsys)
    assert code == 2
    assert said in err
    assert err.count("\n") == 1
    assert not Path("run.csv").exists()


def test_every_effect_says_what_it_is(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    about = about_effects()
    assert len(about) == len(EFFECTS)
    assert all(text[0].isupper() and ". Ordinarily" in text for text in about.values())
    assert about["conductivity"].endswith("Ordinarily 0.8 times the nominal.")
    assert about["sensor_lag:CHANNEL"].endswith("Ordinarily 60 in SI units.")
    for name in about:
        effect_of(name.replace("CHANNEL", "tip_temperature"))
    _, out, _ = ended(["list", "--json"], monkeypatch, capsys)
    assert all(f'"{name}"' in out for name in about)


def full(*arguments: object, **named: object) -> None:
    raise OSError(errno.ENOSPC, "No space left on device")


def read_only(*arguments: object, **named: object) -> None:
    raise OSError(errno.EROFS, "Read-only file system")


@pytest.mark.parametrize("fault", [full, read_only])
@pytest.mark.parametrize("where", ["pandas.DataFrame.to_csv", "pathlib.Path.replace"])
def test_a_made_up_run_that_cannot_be_written_is_not_there(
    where: str, fault: object, monkeypatch: pytest.MonkeyPatch
) -> None:
    columns = hide({}, STILL, seed=0)
    Path("run.csv").write_text("an older run")
    monkeypatch.setattr(where, fault)
    with pytest.raises(InputError, match=r"run\.csv: cannot be written"):
        write_csv(columns, Path("run.csv"))
    assert Path("run.csv").read_text() == "an older run"
    assert [path.name for path in Path().iterdir()] == ["run.csv"]


def test_a_folder_that_is_not_there_is_a_sentence() -> None:
    with pytest.raises(InputError, match=r"absent/run\.csv: cannot be written"):
        write_csv({"time [s]": np.arange(3.0)}, Path("absent/run.csv"))


@pytest.fixture(scope="module")
def adequate(tmp_path_factory: pytest.TempPathFactory) -> Diagnosis:
    """Of a run in which nothing is hidden."""
    path = tmp_path_factory.mktemp("adequate") / "run.csv"
    write_csv(hide({}, STILL, seed=0), path)
    return diagnose_experiment(read([path]))


@pytest.mark.parametrize(
    "where",
    [
        "warmlink.orchestration.files.tempfile.mkdtemp",
        f"{FOLDER}.write_ssv",
        f"{FOLDER}.write_ssp_of",
        "pathlib.Path.write_text",
        "pathlib.Path.replace",
    ],
)
def test_what_a_diagnosis_found_is_told_though_it_cannot_be_written(
    where: str, adequate: Diagnosis, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    write_csv(hide({}, STILL, seed=0), Path("run.csv"))
    monkeypatch.setattr("warmlink.orchestration.diagnosis.diagnose.diagnose_experiment", lambda *_: adequate)
    monkeypatch.setattr("warmlink.orchestration.fmu_store.FmuStore.files", lambda *arguments: {})
    monkeypatch.setattr(f"{FOLDER}.write_ssp_of", lambda *arguments: None)
    monkeypatch.setattr(where, full)
    code, out, err = ended(["diagnose", "run.csv", "--out", "found"], monkeypatch, capsys)
    assert code == 2
    assert "run: adequate" in out
    assert "found: cannot be written" in err
    if "mkdtemp" not in where:
        assert "only the answer above is left" in err
    assert err.count("\n") == 1
    assert not Path("found").exists()


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["joint_conductance=0"], "joint_conductance=0: the strength is a factor; give one above 0"),
        (["conductivity=-1"], "conductivity=-1: the strength is a factor; give one above 0"),
        (["joint_resistance=-1"], "effects: between 0 and 300 s the cell's temperatures grow beyond all"),
        (["hub_heat_loss=-5"], "the cell's temperatures grow beyond all bounds; give weaker effects"),
        (["--seed", "-1"], "--seed -1: is negative; give 0 or above"),
    ],
)
def test_effects_that_no_cell_can_have_are_refused(
    arguments: list[str],
    sentence: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    code, _, err = ended(["hide", *arguments, "--out", "run.csv"], monkeypatch, capsys)
    assert code == 2
    assert sentence in err
    assert not Path("run.csv").exists()


def test_a_term_is_hidden(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    Path("shift.csv").write_text(DUTY)
    law = "a * step(speed - b) * lag(shaft_temperature - ambient_temperature, 300)"
    term = f"base: {law}; a = 1 W/K; b = 2 rad/s"
    arguments = ["hide", "--duty", "shift.csv", "--out"]
    ended([*arguments, "bare.csv"], monkeypatch, capsys)
    code, out, _ = ended([*arguments, "run.csv", "--term", term], monkeypatch, capsys)
    assert code == 0
    assert f"{term} hidden" in out
    change = pd.read_csv("run.csv") - pd.read_csv("bare.csv")
    assert change.loc[change["time [s]"].index < 2, "base_temperature [degC]"].abs().max() < 0.01
    assert change["base_temperature [degC]"].max() > 2
    assert change["base_temperature [degC]"].iloc[-1] < 0.5, "it stops with the speed"


@pytest.mark.parametrize(
    ("term", "said"),
    [
        ("gear: 1", "is no place and heat"),
        ("shaft 1", "is no place and heat"),
        ("shaft:", "is no place and heat"),
        ("shaft: a; a", "is no value of a parameter"),
        ("shaft: a; a = 3 parrots", "parrots"),
        ("shaft: a * speed; a = 3 W", "heat is in W"),
        ("shaft: a * b; a = 3 W", "b is neither"),
        ("shaft: 3 * neighbour_temperature", "has no neighbour_temperature"),
        ("shaft: link.temperature[3]", "link.temperature[3]"),
        ("shaft: 1 / speed", "divided by 0"),
        ("shaft: a * exp(1000 * speed); a = 1", "no heat below 1e+06 W"),
    ],
)
def test_what_is_no_term_is_refused(
    term: str, said: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    code, _, err = ended(["hide", "--term", term], monkeypatch, capsys)
    assert code == 2
    assert said in err
    assert not Path("run.csv").exists()


@pytest.mark.parametrize("other", [["--with", "fea"], ["--axis", "2"]])
def test_only_the_cell_on_a_grid_has_terms(
    other: list[str], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    code, _, err = ended(["hide", "--term", "tip: 1", *other], monkeypatch, capsys)
    assert code == 2
    assert "leave --" in err
