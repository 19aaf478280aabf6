"""What `compare`, `tune` and `sweep` share: how they end on Ctrl-C, and how they write their results."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType

from warmlink.fmus.errors import InputError
from warmlink.orchestration.console import INTERRUPTED, remark
from warmlink.orchestration.files import fresh_folder
from warmlink.orchestration.master.pacing import on_ctrl_c


@contextmanager
def interruptible() -> Iterator[None]:
    """Let Ctrl-C end the command in order, and a second Ctrl-C end the process at once.

    The worker processes end with this one.
    """

    def first(number: int, frame: FrameType | None) -> None:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
        raise KeyboardInterrupt

    try:
        with on_ctrl_c(first):
            yield
    except KeyboardInterrupt:
        remark("interrupted; finished runs are kept, and the same command continues")
        raise SystemExit(INTERRUPTED) from None


@contextmanager
def results(folder: Path) -> Iterator[Path]:
    """Yield a temporary folder to write results into; its files move to `folder` when all are written.

    Raises
    ------
    InputError
        If the results cannot be written; the sentence says that the finished runs are kept.
    """
    kept = "every finished run is kept, and the same command writes the results"
    try:
        with fresh_folder(folder) as target:
            yield target
    except OSError as fault:
        raise InputError(
            f"{folder}: the results cannot be written ({fault.strerror or fault}); make room: {kept}"
        ) from None
    except InputError as fault:
        raise InputError(f"{fault}; {kept}") from None
