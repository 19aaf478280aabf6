"""From a run with heat that the model lacks to its equation, to a set, to a cause, or to none."""

from __future__ import annotations

import json
import zipfile
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from warmlink.orchestration.diagnosis.answer.diagnosis import Diagnosis
from warmlink.orchestration.diagnosis.answer.ladder import table_of
from warmlink.orchestration.diagnosis.answer.next_experiment import Proposed
from warmlink.orchestration.diagnosis.data.experiment import read_experiment
from warmlink.orchestration.diagnosis.diagnose import diagnose_experiment
from warmlink.orchestration.diagnosis.practice.hidden_terms import hidden_term
from warmlink.orchestration.diagnosis.practice.hide import hide, write_csv
from warmlink.orchestration.diagnosis.terms import library, search
from warmlink.orchestration.diagnosis.terms.discovery import discover
from warmlink.orchestration.diagnosis.terms.entries import content_with
from warmlink.orchestration.diagnosis.terms.equation import Equation, discovered, is_due
from warmlink.orchestration.diagnosis.terms.missing import Missing
from warmlink.orchestration.diagnosis.terms.words import equation_of, sentences, summary_with
from warmlink.orchestration.fmu_store import FmuStore
from warmlink.orchestration.machine.heat_paths import rig_in
from warmlink.orchestration.machine.rig import rig
from warmlink.orchestration.report.diagnosis import write_diagnosis
from warmlink.orchestration.scenarios.duties.duty import Segment
from warmlink.orchestration.system.assemble import read_system

DUTY = [
    Segment(600.0, speed, torque)
    for speed, torque in (
        (0, 0),
        (3.0, 1.0),
        (1.0, 3.0),
        (4.5, 0.5),
        (2.0, 2.0),
        (0.0, 3.0),
        (3.5, 1.5),
        (1.5, 0),
    )
]
SOME = (
    "proportional to speed",
    "speed to the power 1.5",
    "speed to the power 2",
    "proportional to torque",
    "speed above a dead zone",
    "memory of speed",
)


def diagnosed(folder: Path, *terms: str, **effects: float) -> Diagnosis:
    """A diagnosis without the shipped causes, unless effects are hidden, so that it is quick."""
    columns = hide(effects, DUTY, interval=20.0, terms=[hidden_term(each) for each in terms], seed=5)
    write_csv(columns, folder / "run.csv")
    experiment = read_experiment(folder / "run.csv")
    return diagnose_experiment(experiment if effects else replace(experiment, with_shipped=False))


@pytest.fixture(scope="module")
def few_forms() -> object:
    """A library of some forms, for speed."""
    patch = pytest.MonkeyPatch()
    patch.setattr(library, "FORMS", tuple(form for form in library.FORMS if form.about in SOME))
    patch.setattr(search, "_FULL", (9, 2, 1))
    yield patch
    patch.undo()


@pytest.fixture(scope="module")
def found(few_forms: object, tmp_path_factory: pytest.TempPathFactory) -> Equation:
    return discovered(diagnosed(tmp_path_factory.mktemp("run"), "shaft: 2 * lag(speed, 900)"))


def test_the_equation_is_found_with_its_numbers(found: Equation) -> None:
    assert found.diagnosis.verdict == "unknown"
    assert found.discovery.finding == "equation"
    ((candidate, values),) = [found.discovery.best.model.of(1)]
    assert candidate.key == ("memory of speed", "shaft")
    for name, true in (("a", 2.0), ("tau", 900.0)):
        value, deviation = values[name]
        assert abs(value - true) < 3 * deviation
        assert deviation < 0.1 * true


def test_what_is_missing_is_heat_at_the_shaft(found: Equation) -> None:
    heat = found.discovery.missing[0]
    assert heat.place == "shaft"
    assert len({each.place for each in found.discovery.missing}) == 4
    moving = (heat.time > 2000) & (heat.time < 3000)
    true = 2 * 2.5  # about the mean of the speed by then, in W
    assert np.all(heat.heat[moving] > 0)
    assert abs(heat.heat[moving].mean() - true) < 2.5
    assert np.all(heat.deviation > 0)


