import sys
from pathlib import Path

import pytest

from tests.command import exit_code
from tests.pages import plots
from warmlink.controllers.observer.component import COMPONENT as OBSERVER
from warmlink.fmus.errors import InputError
from warmlink.orchestration.machine.shipped import WARMUP_CELL
from warmlink.orchestration.studies.design import design
from warmlink.orchestration.studies.plants import cell_plant_in
from warmlink.orchestration.studies.workers import FmuSet
from warmlink.orchestration.system.model import System
from warmlink.orchestration.system.ssp.parameter_values import read_ssv
from warmlink.orchestration.system.write import write_ssp


def run(arguments: list[str], monkeypatch: pytest.MonkeyPatch) -> int:
    return exit_code(["design", *arguments], monkeypatch)


def cell(fmus: FmuSet, **values: dict[str, float]) -> System:
    files = fmus.files()
    return WARMUP_CELL.system(files, "LagCompensator", values)


def test_a_regression_by_no_thermometer_is_refused() -> None:
    """It was said to go by the duty, and corrected nothing."""
    with pytest.raises(InputError, match="`sensors`: a regression goes by thermometers alone"):
        design("WarmupCell", "regression", [])


def test_for_the_nominal_cell_it_is_what_ships(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "observer.ssv"
    assert (
        run(["WarmupCell", "--law", "observer", "--sensors", "base,tip", "--out", str(path)], monkeypatch)
        == 0
    )
    values = read_ssv(path)
    starts = {scalar.name: scalar.start for scalar in OBSERVER.scalars() if scalar.name in values}
    assert len(values) > 100
    assert set(values) == set(starts)
    # Processors add in different orders: rows differ by 1e-8 of themselves between OPENBLAS_CORETYPEs.
    for name, start in starts.items():
        scale = max(abs(starts[other]) for other in starts if other.split("[")[0] == name.split("[")[0])
        assert values[name].value == pytest.approx(start, rel=1e-6, abs=1e-8 * scale), name


def test_a_systems_own_parameters_are_designed_for(
    tmp_path: Path, fmus: FmuSet, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    system = cell(fmus, motor={"joint_conductance": 2.0}, link={"conductivity": 200.0})
    plant = cell_plant_in(system)
    assert plant.given == {"motor.joint_conductance": 2.0, "link.conductivity": 200.0}
    write_ssp(system, tmp_path / "mine.ssp")
    out = tmp_path / "mine.ssv"
    assert run([str(tmp_path / "mine.ssp"), "--sensors", "shaft", "--out", str(out)], monkeypatch) == 0
    assert "motor.joint_conductance and link.conductivity changed from nominal" in capsys.readouterr().out
    values = read_ssv(out)
    nominal = {scalar.name: scalar.start for scalar in OBSERVER.scalars()}
    assert values["mode_rate[2]"].value != pytest.approx(nominal["mode_rate[2]"], rel=0.01)
    assert [values[f"sensor_std[{i}]"].value for i in range(1, 6)] == [0.1, 0, 0, 0, 0]


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["absent.ssp"], "absent.ssp"),
        (["BenchRod"], "BenchRod: has no motor with a link"),
        (["SixAxisArm"], "SixAxisArm: kinematics.error_norm is scored, which is no output of its motors"),
        (
            ["WarmupCell", "--law", "lag"],
            "lag: has no design; choose regression, linear_observer, observer or",
        ),
        (["WarmupCell", "--camera-std", "1 um"], "observer does not use the camera; observer_drift does"),
        (
            ["WarmupCell", "--sensors", "none,base"],
            "--sensors none,base: none cannot be combined with thermometers",
        ),
        (["WarmupCell", "--sensors", "base,nose"], "'nose' is not measured"),
        (["WarmupCell", "--sensor-std", "0 K"], "--sensor-std: 0 K is not positive"),
        (["WarmupCell", "--sample-time", "1e-9 s"], "--sample-time 1e-9 s: is too short; give at least"),
        (["WarmupCell", "--sensor-std", "1 m"], "m does not convert to K"),
        (["WarmupCell", "--out", "gains.txt"], "is no parameter set"),
        (["WarmupCell", "--out", "taken/x.ssv"], "cannot be written"),
        (["WarmupCell", "--report", "taken/x.html"], "cannot be written"),
        (["WarmupCell", "--law", "regression", "--report", "x.html"], "regression has no model to show"),
    ],
)
def test_a_bad_design_is_refused(
    arguments: list[str],
    sentence: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("taken").write_text("a file")
    assert run(arguments, monkeypatch) == 2
    error = capsys.readouterr().err
    assert sentence in error
    assert error.count("\n") == 1
    assert sorted(tmp_path.iterdir()) == [tmp_path / "taken"]


def test_a_system_without_a_motor_is_refused(fmus: FmuSet) -> None:
    kept = {"link": cell(fmus).components["link"]}
    with pytest.raises(InputError, match="needs one MotorHeatSource, and the system has none"):
        cell_plant_in(System("rod", kept))


def test_the_page_shows_poles_and_bode_plots(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    page, values = tmp_path / "design.html", tmp_path / "observer.ssv"
    assert run(["WarmupCell", "--report", str(page), "--out", str(values)], monkeypatch) == 0
    text = page.read_text()
    assert "observer for WarmupCell" in text
    assert "Bode plot, 3.43 rad/s" in text
    assert "<th>still, reduced [min]</th>" in text
    for heading in ("which thermometers are worth", "Gains of the filter", "Poles of the filter"):
        assert heading in text
    assert "<h2>Time constants of the plant</h2>" in text
    assert "<td>none, the duty alone</td>" in text
    assert '"dash":"dashdot"' in plots(page), "each input's line has a dash of its own beside its colour"
    assert "<td>28.4</td>" in text, "the slowest pattern of motor and link lasts half an hour"


def test_a_page_without_what_draws_it_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setitem(sys.modules, "control", None)  # as where it is not installed
    assert run(["WarmupCell", "--report", "design.html"], monkeypatch) == 2
    told = capsys.readouterr().err
    sentence = 'a linear model (python-control) needs an optional part: pip install "warmlink[studies]"'
    assert told == f"warmlink: {sentence}\n"
    assert not list(tmp_path.iterdir())


def test_set_changes_the_plant_that_is_designed_for(
    tmp_path: Path, fmus: FmuSet, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    write_ssp(cell(fmus, motor={"joint_conductance": 2.0}), tmp_path / "mine.ssp")
    changes = [
        "--set",
        "link.length=400 mm",
        "--set",
        "link.tip_position=38 cm",
        "--set",
        "link.width=0.0254 m",
    ]
    stiffer = [*changes, "--set", "motor.joint_conductance=2 W/K"]
    for name, arguments in (("a", ["WarmupCell", *stiffer]), ("b", [str(tmp_path / "mine.ssp"), *changes])):
        assert run([*arguments, "--out", str(tmp_path / f"{name}.ssv")], monkeypatch) == 0
        said = capsys.readouterr().out
        for parameter in ("motor.joint_conductance", "link.length", "link.tip_position"):
            assert parameter in said
        assert "link.width" not in said
    one, other = (read_ssv(tmp_path / f"{name}.ssv") for name in "ab")
    assert {k: v.value for k, v in one.items()} == {k: v.value for k, v in other.items()}
    assert run(["WarmupCell", "--out", str(tmp_path / "c.ssv")], monkeypatch) == 0
    assert read_ssv(tmp_path / "c.ssv")["mode_rate[2]"].value != one["mode_rate[2]"].value


@pytest.mark.parametrize(
    ("setting", "sentence"),
    [
        ("link.length", "no value"),
        ("link.lenght=1 m", "did you mean length"),
        ("link.length=-1 m", "-1 m"),
        ("link.length=1 kg", "kg does not convert"),
        ("sensors.seed=3", "no component sensors; choose motor or link"),
        ("motor.torque=3 N.m", "motor.torque: is an input"),
    ],
)
def test_a_plant_that_cannot_be_is_refused(
    setting: str,
    sentence: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert run(["WarmupCell", "--set", setting, "--out", str(tmp_path / "x.ssv")], monkeypatch) == 2
    assert sentence in capsys.readouterr().err
    assert not (tmp_path / "x.ssv").exists()
