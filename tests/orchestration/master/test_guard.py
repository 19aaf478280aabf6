"""Faults of a guarded run reach whoever asked for it, as what they are."""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest

from warmlink.fmus.errors import InputError, MissingExtraError
from warmlink.orchestration.master.guard import guarded

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="runs are guarded on Linux")


class Unportable(Exception):  # noqa: N818
    """As lxml's errors are, where a package has exceptions pickled with their causes."""

    def __reduce__(self) -> Any:
        raise TypeError("cannot be pickled")


def caused() -> None:
    try:
        raise Unportable
    except Unportable as cause:
        raise InputError("x.fmu: not well-formed; make it anew") from cause


def missing() -> None:
    raise MissingExtraError("compiled stepping", "studies")


@pytest.mark.parametrize(("work", "word"), [(caused, "make it anew"), (missing, "pip install")])
def test_bad_input_is_bad_input_on_the_other_side_too(work: Callable[[], None], word: str) -> None:
    pickling = pytest.importorskip("tblib.pickling_support")
    pickling.install(InputError)
    with pytest.raises(InputError, match=word):
        guarded(lambda line: work())  # type: ignore[arg-type,return-value,func-returns-value]


def runs(process: int) -> bool:
    """Whether a process runs; one that was killed may wait for somebody to ask how it ended."""
    with suppress(FileNotFoundError):
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    return False


def test_what_a_run_started_ends_with_it(tmp_path: Path) -> None:
    def starts_and_fails() -> None:
        started = subprocess.Popen(["sleep", "60"])
        (tmp_path / "process").write_text(str(started.pid))
        raise InputError("x.fmu: enough")

    with pytest.raises(InputError, match="enough"):
        guarded(lambda line: starts_and_fails())  # type: ignore[arg-type,return-value,func-returns-value]
    process = int((tmp_path / "process").read_text())
    give_up = time.monotonic() + 10
    while runs(process) and time.monotonic() < give_up:
        time.sleep(0.01)
    assert not runs(process)
