"""A command of warmlink, run in this process."""

from __future__ import annotations

from collections.abc import Sequence

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
