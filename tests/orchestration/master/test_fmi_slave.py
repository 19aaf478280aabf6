"""What the slaves of all FMI versions have in common, on a library of Python functions that remembers all."""

from __future__ import annotations

from collections.abc import Callable
from ctypes import c_char_p
from pathlib import Path
from typing import Any

import pytest

from warmlink.orchestration.master.slaves import fmi
from warmlink.orchestration.master.slaves.slave import RunSpan, SlaveError
from warmlink.orchestration.master.slaves.versions import Fmi2Slave
from warmlink.orchestration.system.model import (
    Capabilities,
    ConnectorType,
    DefaultExperiment,
    FmuVariable,
    ModelInfo,
    Value,
)

WELL, WARNING, DISCARD, ERROR, FATAL = range(5)

# In FMI 2.0 each type counts its references by itself.
TYPES: dict[str, ConnectorType] = {
    "heat": "Real",
    "cold": "Real",
    "mode": "Integer",
    "on": "Boolean",
    "label": "String",
}
PLACES = {"heat": 0, "cold": 1, "mode": 0, "on": 0, "label": 0}
GIVEN: dict[str, Value] = {"label": "µ", "cold": -0.5, "on": True, "mode": 7, "heat": 2.5}
"""In an order of its own."""


def described(proposed: float | None = None) -> ModelInfo:
    variables = {
        name: FmuVariable(name, PLACES[name], kind, kind, "input", "continuous")
        for name, kind in TYPES.items()
    }
    return ModelInfo(
        *(Path("Tried.fmu"), "2.0", "Tried", "Tried", "{1}", "", variables, (), {}, Capabilities()),
        DefaultExperiment(tolerance=proposed),
        {},
    )


class Remembering:
    """A library that holds values by type and reference; `answers` are its statuses by function."""

    def __init__(self) -> None:
        self.held: dict[str, dict[int, Any]] = {kind: {} for kind in TYPES.values()}
        self.calls: list[tuple[Any, ...]] = []
        self.answers: dict[str, int] = {}
        self.closed = 0
        self.functions: dict[str, Callable[..., int]] = {
            name: self._noted(name)
            for name in (
                *("SetDebugLogging", "SetupExperiment", "EnterInitializationMode", "ExitInitializationMode"),
                *("DoStep", "Terminate", "FreeInstance", "SetFMUState", "FreeFMUState", "GetFMUState"),
                *("GetBooleanStatus", "GetRealStatus"),
            )
        }
        self.functions["Instantiate"] = lambda *given: 1
        for kind in self.held:
            self.functions |= {f"Get{kind}": self._get(kind), f"Set{kind}": self._set(kind)}

    def close(self) -> None:
        self.closed += 1

    def _noted(self, name: str) -> Callable[..., int]:
        def called(component: Any, *given: Any) -> int:
            self.calls.append((name, *given))
            return self.answers.get(name, WELL)

        return called

    def _get(self, kind: str) -> Callable[..., int]:
        def get(component: Any, references: Any, count: int, values: Any) -> int:
            values[:] = [self.held[kind].get(references[k], 0) for k in range(count)]
            return self.answers.get(f"Get{kind}", WELL)

        return get

    def _set(self, kind: str) -> Callable[..., int]:
        def set_(component: Any, references: Any, count: int, values: Any) -> int:
            self.held[kind] |= {references[k]: values[k] for k in range(count)}
            return self.answers.get(f"Set{kind}", WELL)

        return set_


@pytest.fixture
def library(monkeypatch: pytest.MonkeyPatch) -> Remembering:
    made = Remembering()
    made.held["String"][0] = b""
    monkeypatch.setattr(fmi, "Library", lambda *given: made)
    return made


def opened(proposed: float | None = None) -> Fmi2Slave:
    return Fmi2Slave("tried", described(proposed), Path())


def test_values_of_all_types_come_back_in_the_order_that_is_asked(library: Remembering) -> None:
    slave = opened()
    slave.set(tuple(GIVEN), tuple(GIVEN.values()))
    assert library.held == {
        **{"Real": {0: 2.5, 1: -0.5}, "Integer": {0: 7}, "Boolean": {0: 1}, "String": {0: "µ".encode()}}
    }
    for names in (tuple(GIVEN), tuple(reversed(GIVEN)), ("cold", "heat"), ("on",), ()):
        assert slave.get(names) == [GIVEN[name] for name in names]
    assert slave.get(("on",))[0] is True


