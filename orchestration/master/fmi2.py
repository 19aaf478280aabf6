"""An FMI 2.0 co-simulation FMU as a slave.

FMPy loads the library and declares its functions; they are then called directly, with argument arrays
that are made once for each set of variables.
"""

from __future__ import annotations

from collections.abc import Sequence
from ctypes import byref, c_char, c_char_p, c_double, c_int, c_size_t, c_uint, c_void_p, create_string_buffer
from pathlib import Path
from typing import Any

from warmlink.fmus.errors import InputError
from warmlink.orchestration.master.journal import Journal, fmi2_callbacks
from warmlink.orchestration.master.slave import Names, SlaveError, Status
from warmlink.orchestration.system.description import ModelInfo
from warmlink.orchestration.system.model import Value

_STATUS: dict[int, Status] = {2: "discard", 3: "error", 4: "fatal"}
_FUNCTIONS = {
    "Real": "Real",
    "Integer": "Integer",
    "Enumeration": "Integer",
    "Boolean": "Boolean",
    "String": "String",
}
_TERMINATED = 3  # fmi2StatusKind
_CATEGORIES = (b"logStatusWarning", b"logStatusDiscard", b"logStatusError", b"logStatusFatal")


class Batch:
    """Variables of one base type among a set of variables, with the arrays a call needs."""

    def __init__(self, base: str, positions: list[int], references: list[int]) -> None:
        self.base = base
        self.positions = positions
        self.count = len(positions)
        self.references = (c_uint * self.count)(*references)
        types: dict[str, Any] = {"Real": c_double, "Integer": c_int, "Boolean": c_int, "String": c_char_p}
        self.values: Any = (types[base] * self.count)()

    def load(self, values: Sequence[Value]) -> None:
        """Fill the array from the values of the whole set."""
        if self.base == "Real":
            self.values[:] = [values[p] for p in self.positions]
        elif self.base == "String":
            self.values[:] = [str(values[p]).encode() for p in self.positions]
        else:
            self.values[:] = [int(values[p]) for p in self.positions]

    def unload(self) -> list[Value]:
        """Give the array's values as Python values."""
        if self.base == "Boolean":
            return [bool(value) for value in self.values]
        if self.base == "String":
            return [(value or b"").decode("utf-8", "replace") for value in self.values]
        return list(self.values)


