"""The table of a study's trials while it runs."""

from dataclasses import replace
from pathlib import Path

import pytest

pytest.importorskip("optuna")

from tests.formula import Formula, fmus_named, make
from warmlink.fmus.errors import InputError
from warmlink.orchestration.studies.case import Constraint
from warmlink.orchestration.studies.points import Judged, evaluate
from warmlink.orchestration.studies.session import Ledger
from warmlink.orchestration.studies.storage import Storage, default_url
from warmlink.orchestration.studies.study import load_study
from warmlink.orchestration.studies.tune import Tuned, tune


def test_the_trials_so_far_are_kept_after_each_batch(folder: Path) -> None:
    study = load_study(str(folder / "study.toml"))
    path, rows, part = folder / "trials.csv", list[int](), make(folder, "part")

    def keep(found: Tuned) -> None:
        found.write_csv(path)
        rows.append(len(path.read_text("utf-8").splitlines()) - 1)

    def go_on(workers: Formula) -> None:
        storage = Storage(study, "fmus", default_url(part))
        ledger = Ledger(part, fmus_named("fmus"), workers, print)
        tune(study, ledger, storage, lambda done, leader: None, keep=keep)

    with pytest.raises(KeyboardInterrupt):
        go_on(Formula(at_most=2 * 9 + 1))
    assert rows == [4, 8]
    # What was there before is not written as if it were all.
    go_on(Formula())
    assert rows == [4, 8, 12, 14]


def test_what_is_kept_meanwhile_says_that_its_winner_is_not_polished_yet(folder: Path) -> None:
    """It said that the system was not joined."""
    study, here, told = load_study(str(folder / "study.toml")), make(folder, "a"), list[str]()
    storage = Storage(study, "fmus", default_url(here))
    tuned = tune(
        study,
        Formula(),
        storage,
        lambda done, leader: None,
        joined=True,
        keep=lambda found: told.append(found.gain),
    )
    assert told == ["not polished yet"] * 4
    assert tuned.gain.startswith("polished along its gradient")


def test_a_figure_that_is_not_known_is_named(folder: Path) -> None:
    """The objective was called the reason, with its good value."""
    study = load_study(str(folder / "study.toml"))
    limit = Constraint("ready_wrong_percent", at_most=1.0)
    assert study.shipped is not None
    (found,) = evaluate(replace(study, constraints=(limit,)), [study.shipped], Formula())
    assert found.reason == "worst ready_wrong_percent is nan"


def test_two_constraints_on_one_metric_have_a_column_each(folder: Path) -> None:
    study = load_study(str(folder / "study.toml"))
    limits = Constraint("rms_um", at_most=5.0), Constraint("rms_um", "mean", at_most=5.0)
    study = replace(study, constraints=limits)
    assert study.shipped is not None
    trial = Judged(0, study.shipped, (4.0,), (-1.0, -2.0))
    frame = Tuned(study, [trial], Storage(study, "fmus", default_url(folder))).to_frame()
    assert frame["worst rms_um above 5"].tolist() == [-1.0]
    assert frame["mean rms_um above 5"].tolist() == [-2.0]


@pytest.mark.parametrize("trials", [0, -3, 2.5, 10**9])
def test_a_number_of_trials_is_one_that_a_study_could_say(folder: Path, trials: int) -> None:
    study = load_study(str(folder / "study.toml"))
    assert study.lasting(20).tune.trials == 20
    with pytest.raises(InputError, match=r"not a number of trials; give a whole number from 1 to 100000$"):
        study.lasting(trials)
