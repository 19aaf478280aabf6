import math
import operator
import sqlite3
import warnings
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

pytest.importorskip("optuna")

from tests.documented import undescribed
from tests.formula import Formula, fmus_named, make
from tests.pages import plots
from warmlink.fmus.errors import InputError
from warmlink.orchestration.report.studies import write_tuning
from warmlink.orchestration.studies.case import Constraint, Gathered
from warmlink.orchestration.studies.points import Judged, best, front
from warmlink.orchestration.studies.session import Ledger
from warmlink.orchestration.studies.storage import JOURNAL, Storage, default_url, import_optuna
from warmlink.orchestration.studies.study import Study, load_study
from warmlink.orchestration.studies.tune import Tuned, tune
from warmlink.orchestration.studies.winner import polish, write_winner
from warmlink.orchestration.studies.workers import Workers
from warmlink.orchestration.system.ssp.parameter_values import read_ssv

import_optuna()


def journal(folder: Path) -> str:
    """Storage in a folder that takes a tenth of the time that a database does."""
    return f"{JOURNAL}{folder / 'study.log'}"


def run(
    study: Study, folder: Path, workers: Workers, storage: Callable[[Path], str] = journal
) -> list[Judged]:
    ledger = Ledger(folder, fmus_named("fmus"), workers, print)
    return tune(study, ledger, Storage(study, "fmus", storage(folder)), lambda done, leader: None).trials


@pytest.fixture
def study(folder: Path) -> Study:
    return load_study(str(folder / "study.toml"))


def same(one: list[Judged], other: list[Judged]) -> bool:
    return repr(one) == repr(other)


def test_the_same_study_gives_the_same_table_in_whatever_order_its_runs_end(
    study: Study, folder: Path
) -> None:
    one = run(study, make(folder, "a"), Formula())
    other = run(study, make(folder, "b"), Formula(backwards=True))
    assert same(one, other)
    assert [trial.number for trial in one] == list(range(14))
    another = run(replace(study, seed=4), make(folder, "c"), Formula())
    assert not same(one, another)


def test_tuning_finds_the_least_and_does_better_than_chance(study: Study, folder: Path) -> None:
    study = replace(study, constraints=(), tune=replace(study.tune, trials=40))
    tuned = best(run(study, make(folder, "tpe"), Formula()))
    random = replace(study, tune=replace(study.tune, sampler="random"))
    drawn = best(run(random, make(folder, "random"), Formula()))
    assert tuned is not None
    assert drawn is not None
    assert tuned.objective < min(1.05, drawn.objective)


def test_the_first_trial_is_what_ships(study: Study, folder: Path) -> None:
    first = run(study, make(folder, "a"), Formula())[0]
    assert dict(first.point) == {"compensator.gain": 4.21e-6, "compensator.time_constant": 2440.0}


def test_the_trials_before_anything_is_learnt_are_spread_over_the_bounds(study: Study, folder: Path) -> None:
    study = replace(study, tune=replace(study.tune, trials=16))
    for seed in range(3):
        trials = run(replace(study, seed=seed), make(folder, str(seed)), Formula())[1:]
        for axis in study.axes:
            low, high = (math.log(bound) if axis.log else bound for bound in (axis.low, axis.high))
            values = [trial.point[axis.name] for trial in trials]
            shares = [((math.log(v) if axis.log else v) - low) / (high - low) for v in values]
            assert sorted(int(15 * share) for share in shares) == list(range(15))


def test_constraints_hold_for_the_winner_and_are_learnt(study: Study, folder: Path) -> None:
    # The least lies at a gain of 5, which moves at 0.05; allowed are 0.04.
    bound = replace(study.constraints[0], at_most=0.04)
    study = replace(study, constraints=(bound,), tune=replace(study.tune, trials=48))
    trials = run(study, make(folder, "a"), Formula())
    winner = best(trials)
    assert winner is not None
    assert 3.5e-6 < winner.point["compensator.gain"] <= 4e-6
    free = run(replace(study, constraints=()), make(folder, "b"), Formula())
    kept, ignored = (
        sum(trial.point["compensator.gain"] <= 4e-6 for trial in trials[24:]) for trials in (trials, free)
    )
    assert kept > 2 * ignored


def test_where_no_trial_keeps_every_constraint_the_nearest_is_named(study: Study, folder: Path) -> None:
    """Each constraint counts by the share of its bound that is missed."""
    limits = Constraint("max_abs_um", at_most=0.5), Constraint("correction_rate_um_s", at_most=1e-3)
    strict = replace(study, constraints=limits)
    trials = run(strict, folder, Formula())
    close = min(trials, key=lambda each: max(each.excess[0] / 0.5, each.excess[1] / 1e-3))
    told = Tuned(strict, trials, Storage(strict, "fmus", journal(folder))).reached
    assert told[0] == "no trial keeps every constraint"
    assert told[1].startswith(f"nearest is trial {close.number}: worst max_abs_um ")
    assert f"{close.excess[0]:.4g} above 0.5; worst correction_rate_um_s" in told[1]


