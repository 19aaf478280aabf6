"""`warmlink build` where its folder takes nothing."""

from __future__ import annotations

import errno
import os
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import NoReturn

import pytest

from warmlink.orchestration.cli import main


def failing(number: int) -> Callable[..., NoReturn]:
    def fail(*arguments: object, **named: object) -> NoReturn:
        raise OSError(number, os.strerror(number))

    return fail


@pytest.mark.parametrize("kind", ["python", "native"])
@pytest.mark.parametrize(
    ("owner", "name", "number", "reason"),
    [
        (Path, "mkdir", errno.EROFS, "Read-only file system"),
        (zipfile.ZipFile, "__init__", errno.EACCES, "Permission denied"),
        (zipfile.ZipFile, "writestr", errno.ENOSPC, "No space left on device"),
    ],
)
def test_what_cannot_be_written_is_said_in_one_sentence(
    kind: str,
    owner: object,
    name: str,
    number: int,
    reason: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sys.argv", ["warmlink", "build", "--fmus", kind])
    with monkeypatch.context() as patch:
        patch.setattr(owner, name, failing(number))
        with pytest.raises(SystemExit) as stop:
            main()
    out, err = capsys.readouterr()
    assert stop.value.code == 2
    assert (out, err) == ("", f"warmlink: dist: cannot be written ({reason}); choose another --out\n")
    assert not [path for path in tmp_path.rglob("*") if path.is_file()]
