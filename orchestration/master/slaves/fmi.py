"""What the slaves of all FMI versions have in common.

The library's functions are called with argument arrays that are made once for each set of variables.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from ctypes import byref, c_bool, c_char, c_char_p, c_double, c_size_t, c_uint, c_void_p
from pathlib import Path
from typing import Any, ClassVar, NoReturn

from warmlink.orchestration.master.slaves import under_way
from warmlink.orchestration.master.slaves.fmu_log import FmuLog
from warmlink.orchestration.master.slaves.library import (
    Batch,
    Library,
    held_from_start,
    sorted_by_type,
)
from warmlink.orchestration.master.slaves.slave import Names, RunSpan, SlaveError, Status
from warmlink.orchestration.master.slaves.surroundings import Surroundings
from warmlink.orchestration.system.description import ModelInfo
from warmlink.orchestration.system.model import FmuVariable, Value

_ONE, _LITTLE = 1.0, 2.0**-80
"""Their sum and difference are equal where numbers are rounded to the nearest, and nowhere else."""

_FAILURES: dict[int, Status] = {2: "discard", 3: "error", 4: "fatal"}
_INITIALIZING = ("SetupExperiment", "EnterInitializationMode", "ExitInitializationMode")
# Not all logging, which may be much: what the standard's categories say of failures.
_CATEGORIES = (b"logStatusWarning", b"logStatusDiscard", b"logStatusError", b"logStatusFatal")


class FmiSlave(ABC):
    """One instance of an FMU, which was unpacked into a folder; `component` is its address.

    InputError where the FMU has no library for this platform, or one that lacks functions of its FMI version;
    SlaveError where it does not instantiate.

    A step tells its `answers` beside its status, among them whether the FMU `wants_to_end`, and is told
    whether time goes `forward_only`; `stepping` is what `under_way` calls a step of it. The process is
    `watched` after the first step, and after each further one as long as they change what FMUs share.
    """

    prefix: ClassVar[str]
    plain_step: ClassVar[bool] = True
    """Whether one call of DoStep is all that a step takes, so that compiled code can make it."""

    def __init__(self, name: str, info: ModelInfo, folder: Path) -> None:
        self.name = name
        self.info = info
        self.variables: Mapping[str, FmuVariable] = info.variables
        self.capabilities = info.capabilities
        self.dependencies: Mapping[str, frozenset[str]] = {o: info.feedthrough(o) for o in info.outputs}
        self.accepts_nan = info.accepts_nan
        self.time = 0.0
        self.log = FmuLog()
        self._sorted: dict[Names, list[Batch]] = {}
        self._held = held_from_start(info.variables) if info.arrays else {}
        self._worst = 0
        self._number = 16 * under_way.here.register(name)
        self._under_way = under_way.here.cells
        self._exchanging = self._number + under_way.EXCHANGING
        self.stepping = self._number + under_way.STEPPING
        self.remarks: list[str] = []
        self.watched = True
        self.wants_to_end = c_bool()
        self.forward_only = False
        self._experiment: tuple[Any, ...] = ()
        self.answers: tuple[Any, ...] = ()
        self._surroundings = Surroundings()
        self.note(under_way.LOADING)
        library = Library(name, info, folder, self.prefix)
        self._library: Library | None = library
        self._functions = library.functions
        self.component = c_void_p(self.instantiate(name.encode(), info.guid.encode(), folder / "resources"))
        if not self.component:
            raise SlaveError(name, "error", 0.0, f"it does not instantiate{self.log.tell()}")
        self._do_step: Any = self._functions.get("DoStep")  # which a model has not
        self.ask_for_log()
        self.look_around("when it was loaded")

    @abstractmethod
    def instantiate(self, name: bytes, token: bytes, resources: Path) -> int | None:
        """Instantiate with logging into the log, and give the instance's address."""

    def ask_for_log(self) -> None:
        """Ask for lines on failures."""
        # An FMU may refuse all further calls after one for a category that it does not declare.
        declared = self.info.log_categories
        asked = [each for each in _CATEGORIES if not declared or each.decode() in declared]
        if asked:
            count = len(asked)
            self.function("SetDebugLogging")(self.component, True, count, (c_char_p * count)(*asked))

    @abstractmethod
    def set_input_derivatives(self, names: Names, order: int, values: Sequence[float]) -> None:
        """Set time derivatives of Real inputs for the next step."""

    def function(self, name: str) -> Any:
        """Find one of the FMU's functions by its name, as FMI 3.0 spells it, without the prefix."""
        return self._functions[name]

    def call(self, name: str, *arguments: Any) -> None:
        """Call a function that takes the instance first; raise unless it answers ok or warning."""
        self.note(under_way.INITIALIZING if name in _INITIALIZING else under_way.COPYING)
        self.ask(name, *arguments)

    def ask(self, name: str, *arguments: Any) -> None:
        """Call a function that takes the instance first, within a call that is noted; raise as `call`."""
        status = self._functions[name](self.component, *arguments)
        if status > 1:
            self.fail(name, status)

    def look_around(self, when: str) -> bool:
        """Put back what the FMU changed for others; tell whether there was anything."""
        changed = self._surroundings.put_back()
        if changed:
            self._told(when, " and ".join(changed))
        return bool(changed)

    def turned(self) -> None:
        """Note that in a compiled step the FMU changed how all calculate, which was put back there."""
        self._told("in a step", "how numbers are rounded or faults of arithmetic end the process")

    def _told(self, when: str, changed: str) -> None:
        told = f"{self.name}: {when} it changed {changed}, which others share; put back"
        if told not in self.remarks:
            self.remarks.append(told)

    def note(self, call: int) -> None:
        """Note what the FMU is called for."""
        self._under_way[under_way.CALL] = self._number + call

    def fail(self, name: str, status: int, variable: str | None = None) -> NoReturn:
        """Raise for a bad status, with what the FMU logged."""
        self._worst = max(self._worst, status)
        kind = _FAILURES.get(status, "error")
        message = f"{self.prefix}{name} answered {kind}{self.log.tell()}"
        self.log.lines.clear()
        raise SlaveError(self.name, kind, self.time, message, variable)

    def step(self, time: float, step_size: float) -> str | None:
        """Advance by one communication step."""
        self.time = time
        self._under_way[under_way.CALL] = self.stepping
        status = self._do_step(self.component, time, step_size, self.forward_only, *self.answers)
        ends = self.answered(status, step_size) if status > 1 or self.wants_to_end.value else None
        self.watch_step()
        return ends

    def watch_step(self) -> None:
        """Put back what a step changed for others; once none did, only how all calculate is looked at."""
        if self.watched:
            self.watched = self.look_around("in a step")
        elif self._surroundings.calculates_otherwise():
            self.look_around("in a step")

    def answered(self, status: int, step_size: float) -> str:
        """Give the sentence of a slave that has stepped and asks to end there; raise for any other answer."""
        if status > 1:
            self.fail("DoStep", status)
        return f"{self.prefix}DoStep asks to end the simulation{self.log.tell()}"

    def setup(self, experiment: RunSpan) -> None:
        """Set up the experiment; FMI 3.0 is told of it on entering initialization mode."""
        self.time, stop = experiment.start_time, experiment.stop_time
        self.forward_only = not experiment.goes_back
        own = self.info.default_experiment.tolerance
        tolerance = own if experiment.tolerance is None else experiment.tolerance
        given = tolerance is not None, tolerance or 0.0, experiment.start_time, stop is not None, stop or 0.0
        if self.prefix == "fmi2":
            self.call("SetupExperiment", *given)
        else:
            self._experiment = given

    def enter_initialization(self) -> None:
        """Enter initialization mode."""
        self.call("EnterInitializationMode", *self._experiment)

    def exit_initialization(self) -> None:
        """Leave initialization mode."""
        self.call("ExitInitializationMode")
        self.look_around("during initialization")

    def get(self, names: Names) -> list[Value]:
        """Give the values of variables."""
        values: list[Value] = [0.0] * len(names)
        for batch in self.batches(names):
            status = batch.get(*batch.arguments)
            if status > 1:
                self.fail_exchange("Get", batch, status)
            if _ONE + _LITTLE != _ONE - _LITTLE:  # in nanoseconds, whatever numbers are rounded to
                self.look_around("when values were got")
            if batch.count == len(names):
                return batch.values[:] if batch.plain else batch.unload()
            for position, value in zip(batch.positions, batch.unload(), strict=True):
                values[position] = value
        return values

    def set(self, names: Names, values: Sequence[Value]) -> None:
        """Set variables."""
        for batch in self.batches(names):
            if batch.plain and batch.count == len(values):
                batch.values[:] = values
            else:
                batch.load(values)
            status = batch.set(*batch.arguments)
            if status > 1:
                self.fail_exchange("Set", batch, status)
            if _ONE + _LITTLE != _ONE - _LITTLE:
                self.look_around("when values were set")

    def batches(self, names: Names) -> list[Batch]:
        """Give a set of variables sorted by type, which is done once."""
        self._under_way[under_way.CALL] = self._exchanging
        batches = self._sorted.get(names)
        if batches is None:
            batches = sorted_by_type(self.name, self.prefix, self.variables, names, self._held)
            for batch in batches:
                batch.get, batch.set = (self.function(verb + batch.base) for verb in ("Get", "Set"))
                batch.arguments = batch.arguments_for(self.component, self.prefix)
            self._sorted[names] = batches
        return batches

    def fail_exchange(self, verb: str, batch: Batch, status: int) -> NoReturn:
        """Raise because a batch was not got or set; the variable is named where it is but one."""
        self.fail(verb + batch.base, status, batch.names[0] if batch.count == 1 else None)

    def directional_derivative(self, output: str, known: str) -> float:
        """Get the derivative of an output by an input, the state held fixed."""
        of, by = self.variables[output], self.variables[known]
        seed, found = (c_double * by.elements)(), (c_double * of.elements)()
        seed[by.element] = 1.0
        arrays = (seed, by.elements, found, of.elements) if self.prefix == "fmi3" else (seed, found)
        ends = self.references((output,)), 1, self.references((known,)), 1
        self.call("GetDirectionalDerivative", *ends, *arrays)
        return found[of.element]

    def references(self, names: Names) -> Any:
        """Give an array of value references."""
        return (c_uint * len(names))(*(self.variables[name].value_reference for name in names))

    def state(self, reuse: object = None) -> object:
        """Copy the complete state, over an earlier copy where one is given."""
        state = reuse if isinstance(reuse, c_void_p) else c_void_p()
        self.call("GetFMUState", byref(state))
        return state

    def restore(self, state: object) -> None:
        """Return to a copied state."""
        if not state:
            told = f"{self.prefix}GetFMUState gave no state, so that there is no way back"
            raise SlaveError(self.name, "error", self.time, told)
        self.call("SetFMUState", state)

    def free(self, state: Any) -> None:
        """Release a copied state; after a fatal error nothing may be called any more."""
        if self._worst < 4:
            self.call("FreeFMUState", byref(state))

    def serialize(self) -> bytes:
        """Give the present state as bytes."""
        state, size = self.state(), c_size_t()
        self.call("SerializedFMUStateSize", state, byref(size))
        data = (c_char * size.value)()
        self.call("SerializeFMUState", state, data, size)
        self.free(state)
        return data.raw

    def deserialize(self, data: bytes) -> None:
        """Take a serialised state."""
        state, buffer = c_void_p(), (c_char * len(data)).from_buffer_copy(data)
        self.call("DeserializeFMUState", buffer, len(data), byref(state))
        self.restore(state)
        self.free(state)

    def terminate(self) -> None:
        """End the simulation, free the instance and unload the library."""
        if self._library is None:
            return
        library, self._library = self._library, None
        self.note(under_way.ENDING)
        # After error only freeing is allowed, after fatal nothing at all (FMI 2.0 section 2.1.3).
        if self._worst < 3:
            self.function("Terminate")(self.component)
        if self._worst < 4:
            self.function("FreeInstance")(self.component)
            library.close()