def test_it_predicts_rows_that_were_not_fitted(found: Equation) -> None:
    before, after = found.held_out["elongation"]
    assert after < 0.1 * before
    (foretold,) = found.discovery.foretold
    assert foretold.held_out is not None
    assert foretold.held_out.in_noise < 1.3


def test_it_is_the_model_to_use_and_foresees_other_duty_cycles(found: Equation) -> None:
    diagnosis = found.diagnosis
    assert found.extends
    headings, rows = table_of(diagnosis)
    assert "with equation *" in headings
    assert rows
    (continuous,) = [each for each in diagnosis.claims if each.duty == "continuous"]
    assert continuous.change > 5e-6, "2 W per rad/s warm the link"
    assert continuous.widest < 0.1 * continuous.largest
    assert "no equation" in diagnosis.unanswered["observer"]


@pytest.mark.parametrize(
    ("verdict", "asked", "due"),
    [
        ("unknown", None, True),
        ("empirical", None, True),
        ("named", None, False),
        ("named", True, True),
        ("unknown", False, False),
    ],
)
def test_an_equation_is_sought_where_no_cause_is_established(
    verdict: str, asked: bool | None, due: bool
) -> None:
    experiment = SimpleNamespace(rig=rig("WarmupCell"))
    diagnosis: Any = SimpleNamespace(verdict=verdict, slips=(), experiment=experiment)
    assert is_due(diagnosis, asked) == due
    diagnosis.slips = ("torque is reversed",)
    assert is_due(diagnosis, None) is False


def test_it_is_said_with_units_and_intervals(found: Equation) -> None:
    told = summary_with(found.diagnosis, found)
    assert told.splitlines()[0].endswith("; an equation explains it")
    assert "heat into the shaft = a * lag(speed / w, tau), with a = 2" in told
    assert "W (95 %: " in told
    assert "w = 1 rad/s" in told
    entry = content_with(found.diagnosis, found)["equation"]
    json.dumps(entry, allow_nan=False)
    assert entry["finding"] == "equation"
    assert entry["members"][0]["terms"][0]["parameters"]["a"]["unit"] == "W"
    assert "equation" not in content_with(found.diagnosis, None)


