"""A command of warmlink, run in this process."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pytest

from warmlink.orchestration.cli import main


def exit_code(arguments: Sequence[str], monkeypatch: pytest.MonkeyPatch) -> int:
    """Run `warmlink ARGUMENTS`; what it prints is captured by whoever captures."""
    monkeypatch.setattr("sys.argv", ["warmlink", *arguments])
    try:
        main()
    except SystemExit as stop:
        return int(stop.code or 0)
    return 0


def refused(
    arguments: Sequence[str], capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> str:
    """What `warmlink ARGUMENTS` says of bad input: one sentence, exit code 2, and no file is written."""
    before = sorted(Path().rglob("*"))
    assert exit_code(arguments, monkeypatch) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("warmlink: ")
    assert err.count("\n") == 1, err
    assert sorted(Path().rglob("*")) == before
    return err
