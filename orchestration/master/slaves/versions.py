"""Co-simulation FMUs of FMI 1.0, 2.0 and 3.0 as slaves.

FMI 3.0 has no input derivatives: where a slave offers intermediate update, its inputs are set anew
whenever it asks during a step, along the polynomial that the master gave.
"""

from __future__ import annotations

import ctypes
import math
import os
import sys
from collections.abc import Sequence
from ctypes import byref, c_bool, c_char_p, c_double, c_int, c_uint, c_void_p
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any, ClassVar

from warmlink.fmus.safe_text import printable
from warmlink.orchestration.master.slaves.fmi import FmiSlave
from warmlink.orchestration.master.slaves.fmu_log import FmuLog
from warmlink.orchestration.master.slaves.library import SUFFIX, Callbacks1, platform_name
from warmlink.orchestration.master.slaves.slave import Names, RunSpan, SlaveError, Status
from warmlink.orchestration.master.slaves.surroundings import c_library
from warmlink.orchestration.system.model import Value

_INTERFACES = ("ModelExchange", "CoSimulation")  # fmi2Type
_LAST_SUCCESSFUL_TIME, _TERMINATED = 2, 3  # fmi2StatusKind
_ROUNDING = 1e-6  # of a step, by which the end of one may be missed


class Fmi1Slave(FmiSlave):
    """One instance of an FMU of FMI 1.0, which has no initialization mode and no state to copy.

    What is set before `exit_initialization` is what it initializes with.
    """

    prefix = "fmi1"
    plain_step = False

    def instantiate(self, name: bytes, token: bytes, resources: Path) -> int | None:
        """Instantiate; the callbacks live as long as this object."""
        place, kind = resources.parent.absolute().as_uri().encode(), b"application/x-fmu-sharedlibrary"
        given = name, token, place, kind, 0.0, False, False, self.callbacks(), False
        return self.logging(self.function("Instantiate")(*given))

    def callbacks(self) -> Callbacks1:
        """Give the functions that the FMU may call, which live as long as this object."""
        self._negated: dict[Names, list[int]] = {}
        self._callbacks = _callbacks(self.log.key)
        return Callbacks1.from_buffer_copy(self._callbacks)

    def logging(self, component: int | None) -> int | None:
        """Give the instance's address, which its lines of the log bear."""
        if component:
            FmuLog.open[component] = self.log
        return component

    def ask_for_log(self) -> None:
        """Ask for nothing: FMI 1.0 has no categories, and what a slave logs unasked is on failures."""

    def setup(self, experiment: RunSpan) -> None:
        """Set up the experiment; the slave gets it on leaving initialization mode."""
        self.time, stop = experiment.start_time, experiment.stop_time
        self._experiment = experiment.start_time, stop is not None, stop or 0.0
        self.forward_only = True  # the step before is accepted: there is no way back

    def enter_initialization(self) -> None:
        """Do nothing."""

    def exit_initialization(self) -> None:
        """Initialize."""
        self.call("ExitInitializationMode", *self._experiment)
        self.look_around("during initialization")

    def get(self, names: Names) -> list[Value]:
        """Give the values of variables."""
        values = super().get(names)
        for position in self._turned_round(names):
            values[position] = -values[position]  # type: ignore[operator]
        return values

    def set(self, names: Names, values: Sequence[Value]) -> None:
        """Set variables."""
        turned = self._turned_round(names)
        given = [-v if i in turned else v for i, v in enumerate(values)] if turned else values  # type: ignore[operator]
        super().set(names, given)

    def _turned_round(self, names: Names) -> list[int]:
        """Give the places of those that are exchanged as another variable's value times -1."""
        if names not in self._negated:
            found = [
                i for i, name in enumerate(names) if name in self.variables and self.variables[name].negated
            ]
            self._negated[names] = found
        return self._negated[names]

    def set_input_derivatives(self, names: Names, order: int, values: Sequence[float]) -> None:
        """Refuse: nothing says that the slave takes any."""
        raise SlaveError(self.name, "error", self.time, "takes no derivatives of inputs")


