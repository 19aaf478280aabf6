"""Where trials are kept, wherever that is."""

import os
import shlex
import warnings
from pathlib import Path

import pytest

pytest.importorskip("optuna")

from optuna import get_all_study_summaries

from warmlink.fmus.errors import InputError
from warmlink.orchestration.command_line.studies import dashboard
from warmlink.orchestration.studies.points import Judged
from warmlink.orchestration.studies.storage import Storage, default_url, import_optuna, shown_place
from warmlink.orchestration.studies.study import Study, load_study

import_optuna()

TRIAL = Judged(0, {"compensator.gain": 4e-6, "compensator.time_constant": 2000.0}, (2.0,))


@pytest.fixture
def study(folder: Path) -> Study:
    return load_study(str(folder / "study.toml"))


def test_loading_optuna_leaves_the_filters_of_warnings_as_they_are() -> None:
    before = list(warnings.filters)
    import_optuna()
    assert warnings.filters == before


@pytest.mark.parametrize("name", ["a b", "a?b", "a%20b", "a#b", "a@b", "{b}", "ü;b", "a'b"])
def test_trials_lie_in_the_folder_whatever_its_name(study: Study, tmp_path: Path, name: str) -> None:
    """And the dashboard finds them with the line that is printed, in a shell."""
    home = tmp_path / name
    home.mkdir()
    kept = Storage(study, "fmus", default_url(home))
    kept.add(TRIAL)
    assert (home / "study.db").is_file()
    command, place = shlex.split(dashboard(kept.place))
    assert command == "optuna-dashboard"
    (found,) = get_all_study_summaries(place)
    assert (found.study_name, found.n_trials) == (kept.name, 1)


def test_a_place_is_shown_without_its_password() -> None:
    assert shown_place("postgresql://me:se@cret@host/trials") == "postgresql://host/trials"
    assert shown_place("sqlite:////shared/me@work/study.db") == "sqlite:////shared/me@work/study.db"
    assert shown_place("journal:////shared/a study.log") == "/shared/a study.log"


def test_the_lock_of_a_journal_leads_to_it_from_any_folder(
    study: Study, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Optuna waits forever for a lock that a kill left and that leads nowhere."""
    monkeypatch.chdir(tmp_path)
    Path("shared").mkdir()
    made: list[Path] = []
    link = os.symlink

    def noted(to: str, at: str) -> None:
        link(to, at)
        made.append(Path(at).resolve(strict=True))

    monkeypatch.setattr(os, "symlink", noted)
    Storage(study, "fmus", "journal:///shared/study.log").add(TRIAL)
    assert {*made} == {tmp_path / "shared" / "study.log"}


@pytest.mark.parametrize(
    "url", ["sqlite:////nowhere/at/all/study.db", "nonsense://host/db", "postgresql://u:secret@h/d"]
)
def test_a_storage_that_cannot_be_had_is_refused(study: Study, url: str) -> None:
    with pytest.raises(InputError, match="cannot be used") as refusal:
        Storage(study, "fmus", url)
    assert "\n" not in str(refusal.value)
    assert "secret" not in str(refusal.value)


def test_two_that_write_to_one_study_are_told_so(study: Study, folder: Path) -> None:
    one, other = (Storage(study, "fmus", f"journal:///{folder / 's.log'}") for _ in range(2))
    one.add(TRIAL)
    with pytest.raises(InputError, match="somebody else works on"):
        other.add(TRIAL)
    assert len(one.trials()) == 1
