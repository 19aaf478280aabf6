from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tests.orchestration.diagnosis.loggers import sticking
from warmlink.fmus.errors import InputError
from warmlink.fmus.motor_heat_source.equations import PAD_POWER, PAD_TEMPERATURE
from warmlink.orchestration.diagnosis.data.experiment import read_experiment
from warmlink.orchestration.diagnosis.data.measured import Run, condensed, read_run
from warmlink.orchestration.diagnosis.data.options import read_options
from warmlink.orchestration.diagnosis.data.signals import between_jumps, quantum, repeats
from warmlink.orchestration.diagnosis.model.simulation import input_table
from warmlink.orchestration.machine.rig import rig

HEAD = (
    "time [s],speed [rad/s],torque [N.m],ambient_temperature [degC],"
    "shaft_temperature [degC],elongation [um]\n"
)


def rows(count: int = 30, step: float = 10.0) -> list[str]:
    return [f"{i * step:g},3.43,2.5,22,{22 + 0.1 * i:g},{0.2 * i:g}" for i in range(count)]


def written(folder: Path, lines: list[str], head: str = HEAD) -> Path:
    path = folder / "run.csv"
    path.write_text(head + "\n".join(lines) + "\n")
    return path


def test_columns_become_si_values(tmp_path: Path) -> None:
    run = read_experiment(written(tmp_path, rows())).runs[0]
    assert run.inputs["motor.ambient_temperature"][0] == pytest.approx(295.15)
    assert run.readings["motor.shaft_temperature"][1] == pytest.approx(295.25)
    assert run.readings["link.elongation"][10] == pytest.approx(2e-6)
    assert run.fitted.sum() == pytest.approx(0.7 * 30, abs=1)


def test_units_are_converted(tmp_path: Path) -> None:
    head = HEAD.replace("time [s]", "time [min]").replace(
        "shaft_temperature [degC]", "shaft_temperature [degF]"
    )
    run = read_experiment(written(tmp_path, rows(), head)).runs[0]
    assert run.time[1] == pytest.approx(600.0)
    assert run.readings["motor.shaft_temperature"][0] == pytest.approx(267.594, abs=1e-3)


def test_an_empty_input_holds_and_an_empty_pad_is_off(tmp_path: Path) -> None:
    head = HEAD.replace("\n", ",pad_temperature [degC]\n")
    lines = [line + (",36" if i < 10 else ",") for i, line in enumerate(rows())]
    lines[5] = lines[5].replace(",3.43,", ",,")
    run = read_experiment(written(tmp_path, lines, head)).runs[0]
    assert run.inputs["motor.speed"][5] == 3.43
    assert np.isnan(run.inputs["motor.pad_temperature"][20])
    told = "cells of speed are empty and taken for the value before; where it was off, write 0"
    assert run.remarks == (f"run.csv: 1 of 30 {told}",)


def test_a_pad_is_off_in_the_empty_cells_of_its_power_and_that_is_said(tmp_path: Path) -> None:
    head = HEAD.replace("\n", ",pad_power [W]\n")
    lines = [line + (",20" if i < 10 else ",") for i, line in enumerate(rows())]
    run = read_experiment(written(tmp_path, lines, head)).runs[0]
    assert run.inputs["motor.pad_power"].tolist() == [20.0] * 10 + [0.0] * 20
    assert run.remarks == ("run.csv: 20 of 30 cells of pad_power are empty and taken for off",)


@pytest.mark.parametrize(("column", "off"), [("pad_temperature [degC]", np.nan), ("pad_power [W]", 0.0)])
def test_a_pad_may_be_off_in_words_most_of_the_time(tmp_path: Path, column: str, off: float) -> None:
    """The word was taken for a missing value, and refused where it filled most cells."""
    lines = [f"{line},{'Off' if i < 20 else 'ERR' if i == 25 else 30}" for i, line in enumerate(rows())]
    run = read_experiment(written(tmp_path, lines, HEAD.replace("\n", f",{column}\n"))).runs[0]
    (pad,) = (values for name, values in run.inputs.items() if "pad" in name)
    on = 303.15 if np.isnan(off) else 30.0
    np.testing.assert_allclose(pad, [off] * 20 + [on] * 10)
    assert run.remarks == (f"run.csv: row 27, column {column!r}: 'ERR' is taken for a missing value",)


def test_a_pad_has_its_power_where_its_temperature_is_empty(tmp_path: Path) -> None:
    """The power was left out, and the pad off, as soon as there was a column of temperatures."""
    head = HEAD.replace("\n", ",pad_temperature [degC],pad_power [W]\n")
    lines = [line + (",,20" if i < 10 else ",36," if i < 20 else ",,0") for i, line in enumerate(rows())]
    whole = read_experiment(written(tmp_path, lines, head))
    assert whole.runs[0].unused == ()
    mode = input_table(whole.rig, whole.runs[0], {})[whole.rig.externals.index("motor.pad_mode")]
    assert mode.tolist() == [PAD_POWER] * 10 + [PAD_TEMPERATURE] * 10 + [PAD_POWER] * 10


