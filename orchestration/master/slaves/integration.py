"""Differential equations with events, integrated over one communication step by solvers of SciPy.

These are the explicit DOP853, and the implicit Radau where that one needs many steps. (SciPy's LSODA, which
switches by itself, loses some 800 bytes at each start, as of 1.17.) What a step gives depends on its start
alone, so that it can be repeated to the last bit.

Time events are met to the last bit. A state event, where an indicator passes between positive and not
positive, is found on the solver's own interpolant by halving (FMI 2.0 and 3.0, section 3.2).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from warmlink.orchestration.arrays import Array

MOST_EVENTS = 10_000
"""In one communication step; more than that is chattering."""

MOST_ROUNDS = 1000
"""Of one event, until its discrete states agree."""

STIFF_FROM = 40
"""Steps of the explicit solver between two events, beyond which the implicit one goes on."""

_ROUNDING = 1e-12
"""Of a time, by which an event may miss the end of a step and still belong to it."""


@dataclass(frozen=True)
class Update:
    """What a round of an event gave: another is needed, the simulation is to end, time of the next in s."""

    again: bool
    ends: bool
    next_event: float = math.inf


class Integrable(Protocol):
    """A model as it is integrated; between two communication steps it is in event mode.

    It is told whether there was an event as it enters that, and does not only stand at the end of a step.
    `completed` notes that a step of the solver is done, and tells whether that is an event, and whether the
    simulation is to end.
    """

    def update(self) -> Update: ...  # noqa: D102
    def enter_event_mode(self, event: bool) -> None: ...  # noqa: D102
    def enter_continuous_time_mode(self) -> None: ...  # noqa: D102
    def states(self) -> Array: ...  # noqa: D102
    def nominals(self) -> Array: ...  # noqa: D102
    def move(self, time: float, states: Array) -> None: ...  # noqa: D102
    def rates(self) -> Array: ...  # noqa: D102
    def indicators(self) -> Array: ...  # noqa: D102
    def completed(self) -> tuple[bool, bool]: ...  # noqa: D102


class IntegrationError(Exception):
    """The end of a step was not reached; the text says why."""


def integrate(model: Integrable, time: float, end: float, tolerance: float) -> bool:
    """Take a model from one time in s to another; tell whether it asks to end the simulation there.

    It is in event mode before, with its inputs set, and after. The tolerance is relative, and absolute as a
    share of each state's nominal value. IntegrationError if the solver fails or the events do not end.
    """
    update, events = settled(model), 0
    while not update.ends and not at_end(time, end):
        model.enter_continuous_time_mode()
        until = update.next_event if at_end(end, update.next_event) else end
        time, event, ends = _without_events(model, time, until, tolerance)
        model.enter_event_mode(event or until == update.next_event)
        update, events = settled(model), events + 1
        if ends:
            return True
        if events > MOST_EVENTS:
            raise IntegrationError(f"has more than {MOST_EVENTS} events up to {time:.10g} s: it chatters")
    return update.ends


class Eventful(Protocol):
    """What has events, each of which may take several rounds."""

    def update(self) -> Update: ...  # noqa: D102


def at_end(time: float, end: float) -> bool:
    """Tell whether a time in s has reached another one, but for rounding."""
    return time >= end - _ROUNDING * abs(end)


def settled(model: Eventful) -> Update:
    """Update a model's discrete states until they agree, and give the last update."""
    for _ in range(MOST_ROUNDS):
        update = model.update()
        if update.ends or not update.again:
            return update
    raise IntegrationError(f"its discrete states do not agree in {MOST_ROUNDS} rounds of one event")


def _without_events(
    model: Integrable, time: float, until: float, tolerance: float
) -> tuple[float, bool, bool]:
    """Go on to a time in s or an event before; give the time, whether there is one, whether all is to end."""
    if until <= time:
        return time, False, False
    states = model.states()
    model.move(time, states)
    positive = model.indicators() > 0
    solver, steps = _solver(model, time, states, until, tolerance), 0
    while solver.status == "running":
        if steps == STIFF_FROM:
            solver = _solver(model, solver.t, solver.y, until, tolerance, stiff=True)
        told, steps = solver.step(), steps + 1
        if solver.status == "failed":
            raise IntegrationError(f"the solver does not get beyond {solver.t:.10g} s: {told}")
        model.move(solver.t, solver.y)
        crossed = bool(np.any((model.indicators() > 0) != positive))
        reached = _move_to_crossing(model, solver, positive) if crossed else float(solver.t)
        event, ends = model.completed()
        if crossed or event or ends:
            return reached, True, ends
    return until, False, False


def _move_to_crossing(model: Integrable, solver: Any, positive: Any) -> float:
    """Move a model to the first time in a solver's last step at which an indicator has changed sides."""
    between: Callable[[float], Array] = solver.dense_output()
    before, after = float(solver.t_old), float(solver.t)
    while before < (middle := 0.5 * (before + after)) < after:
        model.move(middle, between(middle))
        if np.any((model.indicators() > 0) != positive):
            after = middle
        else:
            before = middle
    model.move(after, between(after) if after < solver.t else solver.y)
    return after


def _solver(
    model: Integrable, time: float, states: Array, until: float, tolerance: float, stiff: bool = False
) -> Any:
    """A solver as SciPy has them; one that takes a single step if there are no states."""
    if not len(states):
        return _NoStates(time, until)
    from scipy.integrate import DOP853, Radau

    def rates(at: float, held: Array) -> Array:
        model.move(at, held)
        return model.rates()

    accuracy = {"rtol": max(tolerance, 1e-12), "atol": tolerance * np.abs(model.nominals())}
    return (Radau if stiff else DOP853)(rates, time, states, until, **accuracy)


class _NoStates:
    """Goes to the end in one step."""

    def __init__(self, time: float, until: float) -> None:
        self.t_old, self.t, self.y, self.status, self._until = time, time, np.zeros(0), "running", until

    def step(self) -> str | None:
        self.t, self.status = self._until, "finished"
        return None

    def dense_output(self) -> Callable[[float], Array]:
        return lambda _: self.y