class Fmi2Slave(FmiSlave):
    """One instance of an FMI 2.0 FMU."""

    prefix = "fmi2"

    def instantiate(self, name: bytes, token: bytes, resources: Path) -> int | None:
        """Instantiate; the callbacks live as long as this object."""
        self._callbacks = _callbacks(self.log.key)
        place = resources.absolute().as_uri().encode()
        kind = _INTERFACES.index(self.info.interface)
        given = name, kind, token, place, byref(self._callbacks), False, False
        found: int | None = self.function("Instantiate")(*given)
        return found

    def set_input_derivatives(self, names: Names, order: int, values: Sequence[float]) -> None:
        """Set time derivatives of Real inputs for the next step."""
        count = len(names)
        orders, numbers = (c_int * count)(*[order] * count), (c_double * count)(*values)
        self.call("SetRealInputDerivatives", self.references(names), count, orders, numbers)

    def answered(self, status: int, step_size: float) -> str:
        """Judge an answer; an FMU of FMI 2.0 that wants to end discards the step, whether done or not."""
        wanted, reached = c_int(0), c_double(math.nan)
        if status == 2:
            asked = self.function("GetBooleanStatus")(self.component, _TERMINATED, byref(wanted))
            if asked <= 1 and wanted.value:
                said = f"fmi2DoStep answered discard and asks to end the simulation{self.log.tell()}"
                # A Python FMU of pythonfmu answers so whatever goes wrong with its step.
                self.function("GetRealStatus")(self.component, _LAST_SUCCESSFUL_TIME, byref(reached))
                if not abs(reached.value - self.time - step_size) <= _ROUNDING * step_size:
                    kind: Status = "terminated" if self.log.complains else "ended"
                    raise SlaveError(self.name, kind, self.time, said)
                return said
        return super().answered(status, step_size)


_LOG = ctypes.CFUNCTYPE(None, c_void_p, c_char_p, c_int, c_char_p, c_char_p)


@_LOG
def _log(environment: int | None, name: bytes, status: int, category: bytes, message: bytes) -> None:
    kept = FmuLog.open.get(environment or 0)
    if kept is None:
        print(printable(message.decode("utf-8", "replace")), file=sys.stderr)
    else:
        kept.add(status, message)


def _callbacks(environment: int) -> ctypes.Array[c_void_p]:
    """`fmi2CallbackFunctions` that FMPy's proxy knows, for an instance with such an environment.

    The proxy, which formats the variadic arguments of a log call, knows one Python callback in the whole
    process, the last one that it was told. So ours is one for all, and the environment pointer that each
    instance was given says whose line it is.
    """
    c, proxy = c_library(), _proxy()
    logger, allocate, free = (ctypes.cast(each, c_void_p) for each in (_log, c.calloc, c.free))
    found = (c_void_p * 5)(logger, allocate, free, None, environment)
    if proxy is not None:
        proxy.addLoggerProxy(byref(found))
    return found


@cache
def _proxy() -> Any:
    """FMPy's library for this; None without FMPy, or if it has none for this platform, as on ARM."""
    # The package itself would take longer to import than an hour of the cell takes to run.
    origin = getattr(find_spec("fmpy"), "origin", None)
    folder = Path(origin or "").parent / "logging" / platform_name("fmi2")
    return ctypes.CDLL(str(folder / f"logging{SUFFIX}")) if origin and folder.is_dir() else None


_LOG3 = ctypes.CFUNCTYPE(None, c_void_p, c_int, c_char_p, c_char_p)
_FLAG, _TIME = ctypes.POINTER(c_bool), ctypes.POINTER(c_double)
_UPDATE = ctypes.CFUNCTYPE(None, c_void_p, c_double, c_bool, c_bool, c_bool, c_bool, _FLAG, _TIME)


def resource_path(resources: Path) -> bytes:
    """Give the folder of an FMU's resources as FMI 3.0 writes it."""
    return f"{resources.absolute()}{os.sep}".encode()


