"""What nobody gave is said aloud, assumed on request, or refused: never quietly taken as nothing."""

import json
import re
import shlex
from contextlib import suppress
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from warmlink.fmus.errors import InputError
from warmlink.orchestration.cli import main
from warmlink.orchestration.diagnosis.data.experiment import read_experiment
from warmlink.orchestration.diagnosis.data.inputs import with_inputs, with_nominal
from warmlink.orchestration.diagnosis.data.measured import Run, condensed
from warmlink.orchestration.diagnosis.data.options import read_options
from warmlink.orchestration.diagnosis.diagnose import diagnose_experiment, read
from warmlink.orchestration.diagnosis.fit.problem import Problem
from warmlink.orchestration.diagnosis.fit.verdict import assess
from warmlink.orchestration.diagnosis.model.simulation import input_table
from warmlink.orchestration.diagnosis.practice.hide import STILL, hide, write_csv
from warmlink.orchestration.machine.rig import rig
from warmlink.orchestration.report.diagnosis import write_diagnosis
from warmlink.orchestration.scenarios.duties.duty import Segment

pytestmark = pytest.mark.usefixtures("as_a_command")

FOLDER = "warmlink.orchestration.report.diagnosis"

Columns = dict[str, np.ndarray]
INPUTS = ("speed", "torque", "pad_temperature", "ambient_temperature")


@pytest.fixture(scope="module")
def whole() -> Columns:
    return hide({}, STILL, seed=1)


def without(columns: Columns, *names: str) -> Columns:
    return {header: values for header, values in columns.items() if header.split()[0] not in names}


def written(folder: Path, columns: Columns, name: str = "run.csv") -> Path:
    write_csv(columns, folder / name)
    return folder / name


def experiment(folder: Path, columns: Columns, more: str) -> Path:
    written(folder, columns)
    path = folder / "lab.toml"
    path.write_text(f'system = "WarmupCell"\n[[run]]\ndata = "run.csv"\n{more}')
    return path


def test_a_run_with_every_input_needs_no_remark(tmp_path: Path, whole: Columns) -> None:
    assert with_inputs(read_experiment(written(tmp_path, whole))).remarks == ()


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("torque", 'no torque column: taken as 0 N.m; give --assume "torque=0" to say so'),
        (
            "pad_temperature",
            'no pad_temperature column: taken as off; give --assume "pad_temperature=off" to say',
        ),
        ("ambient_temperature", 'taken as 22 degC; give --assume "ambient_temperature=22 degC" to say so'),
    ],
)
def test_an_absent_input_is_said_aloud_until_it_is_assumed(
    tmp_path: Path, whole: Columns, name: str, said: str
) -> None:
    read = read_experiment(written(tmp_path, without(whole, name)))
    (remark,) = with_inputs(read).remarks
    assert said in remark
    option = remark.partition("--assume ")[2].partition(" to say")[0].replace('"', "")
    assert with_inputs(read, [option]).remarks == ()


def test_a_remark_names_the_runs_that_lack_the_column(tmp_path: Path, whole: Columns) -> None:
    written(tmp_path, without(whole, "torque"), "first.csv")
    path = experiment(tmp_path, whole, '[[run]]\ndata = "first.csv"\n')
    assert with_inputs(read_experiment(path)).remarks[0].startswith("first: no torque column")


def test_what_the_machine_did_in_a_pause_of_the_log_is_said_to_be_unknown(
    tmp_path: Path, whole: Columns
) -> None:
    time = whole["time [s]"]
    there = (time < 600) | (time > 1500)
    pausing = {header: values[there] for header, values in whole.items()}
    (remark,) = with_inputs(read_experiment(written(tmp_path, pausing))).remarks
    assert remark == (
        "the log pauses for 15.17 min from 9.889 min on: the machine is taken to go on as in the row before; "
        "if it did not, add rows of what it did, with empty cells for what was not measured"
    )
    unread = [header for header in whole if header.split()[0] not in ("time", *INPUTS)]
    told = there | (np.abs(time - 700) < 5)
    filled = {h: np.where(there, v, np.nan)[told] if h in unread else v[told] for h, v in whole.items()}
    assert with_inputs(read_experiment(written(tmp_path, filled))).remarks == ()


def test_pauses_are_counted_for_each_run_and_short_ones_passed_over(tmp_path: Path, whole: Columns) -> None:
    time = whole["time [s]"]
    short = {header: values[(time < 600) | (time > 690)] for header, values in whole.items()}
    twice = {h: v[(time < 600) | (time > 900) & (time < 1200) | (time > 1500)] for h, v in whole.items()}
    written(tmp_path, twice, "twice.csv")
    path = experiment(tmp_path, short, '[[run]]\ndata = "twice.csv"\n')
    (remark,) = with_inputs(read_experiment(path)).remarks
    assert remark.startswith("twice: the log pauses 2 times, the longest for 5.167 min from ")


