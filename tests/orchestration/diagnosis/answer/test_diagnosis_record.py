"""What a diagnosis says, holds and writes."""

import gc
import weakref
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tests.documented import undescribed
from tests.pages import plots
from warmlink.fmus.errors import InputError
from warmlink.orchestration.diagnosis.answer.entries import json_content
from warmlink.orchestration.diagnosis.answer.words import summary
from warmlink.orchestration.diagnosis.data.measured import Run
from warmlink.orchestration.diagnosis.diagnose import Diagnosis, diagnose_experiment, read
from warmlink.orchestration.diagnosis.practice.effects import effect_of
from warmlink.orchestration.diagnosis.practice.hide import STILL, hide, write_csv
from warmlink.orchestration.products.diagnose import Found
from warmlink.orchestration.report.diagnosis import write_diagnosis


@pytest.fixture(scope="module")
def named(tmp_path_factory: pytest.TempPathFactory) -> Diagnosis:
    path = tmp_path_factory.mktemp("named") / "run.csv"
    write_csv(hide({"radiation": effect_of("radiation").size}, seed=20, at_changes=True), path)
    return diagnose_experiment(read([path]))


def changed(named: Diagnosis, **parts: object) -> Diagnosis:
    """The same with other parts, and all else as it was worked out."""
    found = replace(named)
    vars(found).update({**vars(named), **parts})
    return found


def test_held_out_error_falls_to_the_noise(named: Diagnosis) -> None:
    gain = json_content(named)["gain"]
    assert gain["heldout"]["rmse_before"] > 3
    assert gain["heldout"]["rmse_after"] < 1.1
    compensated = gain["compensation_um"]
    assert compensated["after"] < 0.1 * compensated["before"]
    assert compensated["after_95"][0] <= compensated["after"] <= compensated["after_95"][1]
    assert compensated["observer"]["after"] < compensated["observer"]["before"]


def test_sentences_have_one_way_to_write_micrometres(named: Diagnosis) -> None:
    told = summary(named)
    assert "held-out error of elongation from" in told
    assert " µm rms" in told
    assert " um" not in told


def test_the_json_has_the_agreed_form(named: Diagnosis) -> None:
    found = json_content(named, "extended.ssv")
    assert not undescribed("diagnosis.json", found)
    assert list(found)[:4] == ["verdict", "causes", "ambiguous", "next_experiment"]
    assert {"wrong", "gain", "extended"} <= set(found)
    cause = found["causes"][0]
    assert {"name", "parameters", "evidence"} <= set(cause)
    value = cause["parameters"]["link.emissivity"]
    assert set(value) == {"value", "std", "low95", "high95", "unit"}
    assert value["low95"] < 0.6 < value["high95"]
    assert value["high95"] - value["low95"] == pytest.approx(2 * 1.96 * value["std"], rel=0.01)
    assert set(found["gain"]) == {"fit", "heldout", "runs", "compensation_um"}
    wrong = found["wrong"]["tip_temperature"]
    assert {"unit", "rmse", "noise", "bias", "whiteness_p", "when", "correlates_with"} == set(wrong)
    assert wrong["unit"] == "K"
    assert wrong["noise"] == pytest.approx(0.08, rel=0.1)


def test_a_model_that_no_observer_can_be_designed_for_is_still_reported(
    named: Diagnosis, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refused(*given: object, **named: object) -> None:
        raise InputError("no law for such a plant")

    monkeypatch.setattr("warmlink.controllers.design.gains.design_controller", refused)
    found = replace(named)
    assert found.verdict == "named"
    assert json_content(found)["gain"]["compensation_um"]["observer"] is None
    assert "With an observer" not in summary(found)


def test_the_summary_is_short_and_plain(named: Diagnosis) -> None:
    lines = summary(named).splitlines()
    assert len(lines) <= 10
    assert "radiat" in lines[1]


def test_the_answer_says_which_sensor_is_wrong(named: Diagnosis) -> None:
    best = named.assessment.best
    sensor = next(i for i in named.assessment.problem.items if i.name == "sensor_offset:tip_temperature")
    other = replace(best, items=(replace(sensor, freed=best.items[0].freed),))
    found = changed(named, assessment=replace(named.assessment, best=other))
    assert summary(found).splitlines()[1] == "Found: The reading is off by a constant (tip_temperature)."


def test_what_the_machine_may_have_done_in_a_pause_of_the_log_is_no_error(
    named: Diagnosis, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A run was `unknown`, off by 2.15 K "against 2.6 K of noise", most of which was the pause's."""
    told = " noise and what the machine may have done while the log paused"
    assert told not in summary(named)
    monkeypatch.setattr(Run, "pauses", np.array([3]))
    assert told in summary(named).splitlines()[2]
    adequate = changed(named, verdict_and_reason=("adequate", ""))
    assert summary(adequate).splitlines()[1] == f"Nothing is wrong beyond the{told}: the model is adequate."


def test_columns_that_look_like_something_else_stand_before_the_causes(named: Diagnosis) -> None:
    assert json_content(named)["doubts"] == []
    doubts = ("base_temperature and tip_temperature look swapped.",)
    lines = summary(changed(named, doubts=doubts)).splitlines()
    assert lines[3] == "Look at the data first: base_temperature and tip_temperature look swapped."
    assert lines[4].startswith("radiation: ")


def test_files_are_written_and_read_back(named: Diagnosis, tmp_path: Path) -> None:
    from warmlink.orchestration.system.ssp.parameter_values import read_ssv

    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "next_experiment.toml").write_text("of an older run")
    files = write_diagnosis(named, tmp_path / "out")
    assert {path.name for path in (tmp_path / "out").iterdir()} == {*files}
    assert set(files) == {"diagnosis.json", "extended.ssv", "report.html"}
    values = read_ssv(files["extended.ssv"])
    assert values["link.emissivity"].value == pytest.approx(0.6, abs=0.05)
    page = files["report.html"].read_text()
    assert "http-equiv" not in page
    assert "as it stands" in plots(files["report.html"])


def test_in_python_a_diagnosis_writes_all_that_the_command_writes(named: Diagnosis, tmp_path: Path) -> None:
    files = Found(named).write(tmp_path / "out")
    assert all(path == tmp_path / "out" / name and path.is_file() for name, path in files.items())
    assert set(files) == {"diagnosis.json", "extended.ssv", "extended.ssp", "report.html"}


def test_a_diagnosis_that_is_done_with_leaves_nothing_behind() -> None:
    """Cycles of references had kept some 25 MB each until Python looked for cycles, which it does seldom."""
    found = diagnose_experiment(read([pd.DataFrame(hide({}, STILL, seed=1))]))
    watched = [weakref.ref(each) for each in (found.assessment.problem, found.assessment.search)]
    gc.disable()
    try:
        del found
        assert [each() for each in watched] == [None, None]
    finally:
        gc.enable()
