"""How a benchmark is started from the command line."""

from __future__ import annotations

from collections.abc import Callable

import typer

from warmlink.fmus.errors import InputError
from warmlink.orchestration.cli import guarded


def start(command: Callable[..., None]) -> None:
    """Run a function as a command; bad input ends in one sentence and exit code 2."""
    guarded(lambda: typer.run(command))


def positive_share(share: float) -> float:
    """The share of the full counts asked for.

    Raises
    ------
    InputError
        If it is none.
    """
    if not 0 < share <= 1:
        raise InputError(f"--share: {share:g} is not a share; give a number above 0, at most 1")
    return share
