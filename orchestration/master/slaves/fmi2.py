"""An FMI 2.0 co-simulation FMU as a slave."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from ctypes import CDLL, CFUNCTYPE, Structure, byref, c_char_p, c_double, c_int, c_void_p, cast
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any, ClassVar, NoReturn

from warmlink.orchestration.master.slaves.batch import Batch
from warmlink.orchestration.master.slaves.fmi import FmiSlave, FmuLog
from warmlink.orchestration.master.slaves.library import FMI2_TYPES, SUFFIX, c_library, platform_name
from warmlink.orchestration.master.slaves.slave import Names
from warmlink.orchestration.system.description import Variable

_CO_SIMULATION = 1  # fmi2Type
_TERMINATED = 3  # fmi2StatusKind


class Fmi2Slave(FmiSlave):
    """One instance of an FMI 2.0 FMU."""

    prefix: ClassVar[str] = "fmi2"

    def instantiate(self, name: bytes, token: bytes, resources: Path) -> int | None:
        """Instantiate; the callbacks live as long as this object."""
        self._callbacks = _Callbacks.from_buffer_copy(_callbacks())
        self._callbacks.environment = self.log.key
        place = resources.absolute().as_uri().encode()
        found: int | None = self.function("Instantiate")(
            name, _CO_SIMULATION, token, place, byref(self._callbacks), False, False
        )
        return found

    def base_type(self, variable: Variable) -> tuple[str, Any] | None:
        """Give one of the four base types."""
        base = "Integer" if variable.type == "Enumeration" else variable.type
        return (base, FMI2_TYPES[base]) if base in FMI2_TYPES else None

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
            asked = self.function("GetBooleanStatus")(self.component, _TERMINATED, byref(wanted))
            if asked <= 1 and wanted.value:
                self.end("DoStep answered discard and")
        super().stop(status)


_LOG = CFUNCTYPE(None, c_void_p, c_char_p, c_int, c_char_p, c_char_p)


class _Callbacks(Structure):
    """`fmi2CallbackFunctions`."""

    _fields_ = (
        ("logger", _LOG),
        *((name, c_void_p) for name in ("allocate", "free", "step_finished", "environment")),
    )


@cache
def _callbacks() -> _Callbacks:
    """Callback functions that FMPy's proxy knows, kept alive as long as the process.

    The proxy, which formats the variadic arguments of a log call, knows one Python callback in the whole
    process and does not keep it alive. So there is one, and the environment pointer that each instance was
    given says whose line it is.
    """

    def log(environment: int | None, name: bytes, status: int, category: bytes, message: bytes) -> None:
        kept = FmuLog.open.get(environment or 0)
        if kept is None:
            print(message.decode("utf-8", "replace"), file=sys.stderr)
        else:
            kept.add(status, message)

    c = c_library()
    shared = _Callbacks(_LOG(log), cast(c.calloc, c_void_p), cast(c.free, c_void_p))
    # The package itself would take longer to import than an hour of the cell takes to run.
    package = find_spec("fmpy")
    if package is not None and package.origin is not None:
        folder = Path(package.origin).parent / "logging" / platform_name("fmi2")
        CDLL(str(folder / f"logging{SUFFIX}")).addLoggerProxy(byref(shared))
    return shared
