"""An FMI 2.0 co-simulation FMU as a slave."""

from __future__ import annotations

from collections.abc import Sequence
from ctypes import byref, c_double, c_int
from pathlib import Path
from typing import Any, ClassVar

from warmlink.orchestration.master.slaves import under_way
from warmlink.orchestration.master.slaves.batch import Batch
from warmlink.orchestration.master.slaves.fmi import FmiSlave
from warmlink.orchestration.master.slaves.fmu_log import fmi2_callbacks
from warmlink.orchestration.master.slaves.library import FMI2_TYPES
from warmlink.orchestration.master.slaves.slave import Names
from warmlink.orchestration.system.description import Variable

_CO_SIMULATION = 1  # fmi2Type
_TERMINATED = 3  # fmi2StatusKind


class Fmi2Slave(FmiSlave):
    """One instance of an FMI 2.0 FMU."""

    prefix: ClassVar[str] = "fmi2"

    def instantiate(self, name: bytes, token: bytes, resources: Path) -> int | None:
        """Instantiate; the callbacks live as long as this object."""
        self._callbacks = fmi2_callbacks(self.log)
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
        stop = 0.0 if stop_time is None else stop_time
        self.call("SetupExperiment", self.component, 0, 0.0, start_time, int(stop_time is not None), stop)
        self.call("EnterInitializationMode", self.component)

    def set_input_derivatives(self, names: Names, order: int, values: Sequence[float]) -> None:
        """Set time derivatives of Real inputs for the next step."""
        count = len(names)
        orders, numbers = (c_int * count)(*[order] * count), (c_double * count)(*values)
        self.call("SetRealInputDerivatives", self.component, self.references(names), count, orders, numbers)

    def step(self, time: float, step_size: float) -> None:
        """Advance by one communication step."""
        self.time = time
        self._under_way[under_way.CALL] = self.stepping
        status = self.functions["DoStep"](self.component, time, step_size, 0)
        if status > 1:
            if status == 2 and self._wants_to_end():
                self.end("DoStep answered discard and")
            self.fail("DoStep", status)
        if self.watched:
            self.look_around()

    def _wants_to_end(self) -> bool:
        wanted = c_int(0)
        status = self.functions["GetBooleanStatus"](self.component, _TERMINATED, byref(wanted))
        return bool(status <= 1 and wanted.value)
