"""The table of a study's trials while it runs."""

from pathlib import Path

import pytest

from tests.formula import Formula, fmus_named, make
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