def test_a_current_stands_for_the_torque_and_is_not_used_beside_it(tmp_path: Path) -> None:
    head = HEAD.replace("\n", ",current [A],neighbour_temperature [degC]\n")
    lines = [f"{line},2,30" for line in rows()]
    both = read_experiment(written(tmp_path, lines, head)).runs[0]
    assert both.inputs["motor.neighbour_temperature"][0] == pytest.approx(303.15)
    assert "motor.current" not in both.inputs
    assert both.unused == ("current [A]",)
    alone = read_experiment(written(tmp_path, lines, head.replace("torque [N.m]", "operator"))).runs[0]
    assert alone.inputs["motor.current"][0] == 2.0


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda lines: [*lines[:5], "40,3.43,2.5,22,23,1", *lines[5:]], "row 7, column 'time [s]'"),
        (lambda lines: [*lines[:5], "50,3.43,2.5,22,2x,1", *lines[6:]], "row 7, column 'shaft_temperature"),
        (lambda lines: lines[:1], "only 1 rows"),
        (lambda lines: [line.rsplit(",", 2)[0] + ",," for line in lines], "at least 20 are needed"),
        (lambda lines: [lines[0].replace("3.43", ""), *lines[1:]], "first row"),
        (lambda lines: [*lines[:9], ",3.43,2.5,22,23,1", *lines[10:]], "the time is missing"),
        (lambda lines: [line.replace(",22,", ",inf,") for line in lines], "is empty; give the input"),
        (lambda lines: [line.replace(",22,", ",warm,") for line in lines], "most cells below are no numbers"),
    ],
)
def test_bad_rows_are_refused_with_row_and_column(
    tmp_path: Path, change: Callable[[list[str]], list[str]], said: str
) -> None:
    with pytest.raises(InputError) as refusal:
        read_experiment(written(tmp_path, change(rows())))
    assert said in str(refusal.value)
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize(
    ("head", "said"),
    [
        (HEAD.replace("speed [rad/s]", "speed [kg]"), "does not convert"),
        (HEAD.replace("speed [rad/s]", "speed"), "has no unit"),
        (HEAD.replace("speed [rad/s]", "velocity [rad/s]"), "is not known"),
        (HEAD.replace("time [s]", "clock [s]"), "no time column"),
        (HEAD.replace("elongation [um]", "elongation [m]"), "unit in the header seems wrong"),
    ],
)
def test_bad_headers_are_refused(tmp_path: Path, head: str, said: str) -> None:
    with pytest.raises(InputError, match=said):
        read_experiment(written(tmp_path, rows(), head))


EXPERIMENT = """
system = "BenchRod"
[[run]]
data = "rod.csv"
labels = {{ surface = "shiny" }}
[channels]
"heater_on [1]" = "heater.on"
"T1 [degC]" = "link.sensor_temperature[1]"
[known]
"link.length" = "304.8 mm"
{more}
"""


def experiment(folder: Path, more: str) -> Path:
    lines = [f"{10 * i},1,{20 + 0.1 * i:g}" for i in range(30)]
    (folder / "rod.csv").write_text("time [s],heater_on [1],T1 [degC]\n" + "\n".join(lines) + "\n")
    path = folder / "rod.toml"
    path.write_text(EXPERIMENT.format(more=more))
    return path


def test_offsets_and_differences_of_temperature_are_told_apart(tmp_path: Path) -> None:
    more = '"link.ambient_offset" = "0.5 degC"\n"link.ambient_temperature" = "20 degC"\n'
    read = read_experiment(experiment(tmp_path, more + '[noise]\n"link.sensor_temperature[1]" = "0.25 degC"'))
    assert read.known["link.ambient_offset"] == 0.5
    assert read.known["link.ambient_temperature"] == pytest.approx(293.15)
    assert read.noise["link.sensor_temperature[1]"] == pytest.approx(0.25)
    assert read.known["link.length"] == pytest.approx(0.3048)


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ('"link.lenght" = "1 m"', "no variable link.lenght"),
        ('"link.width" = "1 kg"', "does not convert"),
        ('[calibrate]\n"heater.power" = { min = "9 W", max = "2 W" }', "not below max"),
        ('[calibrate]\n"heater.power" = { min = "1 W" }', "max is missing"),
        ('[calibrate]\n"heater.power" = { min = "1 W", max = "2 W", per = "colour" }', "no label 'colour'"),
        ('[causes]\nper = ["colour"]', "no label 'colour'"),
        ('[noise]\n"link.sensor_temperature[1]" = "-1 K"', "above 0"),
        ("[colours]", "colours is not known"),
    ],
)
def test_bad_experiments_are_refused(tmp_path: Path, more: str, said: str) -> None:
    with pytest.raises(InputError, match=said):
        read_experiment(experiment(tmp_path, more))