def test_what_was_got_does_not_change_with_what_is_got_next(library: Remembering) -> None:
    slave, names = opened(), ("heat", "cold")
    slave.set(names, (1.0, 2.0))
    before = slave.get(names)
    slave.set(names, (3.0, 4.0))
    assert slave.get(names) == [3.0, 4.0]
    assert before == [1.0, 2.0]


@pytest.mark.parametrize("status", [WELL, WARNING])
def test_a_warning_is_no_failure(library: Remembering, status: int) -> None:
    library.answers = dict.fromkeys(("GetReal", "DoStep", "EnterInitializationMode"), status)
    slave = opened()
    slave.enter_initialization()
    assert slave.step(0.0, 1.0) is None
    assert slave.get(("heat",)) == [0.0]


@pytest.mark.parametrize(
    ("name", "kind"), [("heat", "Real"), ("cold", "Real"), ("mode", "Integer"), ("on", "Boolean")]
)
def test_a_refused_value_is_named_if_it_is_the_only_one_of_its_type(
    library: Remembering, name: str, kind: str
) -> None:
    """The reference alone does not tell: `heat`, `mode` and `on` have the same one."""
    library.answers = {f"Set{kind}": ERROR}
    with pytest.raises(SlaveError, match=f"fmi2Set{kind} answered error; it logged nothing") as failure:
        opened().set((name,), (GIVEN[name],))
    assert (failure.value.slave, failure.value.variable, failure.value.status) == ("tried", name, "error")


def test_of_several_refused_values_none_is_blamed(library: Remembering) -> None:
    library.answers = {"SetReal": ERROR}
    with pytest.raises(SlaveError) as failure:
        opened().set(("heat", "cold"), (1.0, 2.0))
    assert failure.value.variable is None


@pytest.mark.parametrize(
    ("status", "kind"), [(DISCARD, "discard"), (ERROR, "error"), (FATAL, "fatal"), (5, "error")]
)
def test_a_failed_step_says_when_and_what_was_logged_once(
    library: Remembering, status: int, kind: str
) -> None:
    slave = opened()
    library.answers = {"DoStep": status}
    slave.log.add(WELL, "all is well")
    slave.log.add(ERROR, b"too hot")
    with pytest.raises(SlaveError, match=f"fmi2DoStep answered {kind}; it logged: too hot$") as failure:
        slave.step(3.0, 0.5)
    assert (failure.value.status, failure.value.time) == (kind, 3.0)
    with pytest.raises(SlaveError, match="it logged nothing"):
        slave.step(3.5, 0.5)


@pytest.mark.parametrize(
    ("asked", "proposed", "told"),
    [(None, None, (False, 0.0)), (None, 1e-4, (True, 1e-4)), (1e-6, 1e-4, (True, 1e-6))],
)
def test_the_tolerance_is_that_of_the_run_else_the_one_that_the_fmu_proposes(
    library: Remembering, asked: float | None, proposed: float | None, told: tuple[bool, float]
) -> None:
    slave = opened(proposed)
    slave.setup(RunSpan(2.0, None, asked, goes_back=False))
    slave.setup(RunSpan(2.0, 9.0, asked))
    found = [call[1:] for call in library.calls if call[0] == "SetupExperiment"]
    assert found == [(*told, 2.0, False, 0.0), (*told, 2.0, True, 9.0)]
    assert slave.forward_only is False


def test_log_categories_are_asked_for_only_where_they_are_declared(library: Remembering) -> None:
    opened()
    ((_, on, count, names),) = [call for call in library.calls if call[0] == "SetDebugLogging"]
    assert (on, count) == (True, 4)
    assert isinstance(names, c_char_p * 4)
    assert b"logStatusError" in list(names)


def test_there_is_no_way_back_to_a_state_that_was_not_given(library: Remembering) -> None:
    slave = opened()
    with pytest.raises(SlaveError, match="fmi2GetFMUState gave no state, so that there is no way back"):
        slave.restore(slave.state())
    assert not [call for call in library.calls if call[0] == "SetFMUState"]


def test_it_is_ended_once(library: Remembering) -> None:
    slave = opened()
    slave.terminate()
    slave.terminate()
    ended = [call[0] for call in library.calls if call[0] in ("Terminate", "FreeInstance")]
    assert (ended, library.closed) == (["Terminate", "FreeInstance"], 1)
