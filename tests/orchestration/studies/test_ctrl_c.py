"""Ctrl-C ends a study wherever it comes."""

import os
import signal
import threading
from dataclasses import replace
from pathlib import Path

import pytest

from warmlink.orchestration.command_line.studies import interruptible
from warmlink.orchestration.console import INTERRUPTED
from warmlink.orchestration.master.slaves import under_way
from warmlink.orchestration.studies.workers import FmuSet, attempt

from .test_workers import Counting, ledger, numbered, short

pytestmark = pytest.mark.skipif(os.name != "posix", reason="signals are POSIX")


class Forgotten:
    """Python drops whatever is raised while it lets this go, as in callbacks of weak references."""

    def __del__(self) -> None:
        os.kill(os.getpid(), signal.SIGINT)
        for _ in range(1000):
            pass


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_it_ends_a_study_where_python_drops_what_is_raised(tmp_path: Path) -> None:
    workers = Counting()
    before = signal.getsignal(signal.SIGINT)

    def study() -> None:
        for number in range(5):
            if number == 2:
                Forgotten()
            dict(ledger(tmp_path, workers).run([numbered(number)]))

    with pytest.raises(SystemExit) as end, interruptible():
        study()
    assert end.value.code == INTERRUPTED
    assert workers.ran <= 3
    assert signal.getsignal(signal.SIGINT) == before
    assert not under_way.asked()


def test_a_run_on_fmus_in_this_process_is_interrupted_and_not_stopped(folder: Path, fmus: FmuSet) -> None:
    """Else a study that tried its joined systems went on without them."""
    long = replace(short(folder), stop_time=900_000.0, step_size=1.0)
    over = threading.Event()
    rows = under_way.here.cells
    rows[under_way.ROWS] = 0

    def press() -> None:
        # Not after some time: a loaded machine may not have begun then, and what begins may drop Ctrl-C.
        while not rows[under_way.ROWS] and not over.wait(0.01):
            pass
        if not over.is_set():
            os.kill(os.getpid(), signal.SIGINT)

    finger = threading.Thread(target=press)
    finger.start()
    try:
        with pytest.raises(KeyboardInterrupt):
            attempt(long, fmus)
    finally:
        over.set()
        finger.join()