def test_what_explains_a_run_as_well_as_its_cause_is_said_with_the_verdict(
    found: Equation, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It stood behind all that is said of the cause, so that the first lines said `named` alone."""
    diagnosis = Diagnosis(found.diagnosis.experiment, found.diagnosis.assessment)
    vars(diagnosis)["verdict_and_reason"] = ("named", "")
    by_causes = "run: named\nFound: a cause.\nTo use from now on: the model with the causes."
    monkeypatch.setattr("warmlink.orchestration.diagnosis.terms.words.summary", lambda *_: by_causes)
    both = Equation(diagnosis, replace(found.discovery, finding="ambiguous", causes=("coulomb_friction",)))
    vars(both)["proposed"] = Proposed((), "a duty cycle tells them apart.", 9.0, 1.0)
    title, cause, apart, *rest = summary_with(diagnosis, both).splitlines()
    assert title.endswith("named; equations explain it as well")
    assert cause == "Found: a cause."
    assert apart == "These data cannot tell 2 explanations apart:"
    assert "  or the cause coulomb_friction or backlash_heat" in rest
    assert [each for each in rest if each.startswith("Next: ")] == rest[-1:]


def test_no_hint_by_fewer_forms_stands_beside_a_search(found: Equation) -> None:
    """It named another form than the best that was tried, and the missing heat a second time."""
    experiment = replace(found.diagnosis.experiment, with_shipped=True)
    diagnosis = Diagnosis(experiment, found.diagnosis.assessment)
    vars(diagnosis)["proposed"] = None
    none = Equation(diagnosis, replace(found.discovery, finding="none", because="none explains it"))
    hints = ("A hint only", "To make up for what is wrong, heat into the shaft")
    assert all(each in summary_with(diagnosis, None) for each in hints)
    told = summary_with(diagnosis, none)
    assert "Missing heat, if all of it enters one place" in told
    assert not any(each in told for each in hints)


def test_the_extended_system_has_it_as_a_component(found: Equation, tmp_path: Path) -> None:
    files = write_diagnosis(found.diagnosis, tmp_path / "out", FmuStore("native"), found)
    system = read_system(files["extended.ssp"])
    values = found.discovery.best.model.values
    assert system.components["term1"].values["a"] == pytest.approx(values["term1.a"][0])
    extended = rig_in(system)
    assert not extended.in_loop
    assert "term1.lagged[1]" in extended.component.x.names
    with zipfile.ZipFile(system.components["term1"].fmu) as fmu:
        page = fmu.read("documentation/index.html").decode()
    assert "heat = a * lag(speed / w, tau)" in page
    assert f"{values['term1.tau'][0]:.6g} s" in page
    report = files["report.html"].read_text("utf-8")
    assert "An equation for the missing heat" in report
    assert "Missing heat at the shaft" in report


@pytest.mark.slow
def test_what_the_data_cannot_tell_apart_is_one_set_with_an_experiment(
    few_forms: object, tmp_path: Path
) -> None:
    """One speed alone: any power of it is the same heat."""
    duty = [Segment(900.0), Segment(1800.0, 3.0), Segment(1800.0), Segment(900.0, 3.0)]
    hidden = [hidden_term("shaft: 3 * (speed / 3)**1.5")]
    write_csv(hide({}, duty, interval=20.0, terms=hidden, seed=6), tmp_path / "run.csv")
    diagnosis = diagnose_experiment(replace(read_experiment(tmp_path / "run.csv"), with_shipped=False))
    found = discovered(diagnosis)
    assert found.discovery.finding == "ambiguous"
    names = {each.model.of(1)[0].form.about for each in found.discovery.members}
    assert {"speed to the power 1.5", "proportional to speed", "speed to the power 2"} <= names
    assert found.proposed is not None
    assert len({each.speed for each in found.proposed.duty}) > 2
    assert found.proposed.expected_chance is not None
    assert found.proposed.expected_chance > 0.9
    assert "cannot tell" in summary_with(diagnosis, found)


def test_a_cause_in_disguise_gets_its_name(few_forms: object, tmp_path: Path) -> None:
    found = discovered(diagnosed(tmp_path, "shaft: 1.5 * speed"))
    assert found.discovery.finding == "catalogue"
    assert "coulomb_friction" in found.discovery.because
    assert found.discovery.tried is not None
    told = equation_of(found.discovery.tried.model)
    assert told.endswith(", which is coulomb_friction or backlash_heat of the catalogue")
    assert not found.extends


@pytest.mark.slow
def test_what_no_term_explains_earns_no_equation(few_forms: object, tmp_path: Path) -> None:
    """Heat that comes and goes with nothing that is logged."""
    term = "shaft: 6 * step(time - 1500) * step(2600 - time) + 4 * step(time - 3000)"
    found = discovered(diagnosed(tmp_path, term))
    assert found.discovery.finding == "none"
    told = summary_with(found.diagnosis, found)
    assert "No equation earns its place" in told
    assert "The best that was tried: heat into the" in told
    assert not found.extends


def test_nothing_is_looked_for_where_nothing_is_wrong(few_forms: object, tmp_path: Path) -> None:
    found = discovered(diagnosed(tmp_path))
    assert found.discovery.finding == "none"
    assert found.discovery.because == "nothing is wrong beyond the noise"
    told = summary_with(found.diagnosis, found).splitlines()
    assert "No equation" not in told[1], "the verdict's own sentence comes first where nothing is unknown"
    assert "No equation" in told[-1]


def test_a_loop_of_unknown_fmus_is_told_so(found: Equation) -> None:
    diagnosis = found.diagnosis
    looped = replace(diagnosis.experiment, rig=replace(diagnosis.experiment.rig, looped=True))
    said = discover(diagnosis.assessment, "unknown", looped, diagnosis.scores, None)
    assert said.finding == "none"
    assert "in a loop" in said.because
    assert "[term.NAME]" in said.because
    told = sentences(Equation(diagnosis, said))
    assert told[0].startswith("No equation was looked for: FMUs of this machine")


def test_what_readings_answer_is_what_a_small_heat_does(found: Equation) -> None:
    """The linear answer to a term, against the simulation with it."""
    model = found.discovery.best.model
    missing = Missing(found.diagnosis.assessment)
    candidate = model.refitted().candidates[0]
    column = missing.columns([candidate])[:, 0]
    gain = column @ missing.residual / (column @ column)
    assert gain == pytest.approx(model.values["term1.a"][0], rel=0.03)