def test_a_run_that_nothing_drives_is_refused(tmp_path: Path, whole: Columns) -> None:
    path = written(tmp_path, without(whole, *INPUTS))
    with pytest.raises(InputError, match="nothing drives the run") as refusal:
        diagnose_experiment(read([path]))
    option = str(refusal.value).rpartition("stood still: ")[2]
    still = with_inputs(read_experiment(path), shlex.split(option.replace("--assume ", "")))
    assert [remark.partition(" column")[0] for remark in still.remarks] == ["no ambient_temperature"]


def test_channels_add_to_the_names_that_columns_have_anyway(tmp_path: Path, whole: Columns) -> None:
    renamed = {h.replace("speed", "axis speed"): values for h, values in whole.items()}
    path = experiment(tmp_path, renamed, '[channels]\n"axis speed [rad/s]" = "motor.speed"\n')
    run = read_experiment(path).runs[0]
    assert set(run.inputs) == {f"motor.{name}" for name in INPUTS}
    assert len(run.readings) == 6


def test_a_named_column_that_no_file_has_is_refused(tmp_path: Path, whole: Columns) -> None:
    (tmp_path / "other").mkdir()
    renamed = {h.replace("base_temperature", "T base"): values + 0.01 for h, values in whole.items()}
    one, other = written(tmp_path, whole), written(tmp_path / "other", renamed)
    with pytest.raises(InputError, match=r"there is no column 'T bse'; did you mean T base"):
        read([other, one], options=read_options(names=["T bse=base_temperature"]))
    for name, meant in (("base_temprature", "base_temperature"), ("clock", "time"), ("fan", "")):
        with pytest.raises(InputError, match=f"there is no column {name!r}"):
            read([one], options=read_options(names=[f"{name}={meant}"]))
    # A file of another logger may have it under its own name.
    assert len(read([one, other], options=read_options(names=["T base=base_temperature"])).columns) == 6
    path = experiment(tmp_path, whole, '[channels]\n"axis speed [rad/s]" = "motor.speed"\n')
    with pytest.raises(InputError, match=r"there is no column 'axis speed \[rad/s\]'"):
        read([path])


def test_a_column_that_nothing_is_made_of_is_said(tmp_path: Path, whole: Columns) -> None:
    columns = {**without(whole, "torque"), "torqe [N.m]": whole["torque [N.m]"]}
    path = experiment(tmp_path, columns, '[channels]\n"speed [rad/s]" = "motor.speed"\n')
    remarks = with_inputs(read_experiment(path)).remarks
    assert "no torque column" in remarks[0]
    assert "torqe [N.m]" in remarks[1]


@pytest.mark.parametrize(
    ("assumed", "said"),
    [
        ("torque", "no value"),
        ("torque=much", "not a value"),
        ("torque=2 kg", "does not convert"),
        ("speed=1", "every run has this input"),
        ("link.length=1 m", "is no input"),
        ("torqe=0", "is no input"),
    ],
)
def test_a_wrong_assumption_is_refused(tmp_path: Path, whole: Columns, assumed: str, said: str) -> None:
    read = read_experiment(written(tmp_path, without(whole, "torque")))
    with pytest.raises(InputError, match=said):
        with_inputs(read, [assumed])


def test_two_columns_for_one_input_are_refused(tmp_path: Path, whole: Columns) -> None:
    twice = {**whole, "torque [mN.m]": 1000 * whole["torque [N.m]"]}
    with pytest.raises(InputError, match=r"'torque \[N.m\]' and 'torque \[mN.m\]' are both motor.torque"):
        read_experiment(written(tmp_path, twice))


