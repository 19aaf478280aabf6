"""FMI 3.0 slaves that handle events outside their steps: event mode, early return, times of events."""

from __future__ import annotations

import math
from collections.abc import Callable
from ctypes import byref, c_bool, c_double

from warmlink.orchestration.master.slaves import under_way
from warmlink.orchestration.master.slaves.integration import (
    MOST_EVENTS,
    IntegrationError,
    Update,
    at_end,
    settled,
)
from warmlink.orchestration.master.slaves.slave import SlaveError
from warmlink.orchestration.master.slaves.versions import Fmi3Slave


def update_discrete_states(ask: Callable[..., None]) -> Update:
    """Do one round of an event, by a function that calls one of an instance by its name."""
    again, ends, nominals, states, has_next = (c_bool() for _ in range(5))
    at = c_double()
    flags = (byref(each) for each in (again, ends, nominals, states, has_next))
    ask("UpdateDiscreteStates", *flags, byref(at))
    return Update(again.value, ends.value, at.value if has_next.value else math.inf)


class Fmi3EventSlave(Fmi3Slave):
    """One instance of an FMI 3.0 FMU with event mode, in which it is between two communication steps.

    So inputs of any kind may be set there. A communication step is divided where the FMU returns early and at
    the times of events that it foretells (FMI 3.0 section 4.2).
    """

    plain_step = False
    event_mode = True

    def update(self) -> Update:
        """Do one round of an event."""
        return update_discrete_states(self.ask)

    def exit_initialization(self) -> None:
        """Leave initialization mode for event mode, and settle there."""
        super().exit_initialization()
        self._settle()

    def step(self, time: float, step_size: float) -> str | None:
        """Advance by one communication step."""
        self.time, end = time, time + step_size
        self.note(under_way.STEPPING)
        try:
            ends = self._step_through(time, end)
        finally:
            self.watch_step()
        self.end_variation(step_size)
        return ends

    def _step_through(self, now: float, end: float) -> str | None:
        update = self._settle()
        for _ in range(MOST_EVENTS):
            if update.ends or at_end(now, end):
                return f"the FMU asks to end the simulation{self.log.tell()}" if update.ends else None
            self.ask("EnterStepMode")
            foretold = now < update.next_event < end and self.capabilities.variable_step
            until = update.next_event if foretold else end
            now = self._part(now, until)
            self.ask("EnterEventMode")
            update = self._settle()
            if self.wants_to_end.value:
                if at_end(now, end):
                    return self.answered(0, end - now)
                told = f"fmi3DoStep asks to end the simulation{self.log.tell()}"
                raise SlaveError(self.name, "ended", now, told)
        raise SlaveError(self.name, "error", self.time, f"has more than {MOST_EVENTS} events up to {now:g} s")

    def _part(self, now: float, until: float) -> float:
        """Step towards a time in s, and give the one that was reached."""
        event, early, reached = c_bool(), c_bool(), c_double(until)
        answers = byref(event), byref(self.wants_to_end), byref(early), byref(reached)
        self.ask("DoStep", now, until - now, self.forward_only, *answers)
        return reached.value if early.value else until

    def _settle(self) -> Update:
        try:
            return settled(self)
        except IntegrationError as fault:
            raise SlaveError(self.name, "error", self.time, str(fault)) from None
