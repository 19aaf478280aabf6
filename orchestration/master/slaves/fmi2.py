"""An FMI 2.0 co-simulation FMU as a slave."""

from __future__ import annotations

from collections.abc import Sequence
from ctypes import byref, c_char, c_char_p, c_double, c_int
from functools import cache
from typing import Any, ClassVar, NoReturn

from warmlink.orchestration.master.slaves.batch import Batch
from warmlink.orchestration.master.slaves.fmi import FmiSlave, FmuLog
from warmlink.orchestration.master.slaves.slave import Names
from warmlink.orchestration.system.description import Variable

_BASES: dict[str, tuple[str, Any]] = {
    "Real": ("Real", c_double),
    "Integer": ("Integer", c_int),
    "Enumeration": ("Integer", c_int),
    "Boolean": ("Boolean", c_int),
    "String": ("String", c_char_p),
}
_TERMINATED = 3  # fmi2StatusKind


class Fmi2Slave(FmiSlave):
    """One instance of an FMI 2.0 FMU."""

    prefix: ClassVar[str] = "fmi2"
    library_class: ClassVar[str] = "fmi2.FMU2Slave"
    platform: ClassVar[str] = "platform"
    byte: ClassVar[Any] = c_char

    def function(self, name: str) -> Any:
        """Find a function, whose name FMI 2.0 may spell in another way."""
        spelt = name.replace("FMUState", "FMUstate").replace("Deserialize", "DeSerialize")
        return super().function(spelt)

    def instantiate(self, library: Any) -> None:
        """Instantiate; the callbacks live as long as this object."""
        shared = _callbacks()
        self._callbacks = type(shared).from_buffer_copy(shared)
        self._callbacks.componentEnvironment = self.log.key
        library.instantiate(callbacks=self._callbacks, loggingOn=False)

    def base_type(self, variable: Variable) -> tuple[str, Any] | None:
        """Give one of the four base types."""
        return _BASES.get(variable.type)

    def arguments(self, batch: Batch) -> tuple[Any, ...]:
        """Give instance, value references, their count, and values."""
        return self.component, batch.references, batch.count, batch.values

    def enter_initialization(self, start_time: float, stop_time: float | None) -> None:
        """Set up the experiment and enter initialization mode."""
        self.time = start_time
        times = start_time, int(stop_time is not None), stop_time or 0.0
        self.call("SetupExperiment", self.component, 0, 0.0, *times)
        self.call("EnterInitializationMode", self.component)

    def set_input_derivatives(self, names: Names, order: int, values: Sequence[float]) -> None:
        """Set time derivatives of Real inputs for the next step."""
        count = len(names)
        orders, numbers = (c_int * count)(*[order] * count), (c_double * count)(*values)
        self.call("SetRealInputDerivatives", self.component, self.references(names), count, orders, numbers)

    def stop(self, status: int) -> NoReturn:
        """Raise for what a step answered; it discards, too, where it wants to end."""
        wanted = c_int(0)
        if status == 2:
            asked = self.functions.fmi2GetBooleanStatus(self.component, _TERMINATED, byref(wanted))
            if asked <= 1 and wanted.value:
                self.end("DoStep answered discard and")
        super().stop(status)


@cache
def _callbacks() -> Any:
    """Callback functions that FMPy's proxy knows, kept alive as long as the process.

    The proxy, which formats the variadic arguments of a log call, knows one Python callback in the whole
    process and does not keep it alive. So there is one, and the environment pointer that each instance was
    given says whose line it is.
    """
    from fmpy import calloc, fmi2, free
    from fmpy.logging import addLoggerProxy

    def log(environment: int | None, name: bytes, status: int, category: bytes, message: bytes) -> None:
        kept = FmuLog.open.get(environment or 0)
        if kept is None:
            fmi2.printLogMessage(environment, name, status, category, message)
        else:
            kept.add(status, message)

    shared = fmi2.fmi2CallbackFunctions()
    shared.logger = fmi2.fmi2CallbackLoggerTYPE(log)
    shared.allocateMemory = fmi2.fmi2CallbackAllocateMemoryTYPE(calloc)
    shared.freeMemory = fmi2.fmi2CallbackFreeMemoryTYPE(free)
    addLoggerProxy(byref(shared))
    return shared