def test_remarks_stand_in_json_on_the_page_and_on_the_terminal(
    tmp_path: Path, whole: Columns, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    path = written(tmp_path, without(whole, "ambient_temperature"))
    monkeypatch.setattr("warmlink.orchestration.fmu_store.FmuStore.files", lambda *arguments: {})
    monkeypatch.setattr(f"{FOLDER}.write_ssp_of", lambda *arguments: None)
    monkeypatch.setattr("sys.argv", ["warmlink", "diagnose", str(path), "--out", str(tmp_path / "out")])
    with suppress(SystemExit):  # which typer raises with 0 when all is well
        main()
    said = "no ambient_temperature column"
    assert said in capsys.readouterr().err
    assert said in json.loads((tmp_path / "out" / "diagnosis.json").read_text())["remarks"][0]
    assert said in (tmp_path / "out" / "report.html").read_text()


@pytest.mark.parametrize(
    ("inputs", "known", "mode"),
    [
        ({"motor.pad_temperature": np.array([310.0, np.nan])}, {}, [2, 0]),
        (
            {"motor.pad_temperature": np.array([310.0, 310.0]), "motor.pad_mode": np.array([0.0, 2.0])},
            {},
            [0, 2],
        ),
        ({"motor.pad_power": np.array([20.0, 0.0])}, {}, [1, 1]),
        ({}, {"motor.pad_temperature": 310.0}, [2, 2]),
        ({}, {}, [0, 0]),
    ],
)
def test_the_pad_is_switched_by_whatever_was_said_of_it(
    inputs: dict[str, np.ndarray], known: dict[str, float], mode: list[int]
) -> None:
    cell = rig("WarmupCell", 20)
    table = input_table(cell, Run("run", np.array([0.0, 1.0]), inputs, {}), known)
    assert table[cell.externals.index("motor.pad_mode")].tolist() == mode


def test_a_discrete_input_of_a_condensed_run_is_taken_not_averaged() -> None:
    on = np.array([1.0, 0.0, 0.0, 1.0, 1.0, 0.0])
    run = Run("long", np.arange(6.0), {"heater.on": on, "link.speed": on}, {"link.elongation": on})
    short = condensed(run, ["heater.on"], most=2)
    assert short.inputs["heater.on"].tolist() == [1.0, 1.0]
    assert short.inputs["link.speed"].tolist() == pytest.approx([1 / 3, 2 / 3])


def test_a_mode_that_is_no_mode_is_refused(tmp_path: Path, whole: Columns) -> None:
    columns = {**without(whole, "pad_temperature"), "mode [1]": np.full(whole["time [s]"].size, 1.5)}
    path = experiment(tmp_path, columns, '[channels]\n"mode [1]" = "motor.pad_mode"\n')
    with pytest.raises(InputError, match=r"row 2, column 'mode.*not a whole number"):
        read_experiment(path)


def test_another_nominal_is_where_the_diagnosis_starts_from(tmp_path: Path, whole: Columns) -> None:
    """A cell of half the convection, said so, is adequate; and the extended model has it."""
    columns = hide({"still_air_convection": 0.5}, STILL, seed=2)
    path = written(tmp_path, columns)
    assert assess(read([path])).word != "adequate"
    found = diagnose_experiment(read([path], settings={"link.convection_still": "2.275 W/(m2.K)"}))
    assert found.verdict == "adequate"
    files = write_diagnosis(found, tmp_path / "out")
    assert "link.convection_still" in files["extended.ssv"].read_text()


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"link.lenght": "1 m"}, "did you mean length"),
        ({"link.length": "1 kg"}, "does not convert"),
        ({"link.length": "200 mm"}, "lies beyond the link's end"),
        ({"link.width": "-1 mm"}, "not positive"),
        ({"motor.torque": "2"}, '--assume "motor.torque=2"'),
    ],
)
def test_a_nominal_that_cannot_be_is_refused(
    tmp_path: Path, whole: Columns, settings: dict[str, str], said: str
) -> None:
    read = read_experiment(written(tmp_path, whole))
    with pytest.raises(InputError, match=said):
        with_nominal(read, settings)


def test_an_offset_of_an_input_is_that_of_its_own_column_alone() -> None:
    """Where the tip's sink was not logged, the surroundings' temperature stands for it; here it was."""
    columns = hide({}, (Segment(1200, 3.43, 2.5),))
    columns["link.tip_sink_temperature [degC]"] = np.full(columns["time [s]"].size, 30.0)
    warm = read([pd.DataFrame(columns)], settings={"link.tip_conductance": "0.5 W/K"})
    columns["link.tip_sink_temperature [degC]"] += 1.0
    warmer = read([pd.DataFrame(columns)], settings={"link.tip_conductance": "0.5 W/K"})
    problem, other = Problem(warm), Problem(warmer)
    values = problem.neutral[0].copy()
    values[problem.slots.index("logged.offset:link.tip_sink_temperature")] = 1.0
    shifted, logged = problem.predict(0, values)[0], other.predict(0, other.neutral[0])[0]
    assert shifted == pytest.approx(logged, abs=0.01)  # to within the error of the search's steps


@pytest.mark.parametrize(
    ("assumed", "said"),
    [
        ("ambient_temperature=22", '22 has no unit; write "22 degC" or "22 K"'),
        ("ambient_temperature=-300 degC", "is too low; give at least 0 K"),
        ("motor.current=2 A", "run has torque, and both would count; leave the assumption out"),
    ],
)
def test_what_cannot_be_assumed_is_refused(tmp_path: Path, whole: Columns, assumed: str, said: str) -> None:
    """22 K were taken for the room, and a current counted beside the torque."""
    measured = read_experiment(written(tmp_path, without(whole, "ambient_temperature")))
    with pytest.raises(InputError, match=re.escape(said)):
        with_inputs(measured, [assumed])


def test_a_known_temperature_without_its_unit_is_refused(tmp_path: Path, whole: Columns) -> None:
    path = experiment(tmp_path, without(whole, "ambient_temperature"), "")
    path.write_text(path.read_text("utf-8") + '[known]\n"motor.ambient_temperature" = 22\n', "utf-8")
    with pytest.raises(InputError, match="22 has no unit"):
        read_experiment(path)