def test_endless_files_are_condensed() -> None:
    count = 1000
    time = np.arange(count) * 1.0
    pad = np.where(time < 500, 300.0, np.nan)
    readings = {"link.tip_temperature": 295 + time / 100}
    run = condensed(Run("long", time, {"motor.pad_temperature": pad}, readings), most=100)
    assert run.time.size == 100
    assert run.readings["link.tip_temperature"][0] == pytest.approx(295.045)
    assert np.isfinite(run.inputs["motor.pad_temperature"]).sum() == 50


def test_a_reading_that_only_says_again_what_the_one_before_said_is_none() -> None:
    random = np.random.default_rng(5)
    course = np.cumsum(random.normal(0, 0.3, 240))
    held = np.repeat(course[::6], 6)
    assert repeats(held).tolist() == [row for row in range(240) if row % 6]
    kept = sticking(course, 2.0)
    assert np.unique(np.delete(kept, repeats(kept))).size == np.unique(kept).size
    assert repeats(kept).size == 240 - np.count_nonzero(np.diff(kept)) - 1
    for sound in (
        course,
        np.round(course, 0),
        np.full(240, 22.0),
        np.where(np.arange(240) < 100, 22.0, course),
    ):
        assert repeats(sound).size == 0


@pytest.mark.parametrize("seed", range(5))
def test_of_a_sensor_that_sticks_only_what_follows_a_jump_is_kept(seed: int) -> None:
    random = np.random.default_rng(seed)
    course = 60e-6 * (1 - np.exp(-np.arange(500) / random.uniform(80, 200)))
    held = sticking(course, random.uniform(4e-6, 8e-6))
    noise = random.normal(0, 0.4e-6, 500)
    left_out = between_jumps(held + noise)
    jumped = np.flatnonzero(np.diff(held)) + 1
    assert np.array_equal(np.setdiff1d(np.arange(1, 500), left_out), jumped)
    spikes = np.zeros(500)
    spikes[random.integers(0, 500, 8)] = 20e-6
    loose = 20e-6 * (np.arange(500) // 60 % 2)
    rounded = np.round((course + noise) / 5e-6) * 5e-6
    for sound in (course, noise, course + noise, course + noise + spikes, noise + loose, rounded):
        assert between_jumps(sound).size == 0


def test_a_quantum_is_recognised() -> None:
    values = 20 + 5 * np.sin(np.arange(400) / 40)
    assert quantum(np.round(values, 1)) == pytest.approx(0.1)
    assert quantum(values) == 0.0


def test_a_current_and_a_torque_that_are_both_asked_for_are_refused(tmp_path: Path) -> None:
    """Both count in the motor's losses, so that its copper loss was five times as large."""
    head = HEAD.replace("\n", ",I [A]\n")
    path = written(tmp_path, [f"{line},2" for line in rows()], head)
    options = read_options(names=["I=motor.current"])
    with pytest.raises(InputError, match=r"'torque \[N\.m\]' and 'I \[A\]' would both count"):
        read_run(path, rig("WarmupCell"), options=options)


def test_a_name_may_spell_the_unit_of_its_column_otherwise(tmp_path: Path) -> None:
    """A column was left out without a word, as the file wrote degrees with their sign."""
    head = HEAD.replace("shaft_temperature [degC]", "T2 [\N{DEGREE SIGN}C]")
    assert head != HEAD
    path = written(tmp_path, rows(), head)
    run = read_run(path, rig("WarmupCell"), options=read_options(names=["T2 [degC]=shaft_temperature"]))
    assert "motor.shaft_temperature" in run.readings
    assert "T2" not in "".join(run.unused)


def test_a_unit_that_the_header_states_in_other_words_is_no_contradiction(tmp_path: Path) -> None:
    head = HEAD.replace("shaft_temperature [degC]", "shaft_temperature [\N{DEGREE SIGN}C]")
    path = written(tmp_path, rows(), head)
    run = read_run(path, rig("WarmupCell"), options=read_options(["shaft_temperature=degC"]))
    assert "motor.shaft_temperature" in run.readings
    with pytest.raises(InputError, match=r"is in .* already"):
        read_run(path, rig("WarmupCell"), options=read_options(["shaft_temperature=degF"]))


def test_a_covariate_hides_no_name_that_was_mistyped(tmp_path: Path) -> None:
    head = HEAD.replace("speed [rad/s]", "spead [rad/s]").replace("\n", ",room 2 [degC]\n")
    path = written(tmp_path, [f"{line},22" for line in rows()], head)
    with pytest.raises(InputError, match=r"'spead \[rad/s\]' \(perhaps speed\) is not known"):
        read_run(path, rig("WarmupCell"), covariates={"room 2": "neighbour.temperature"})