class Fmi2Slave:
    """One instance of an FMI 2.0 FMU.

    Parameters
    ----------
    name : str
        Instance name, as the system names the component.
    info : ModelInfo
        The FMU's description.
    folder : Path
        Where the FMU was unpacked.
    accepts_nan : frozenset of str
        Variables for which NaN is a proper value.

    Raises
    ------
    InputError
        Where the FMU has no library for this platform, or one that lacks functions of FMI 2.0.
    SlaveError
        Where it does not instantiate.
    """

    def __init__(
        self, name: str, info: ModelInfo, folder: Path, accepts_nan: frozenset[str] = frozenset()
    ) -> None:
        self.name = name
        self.info = info
        self.variables = info.variables
        self.capabilities = info.capabilities
        self.dependencies = {output: info.feedthrough(output) for output in info.outputs}
        self.accepts_nan = accepts_nan
        self._journal = Journal()
        self._batches: dict[Names, list[Batch]] = {}
        self._time = 0.0
        self._worst = 0
        self.component: c_void_p | None = None
        self._library = load_library(name, info, folder)
        self._callbacks = fmi2_callbacks(self._journal)
        try:
            self._library.instantiate(callbacks=self._callbacks, loggingOn=False)
        except Exception as error:
            raise SlaveError(
                name, "error", 0.0, f"fmi2Instantiate gave no instance{self._journal.tell()}"
            ) from error
        self.functions = self._library.dll
        self.component = c_void_p(self._library.component)
        # Not all logging, which may be much: what the standard's categories say of failures.
        self.functions.fmi2SetDebugLogging(
            self.component, 1, len(_CATEGORIES), (c_char_p * len(_CATEGORIES))(*_CATEGORIES)
        )

    def enter_initialization(self, start_time: float, stop_time: float | None) -> None:
        """Set up the experiment and enter initialization mode."""
        self._time = start_time
        stop = 0.0 if stop_time is None else stop_time
        self._call(
            "fmi2SetupExperiment", self.component, 0, 0.0, start_time, int(stop_time is not None), stop
        )
        self._call("fmi2EnterInitializationMode", self.component)

    def exit_initialization(self) -> None:
        """Leave initialization mode."""
        self._call("fmi2ExitInitializationMode", self.component)

    def get(self, names: Names) -> list[Value]:
        """Give the values of variables."""
        batches = self._batches.get(names) or self._prepare(names)
        for batch in batches:
            status = getattr(self.functions, "fmi2Get" + batch.base)(
                self.component, batch.references, batch.count, batch.values
            )
            if status > 1:
                self._fail("fmi2Get" + batch.base, status, batch)
        if len(batches) == 1:
            return batches[0].unload()
        values: list[Value] = [0.0] * len(names)
        for batch in batches:
            for position, value in zip(batch.positions, batch.unload(), strict=True):
                values[position] = value
        return values

    def set(self, names: Names, values: Sequence[Value]) -> None:
        """Set variables."""
        for batch in self._batches.get(names) or self._prepare(names):
            batch.load(values)
            status = getattr(self.functions, "fmi2Set" + batch.base)(
                self.component, batch.references, batch.count, batch.values
            )
            if status > 1:
                self._fail("fmi2Set" + batch.base, status, batch)

    def set_input_derivatives(self, names: Names, order: int, values: Sequence[float]) -> None:
        """Set time derivatives of Real inputs for the next step."""
        count = len(names)
        self._call(
            "fmi2SetRealInputDerivatives",
            self.component,
            self._references(names),
            count,
            (c_int * count)(*[order] * count),
            (c_double * count)(*values),
        )

    def get_output_derivatives(self, names: Names, order: int) -> list[float]:
        """Give time derivatives of Real outputs."""
        count = len(names)
        values = (c_double * count)()
        orders = (c_int * count)(*[order] * count)
        self._call(
            "fmi2GetRealOutputDerivatives", self.component, self._references(names), count, orders, values
        )
        return values[:]

    def step(self, time: float, step_size: float) -> None:
        """Advance by one communication step."""
        self._time = time
        status = self.functions.fmi2DoStep(self.component, time, step_size, 0)
        if status > 1:
            if status == 2 and self._wants_to_end():
                message = f"fmi2DoStep answered discard and asks to end the simulation{self._journal.tell()}"
                raise SlaveError(self.name, "terminated", time, message)
            self._fail("fmi2DoStep", status)

    def state(self) -> object:
        """Copy the complete state."""
        state = c_void_p()
        self._call("fmi2GetFMUstate", self.component, byref(state))
        return state

    def restore(self, state: object) -> None:
        """Return to a copied state."""
        self._call("fmi2SetFMUstate", self.component, state)

    def free(self, state: object) -> None:
        """Release a copied state."""
        self._call("fmi2FreeFMUstate", self.component, byref(state))  # type: ignore[arg-type]

    def serialize(self) -> bytes:
        """Give the present state as bytes."""
        state, size = self.state(), c_size_t()
        self._call("fmi2SerializedFMUstateSize", self.component, state, byref(size))
        data = create_string_buffer(size.value)
        self._call("fmi2SerializeFMUstate", self.component, state, data, size)
        self.free(state)
        return data.raw

    def deserialize(self, data: bytes) -> None:
        """Take a serialised state."""
        state = c_void_p()
        buffer = (c_char * len(data)).from_buffer_copy(data)
        self._call("fmi2DeSerializeFMUstate", self.component, buffer, len(data), byref(state))
        self.restore(state)
        self.free(state)

    def terminate(self) -> None:
        """End the simulation, free the instance and unload the library."""
        if self._library is None:
            return
        library, self._library = self._library, None
        if self.component is not None:
            # After error only freeing is allowed, after fatal nothing at all (FMI 2.0, section 2.1.3).
            if self._worst < 3:
                self.functions.fmi2Terminate(self.component)
            if self._worst < 4:
                self.functions.fmi2FreeInstance(self.component)
                library.freeLibrary()
        self._journal.close()

    def _prepare(self, names: Names) -> list[Batch]:
        found: dict[str, tuple[list[int], list[int]]] = {}
        for position, name in enumerate(names):
            variable = self.variables.get(name)
            if variable is None:
                raise InputError(f"{self.name}.{name}: the FMU has no such variable; correct the name")
            base = _FUNCTIONS.get(variable.type)
            if base is None:
                raise InputError(f"{self.name}.{name}: a {variable.type} cannot be exchanged")
            positions, references = found.setdefault(base, ([], []))
            positions.append(position)
            references.append(variable.value_reference)
        batches = [Batch(base, *lists) for base, lists in found.items()]
        self._batches[names] = batches
        return batches

    def _references(self, names: Names) -> Any:
        return (c_uint * len(names))(*(self.variables[name].value_reference for name in names))

    def _call(self, function: str, *arguments: Any) -> None:
        status = getattr(self.functions, function)(*arguments)
        if status > 1:
            self._fail(function, status)

    def _fail(self, function: str, status: int, batch: Batch | None = None) -> None:
        self._worst = max(self._worst, status)
        kind = _STATUS.get(status, "error")
        variable = None
        if batch is not None and batch.count == 1:
            reference = batch.references[0]
            variable = next(v.name for v in self.variables.values() if v.value_reference == reference)
        message = f"{function} answered {kind}{self._journal.tell()}"
        self._journal.clear()
        raise SlaveError(self.name, kind, self._time, message, variable)

    def _wants_to_end(self) -> bool:
        wanted = c_int(0)
        status = self.functions.fmi2GetBooleanStatus(self.component, _TERMINATED, byref(wanted))
        return bool(status <= 1 and wanted.value)


def load_library(name: str, info: ModelInfo, folder: Path) -> Any:
    """Load an FMU's library through FMPy.

    Returns
    -------
    fmpy.fmi2.FMU2Slave

    Raises
    ------
    InputError
        Where there is none for this platform, or it does not load.
    """
    from fmpy import platform
    from fmpy.fmi2 import FMU2Slave

    if not (folder / "binaries" / platform).is_dir():
        offered = sorted(p.name for p in (folder / "binaries").glob("*")) or ["none"]
        raise InputError(
            f"{name}: {info.path.name} holds no library for {platform} (it has: {', '.join(offered)}); "
            "export it for this platform"
        )
    try:
        return FMU2Slave(
            instanceName=name,
            guid=info.guid,
            modelIdentifier=info.model_identifier,
            unzipDirectory=str(folder),
        )
    except Exception as error:
        raise InputError(f"{name}: the library of {info.path.name} does not load: {error}") from error