@pytest.mark.parametrize(
    ("at_most", "backwards", "storage"),
    [(3, False, journal), (3, True, journal), (17, False, journal), (17, True, default_url)],
)
def test_an_interrupted_study_ends_like_one_that_was_not(
    study: Study, folder: Path, at_most: int, backwards: bool, storage: Callable[[Path], str]
) -> None:
    whole = run(study, make(folder, "whole"), Formula())
    part = make(folder, "part")
    with pytest.raises(KeyboardInterrupt):
        run(study, part, Formula(backwards=backwards, at_most=at_most), storage)
    rest = Formula()
    assert same(run(study, part, rest, storage), whole)
    # Whatever had ended was not run again.
    assert rest.done == 2 * 14 - at_most
    again = Formula()
    assert same(run(study, part, again, storage), whole)
    assert again.done == 0


def test_more_trials_go_on_from_those_there_are(study: Study, folder: Path) -> None:
    more = replace(study, tune=replace(study.tune, trials=22))
    part = make(folder, "part")
    run(study, part, Formula())
    assert same(run(more, part, Formula()), run(more, make(folder, "whole"), Formula()))


def test_the_storage_alone_is_enough_to_go_on(study: Study, folder: Path) -> None:
    part = make(folder, "part")
    whole = run(study, part, Formula(), default_url)
    (part / "runs.jsonl").unlink()
    again = Formula()
    assert same(run(study, part, again, default_url), whole)
    assert again.done == 0


def test_a_poisoned_trial_is_recorded_with_its_reason(study: Study, folder: Path) -> None:
    trials = run(study, make(folder, "a"), Formula(poison=3.5))
    poisoned = [trial for trial in trials if trial.reason is not None]
    assert 0 < len(poisoned) < 14
    assert {trial.point["compensator.gain"] < 3.5e-6 for trial in poisoned} == {True}
    assert all("work, nominal: the slave said no" in str(trial.reason) for trial in poisoned)
    assert all(math.isnan(trial.objective) and not trial.feasible for trial in poisoned)
    again = run(study, folder / "a", Formula(poison=3.5))
    assert same(again, trials)


def test_a_point_that_a_component_refuses_is_poisoned_before_it_runs(folder: Path) -> None:
    text = (folder / "study.toml").read_text()
    text = text.replace(
        '"compensator.gain" =', '"link.tip_position" = { min = "25 cm", max = "40 cm" }\n"compensator.gain" ='
    )
    (folder / "study.toml").write_text(text)
    trials = run(load_study(str(folder / "study.toml")), make(folder, "a"), Formula())
    beyond = [trial for trial in trials if trial.point["link.tip_position"] > 0.3302]
    assert beyond
    assert all("lies beyond the link's end" in str(trial.reason) for trial in beyond)


def test_a_study_without_an_objective_is_refused_before_a_trial(study: Study, folder: Path) -> None:
    with pytest.raises(InputError, match="no objective as shipped: work, nominal: the slave said no"):
        run(study, make(folder, "a"), Formula(poison=9.0))
    assert Storage(study, "fmus", journal(folder / "a")).trials() == []


def test_another_study_in_the_same_storage_is_kept_apart(study: Study, folder: Path) -> None:
    here = make(folder, "a")
    first = run(study, here, Formula())
    other = run(replace(study, seed=8), here, Formula())
    assert not same(first, other)
    assert same(run(study, here, Formula()), first)


def test_foreign_trials_in_a_study_are_refused(study: Study, folder: Path) -> None:
    here = make(folder, "a")
    trials = run(study, here, Formula(), default_url)
    with sqlite3.connect(here / "study.db") as database:
        database.execute("UPDATE trial_params SET param_value = param_value * 1.01")
    assert trials
    with pytest.raises(InputError, match="was not chosen by this study"):
        run(study, here, Formula(), default_url)


