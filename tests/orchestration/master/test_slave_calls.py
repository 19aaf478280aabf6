"""What a slave is called with: how it is instantiated, and ended after the worst that it answered."""

from __future__ import annotations

from collections.abc import Callable
from ctypes import c_bool
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest

from warmlink.orchestration.master.slaves.versions import Fmi2Slave, Fmi3Slave

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
    """By FMI 2.0, section 2.1.3."""
    calls: list[str] = []

    def function(name: str) -> Callable[[object], None]:
        return lambda component: calls.append(name)

    slave, library = Fmi2Slave.__new__(Fmi2Slave), Library()
    vars(slave).update(
        name="x", component=1, _worst=worst, _library=library, function=function, note=lambda doing: None
    )
    slave.terminate()
    slave.terminate()
    assert (calls, library.closed) == (called, closed)


def test_a_slave_of_fmi_3_is_asked_to_update_its_scalar_real_inputs_alone() -> None:
    """Those that may vary within a step are named when it is instantiated; FMUs refuse others."""
    given: list[tuple[object, ...]] = []

    def variable(reference: int, kind: str, causality: str, elements: int = 1) -> SimpleNamespace:
        return SimpleNamespace(value_reference=reference, type=kind, causality=causality, elements=elements)

    slave = Fmi3Slave.__new__(Fmi3Slave)
    variables = [
        variable(1, "Float64", "input"),
        variable(2, "Float64", "output"),
        variable(3, "Boolean", "input"),
        variable(4, "Float64", "input", elements=3),
        variable(5, "Float64", "input"),
    ]
    vars(slave).update(
        wants_to_end=c_bool(),
        capabilities=SimpleNamespace(intermediate_update=True),
        variables={str(each.value_reference): each for each in variables},
        function=lambda name: lambda *arguments: given.append(arguments),
    )
    slave.instantiate(b"x", b"token", Path())
    ((*_, inputs, count, environment, _, updated),) = given
    assert (list(cast("Any", inputs)), count, environment) == ([1, 5], 2, None)
    assert updated is not None