class Fmi3Slave(FmiSlave):
    """One instance of an FMI 3.0 FMU, which handles events inside its steps unless it has `event_mode`."""

    prefix = "fmi3"
    event_mode: ClassVar[bool] = False

    def instantiate(self, name: bytes, token: bytes, resources: Path) -> int | None:
        """Instantiate; the callbacks live as long as this object."""
        self.answers = byref(c_bool()), byref(self.wants_to_end), byref(c_bool()), byref(c_double())
        updates = self.capabilities.intermediate_update
        numbers = (v for v in self.variables.values() if v.type == "Float64" and v.elements == 1)
        inputs = [v.value_reference for v in numbers if updates and v.causality == "input"]
        self._updated = _UPDATE(self._update) if updates else None
        events = self.event_mode
        given = name, token, resource_path(resources), False, False, events, events
        asked = (c_uint * len(inputs))(*inputs), len(inputs), None, self.log_callback(), self._updated
        found: int | None = self.function("InstantiateCoSimulation")(*given, *asked)
        return found

    def log_callback(self) -> Any:
        """Give the function that the FMU logs by, which lives as long as this object."""
        self._varying: dict[int, list[float]] = {}
        structural = (v.name for v in self.variables.values() if v.causality == "structuralParameter")
        self._structural = frozenset(structural)
        self._log = _LOG3(lambda environment, status, category, message: self.log.add(status, message))
        return self._log

    def set(self, names: Names, values: Sequence[Value]) -> None:
        """Set variables; derivatives that were set for them are dropped."""
        if self._structural and not self._structural.isdisjoint(names):
            names, values = self._configured(names, values)
        super().set(names, values)
        if self._varying:
            for name in names:
                self._varying.pop(self.variables[name].value_reference, None)

    def _configured(self, names: Names, values: Sequence[Value]) -> tuple[Names, list[Value]]:
        """Set structural parameters in configuration mode, and give the other variables and their values."""
        given = dict(zip(names, values, strict=True))
        chosen = {name: given.pop(name) for name in names if name in self._structural}
        self.ask("EnterConfigurationMode")
        super().set(tuple(chosen), list(chosen.values()))
        self.ask("ExitConfigurationMode")
        for elements in filter(None, self.info.arrays.values()):  # whose start values fitted other sizes
            first = self.variables[elements[0]]
            if first.start is None and first.settable:
                self._held[first.value_reference][:] = self.get(elements)
        return tuple(given), list(given.values())

    def set_input_derivatives(self, names: Names, order: int, values: Sequence[float]) -> None:
        """Let inputs vary in the next step, as far as the slave asks for them; elements of arrays do not."""
        for name, value, start in zip(names, values, self.get(names), strict=True):
            if self.variables[name].elements == 1:
                reference = self.variables[name].value_reference
                self._varying.setdefault(reference, [float(start), 0.0, 0.0])[order] = value

    def restore(self, state: object) -> None:
        """Return to a copied state."""
        self._varying.clear()
        super().restore(state)

    def step(self, time: float, step_size: float) -> str | None:
        """Advance by one communication step."""
        ends = super().step(time, step_size)
        self.end_variation(step_size)
        return ends

    def end_variation(self, elapsed: float) -> None:
        """Set the varying inputs to their values at the end of a step, after which they vary no more."""
        if self._varying:
            status = self._vary(elapsed)
            self._varying.clear()
            if status > 1:
                self.fail("SetFloat64", status)

    def _update(self, _: Any, time: float, set_requested: bool, *more: Any) -> None:
        """Set the inputs of an intermediate time; called by the slave within its step."""
        more[3][0] = False  # no early return
        if set_requested and self._varying:
            self._vary(time - self.time)

    def _vary(self, elapsed: float) -> int:
        """Set the varying inputs to their values some time after the start of the step."""
        count = len(self._varying)
        numbers = (u + elapsed * (d + 0.5 * elapsed * c) for u, d, c in self._varying.values())
        values, references = (c_double * count)(*numbers), (c_uint * count)(*self._varying)
        return int(self.function("SetFloat64")(self.component, references, count, values, count))
