"""How a slave is ended after the worst that it answered (FMI 2.0 section 2.1.3)."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from warmlink.orchestration.master.slaves.versions import Fmi2Slave

WELL, DISCARD, ERROR, FATAL = 0, 2, 3, 4


class Library:
    closed = 0

    def close(self) -> None:
        self.closed += 1


@pytest.mark.parametrize(
    ("worst", "called", "closed"),
    [
        (WELL, ["Terminate", "FreeInstance"], 1),
        (DISCARD, ["Terminate", "FreeInstance"], 1),
        (ERROR, ["FreeInstance"], 1),
        (FATAL, [], 0),
    ],
)
def test_after_an_error_it_is_freed_alone_and_after_a_fatal_one_let_be(
    worst: int, called: list[str], closed: int
) -> None:
    calls: list[str] = []

    def function(name: str) -> Callable[[object], None]:
        return lambda component: calls.append(name)

    slave, library = Fmi2Slave.__new__(Fmi2Slave), Library()
    vars(slave).update(
        name="x", component=1, _worst=worst, _library=library, function=function, _note=lambda doing: None
    )
    slave.terminate()
    slave.terminate()
    assert (calls, library.closed) == (called, closed)
