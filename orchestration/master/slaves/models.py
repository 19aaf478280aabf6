"""FMUs for model exchange as slaves: equations integrated from one communication point to the next."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from ctypes import Structure, byref, c_bool, c_byte, c_double, c_int
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.master.slaves import under_way
from warmlink.orchestration.master.slaves.events import update_discrete_states
from warmlink.orchestration.master.slaves.fmi import FmiSlave
from warmlink.orchestration.master.slaves.integration import IntegrationError, Update, integrate, settled
from warmlink.orchestration.master.slaves.slave import Names, RunSpan, SlaveError
from warmlink.orchestration.master.slaves.versions import (
    Fmi1Slave,
    Fmi2Slave,
    Fmi3Slave,
    resource_path,
)

TOLERANCE = 1e-8
"""Relative, where neither the run nor the FMU names one."""


class ModelSlave(FmiSlave):
    """One instance of an FMU for model exchange, which is in event mode between two communication steps.

    So inputs of any kind may be set there, and are held during a step.
    """

    plain_step = False
    rates_named: ClassVar[str]
    """Function that gives the states' derivatives."""

    def setup(self, experiment: RunSpan) -> None:
        """Set up the experiment."""
        super().setup(experiment)
        own = self.info.default_experiment.tolerance
        self._tolerance = experiment.tolerance or own or TOLERANCE
        states = ("GetContinuousStates", "GetNominalsOfContinuousStates", self.rates_named)
        sizes = dict.fromkeys(states, self.info.continuous_states)
        sizes["GetEventIndicators"] = self.info.event_indicators
        self._filled = {name: np.zeros(size) for name, size in sizes.items()}

    def exit_initialization(self) -> None:
        """Leave initialization mode for event mode, and settle there."""
        super().exit_initialization()
        try:
            settled(self)
        except IntegrationError as fault:
            raise SlaveError(self.name, "error", self.time, str(fault)) from None

    def step(self, time: float, step_size: float) -> str | None:
        """Integrate over one communication step."""
        self.time = time
        self.note(under_way.STEPPING)
        try:
            ends = integrate(self, time, time + step_size, self._tolerance)
        except IntegrationError as fault:
            raise SlaveError(self.name, "error", time, str(fault)) from None
        finally:
            self.watch_step()
        return f"the model asks to end the simulation{self.log.tell()}" if ends else None

    def set_input_derivatives(self, names: Names, order: int, values: Sequence[float]) -> None:
        """Refuse: inputs are held during a step."""
        raise SlaveError(self.name, "error", self.time, "takes no derivatives of inputs")

    @abstractmethod
    def update(self) -> Update:
        """Do one round of an event."""

    @abstractmethod
    def completed(self) -> tuple[bool, bool]:
        """Note that a step of the solver is done; tell whether it is an event, and whether all is to end."""

    def enter_event_mode(self, event: bool) -> None:
        """Enter event mode."""
        self.ask("EnterEventMode")

    def enter_continuous_time_mode(self) -> None:
        """Enter continuous-time mode."""
        self.ask("EnterContinuousTimeMode")

    def states(self) -> Array:
        """Give the continuous states."""
        return self._numbers("GetContinuousStates").copy()

    def nominals(self) -> Array:
        """Give the nominal values of the continuous states."""
        return self._numbers("GetNominalsOfContinuousStates")

    def rates(self) -> Array:
        """Give the derivatives of the continuous states."""
        return self._numbers(self.rates_named).copy()

    def indicators(self) -> Array:
        """Give the event indicators, which the next call overwrites."""
        return self._numbers("GetEventIndicators")

    def move(self, time: float, states: Array) -> None:
        """Set time in s and continuous states."""
        self.ask("SetTime", time)
        held = self._filled["GetContinuousStates"]
        held[:] = states
        if len(held):
            self.ask("SetContinuousStates", held.ctypes.data, len(held))

    def _numbers(self, name: str) -> Array:
        """Give what a function fills an array with."""
        filled = self._filled[name]
        if len(filled):
            self.ask(name, filled.ctypes.data, len(filled))
        return filled


class _EventInfo1(Structure):
    """`fmiEventInfo` of FMI 1.0."""

    _fields_: ClassVar[Any] = [
        *((name, c_byte) for name in ("converged", "references", "states", "ends", "has_next")),
        ("next_event", c_double),
    ]


class Fmi1Model(ModelSlave, Fmi1Slave):
    """One instance of an FMI 1.0 FMU for model exchange, which has no modes: it is told of events alone."""

    rates_named = "GetDerivatives"

    def instantiate(self, name: bytes, token: bytes, resources: Path) -> int | None:
        """Instantiate; the callbacks live as long as this object."""
        return self.logging(self.function("Instantiate")(name, token, self.callbacks(), False))

    def exit_initialization(self) -> None:
        """Initialize; what is set before that is what the model initializes with."""
        self._event, self._due = _EventInfo1(), False
        self.ask("SetTime", self.time)
        self.ask("ExitInitializationMode", True, self._tolerance, byref(self._event))
        self.look_around("during initialization")

    def enter_event_mode(self, event: bool) -> None:
        """Note whether there is an event."""
        self._due = event

    def enter_continuous_time_mode(self) -> None:
        """Do nothing."""

    def update(self) -> Update:
        """Handle an event, if there is one; else what was told of the next one still holds."""
        if self._due:
            self.ask("EventUpdate", False, byref(self._event))
        told = self._event
        self._due = self._due and not told.converged
        return Update(self._due, bool(told.ends), told.next_event if told.has_next else np.inf)

    def completed(self) -> tuple[bool, bool]:
        """Note that a step of the solver is done."""
        event = c_byte()
        self.ask("CompletedIntegratorStep", byref(event))
        return bool(event.value), False


class _EventInfo(Structure):
    """`fmi2EventInfo`."""

    _fields_: ClassVar[Any] = [
        *((name, c_int) for name in ("again", "ends", "nominals", "states", "has_next")),
        ("next_event", c_double),
    ]


class Fmi2Model(ModelSlave, Fmi2Slave):
    """One instance of an FMI 2.0 FMU for model exchange."""

    rates_named = "GetDerivatives"

    def update(self) -> Update:
        """Do one round of an event."""
        info = _EventInfo()
        self.ask("NewDiscreteStates", byref(info))
        return Update(bool(info.again), bool(info.ends), info.next_event if info.has_next else np.inf)

    def completed(self) -> tuple[bool, bool]:
        """Note that a step of the solver is done."""
        event, ends = c_int(), c_int()
        self.ask("CompletedIntegratorStep", True, byref(event), byref(ends))
        return bool(event.value), bool(ends.value)


class Fmi3Model(ModelSlave, Fmi3Slave):
    """One instance of an FMI 3.0 FMU for model exchange."""

    rates_named = "GetContinuousStateDerivatives"

    def instantiate(self, name: bytes, token: bytes, resources: Path) -> int | None:
        """Instantiate; the callback lives as long as this object."""
        given = name, token, resource_path(resources), False, False, None, self.log_callback()
        found: int | None = self.function("InstantiateModelExchange")(*given)
        return found

    def update(self) -> Update:
        """Do one round of an event."""
        return update_discrete_states(self.ask)

    def completed(self) -> tuple[bool, bool]:
        """Note that a step of the solver is done."""
        event, ends = c_bool(), c_bool()
        self.ask("CompletedIntegratorStep", True, byref(event), byref(ends))
        return event.value, ends.value
