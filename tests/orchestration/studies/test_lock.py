from pathlib import Path

import pytest

from warmlink.fmus.errors import InputError
from warmlink.orchestration.files import LOCK, locked_folder

fcntl = pytest.importorskip("fcntl")


def test_a_folder_has_one_writer_and_goes_again_when_nothing_came_of_it(tmp_path: Path) -> None:
    folder = tmp_path / "a" / "b"
    with locked_folder(folder):
        said = f"{folder}: another warmlink is at work there; wait for it, or choose another --out"
        with pytest.raises(InputError, match=said), locked_folder(folder):
            pass
        assert (folder / LOCK).exists()
    assert not (tmp_path / "a").exists()
    with locked_folder(folder):
        (folder / "kept").touch()
    assert [path.name for path in folder.iterdir()] == ["kept"]


def test_a_lock_that_its_owner_removed_meanwhile_is_none(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    really, opened = fcntl.flock, []

    def flock(stream: object, how: int) -> None:
        really(stream, how)
        if not opened:  # the one before ends between our opening of the file and our lock on it
            (tmp_path / LOCK).unlink()
        opened.append(stream)

    monkeypatch.setattr(fcntl, "flock", flock)
    with locked_folder(tmp_path), pytest.raises(InputError, match="at work there"), locked_folder(tmp_path):
        pass
    assert len(opened) == 2


def test_a_folder_that_cannot_be_made_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match="cannot be written"), locked_folder(tmp_path / "file" / "folder"):
        pass