def test_a_locked_storage_is_refused(study: Study, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("warmlink.orchestration.studies.storage.LOCK_TIMEOUT_S", 0.1)
    Storage(study, "fmus", default_url(make(folder, "a")))
    other = sqlite3.connect(folder / "a" / "study.db")
    other.execute("BEGIN EXCLUSIVE")
    try:
        with pytest.raises(InputError, match="database is locked") as refusal:
            Storage(study, "fmus", default_url(folder / "a"))
    finally:
        other.close()
    assert "\n" not in str(refusal.value)


def test_the_winner_is_a_parameter_set_with_units(study: Study, tmp_path: Path) -> None:
    point = {"compensator.gain": 5e-6, "compensator.time_constant": 3000.0}
    (path,) = write_winner(study, point, tmp_path)
    values = read_ssv(path)
    assert path.name == "winner.ssv"
    assert {name: (held.value, str(held.unit and held.unit.name)) for name, held in values.items()} == {
        "gain": (5e-6, "m/W"),
        "time_constant": (3000.0, "s"),
    }


def test_the_report_shows_winner_importance_and_coordinates(study: Study, folder: Path) -> None:
    here = make(folder, "a")
    trials = run(study, here, Formula(poison=2.5))
    winner = best(trials)
    write_tuning(Tuned(study, trials, Storage(study, "fmus", journal(here)), winner), here / "report.html")
    text, drawn = (here / "report.html").read_text(), plots(here / "report.html")
    for shown in ("winner, polished", "number of the trial [1]", "worst max_abs_um [", "share [1]"):
        assert shown in drawn
    for heading in ("Winner", "What matters", "Parallel coordinates", "Trials"):
        assert f"<h2>{heading}</h2>" in text
    assert "parcoords" in drawn
    assert "among the best tenth by worst max_abs_um, as shares of 1" in text


def test_writing_a_report_leaves_words_and_warnings_as_they_are(
    study: Study, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    two = replace(study, objectives=(study.objective, Gathered("correction_rate_um_s")), constraints=())
    here = make(folder, "a")
    trials = run(two, here, Formula())
    told = "polished, and mean RMS 3 µm/W"
    monkeypatch.setattr(Tuned, "gain", told)
    with warnings.catch_warnings(record=True) as seen:
        warnings.simplefilter("always")
        during = list(warnings.filters)
        write_tuning(
            Tuned(two, trials, Storage(two, "fmus", journal(here)), best(trials)), here / "report.html"
        )
        assert warnings.filters == during
    assert not [each for each in seen if "PedAnova" in str(each.message)]
    assert "Polished, and mean RMS 3 µm/W." in (here / "report.html").read_text("utf-8")


def test_two_objectives_give_a_front_and_a_winner_between_its_ends(study: Study, folder: Path) -> None:
    # The error is least at a gain of 5 µm/W, the rate of the correction grows with the gain.
    two = replace(study, objectives=(study.objective, Gathered("correction_rate_um_s")), constraints=())
    here = make(folder, "two")
    trials = run(two, here, Formula())
    kept = front(trials)
    for trial in trials:
        assert any(all(map(operator.le, each.objectives, trial.objectives)) for each in kept)
    winner = best(trials)
    assert winner in kept[1:-1]
    assert same(trials, run(two, here, Formula(at_most=0)))
    tuned = Tuned(two, trials, Storage(two, "fmus", journal(here)))
    write_tuning(tuned, here / "report.html")
    assert "Front" in (here / "report.html").read_text("utf-8")
    frame = tuned.to_frame()
    assert frame["in_front"].sum() == len(kept)
    assert not undescribed("trials.csv", dict.fromkeys(frame))
    assert winner is not None
    tuned = replace(tuned, polished=(polished := polish(two, winner, Formula())))
    assert polished.objectives[1] <= winner.objectives[1]
    for of, now, was in zip(two.objectives, polished.objectives, trials[0].objectives, strict=True):
        told = f"{of.title}: {now:.4g} in trial {winner.number}, amid the front, {was:.4g} as shipped"
        assert told in tuned.summary()
    was, now = winner.objectives[1], polished.objectives[1]
    assert tuned.gain.endswith(f" % less, and worst correction_rate_um_s {now:.4g}, before {was:.4g}")


def test_polishing_goes_down_the_gradient_to_the_least_and_keeps_constraints(study: Study) -> None:
    start = Judged(3, {"compensator.gain": 4e-6, "compensator.time_constant": 2000.0}, (2.2,))
    free = replace(study, constraints=())
    assert polish(free, start, Formula()).objective == pytest.approx(1.0, abs=1e-3)
    bound = replace(study, constraints=(Constraint("correction_rate_um_s", at_most=0.045),))
    found = polish(bound, start, Formula())
    assert found.feasible
    assert found.objective == pytest.approx(1.25, abs=1e-2)


def test_what_polishing_gives_a_winner_that_cannot_get_better_is_nothing(study: Study, folder: Path) -> None:
    """A winner that is within the tolerance from the start ended `tune` with a ZeroDivisionError."""
    winner = Judged(0, {}, (0.0,))
    found = Tuned(study, [winner], Storage(study, "fmus", journal(folder)), winner)
    assert found.gain == "polished along its gradient from 0, 0 % less"


def test_a_journal_survives_a_kill_within_a_line_and_counts_no_trial_twice(
    study: Study, folder: Path
) -> None:
    def go(name: str, out: str, runs: int | None = None) -> list[Judged]:
        storage = Storage(study, "fmus", f"journal:///{folder / name}")
        here = folder / out
        here.mkdir(exist_ok=True)
        workers = Ledger(here, fmus_named("fmus"), Formula(at_most=runs), print)
        return tune(study, workers, storage, lambda done, leader: None).trials

    whole = go("whole.log", "a")
    with pytest.raises(KeyboardInterrupt):
        go("cut.log", "b", 13)
    with (folder / "cut.log").open("ab") as stream:
        stream.write(b'{"op_code": 4, "worker')
    assert same(go("cut.log", "b"), whole)
    assert len(Storage(study, "fmus", f"journal:///{folder / 'cut.log'}").trials()) == len(whole)
