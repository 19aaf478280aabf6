"""The inside of a Python FMU: a component's instance behind pythonfmu's slave interface.

Whatever goes wrong is logged and answered with `False` from `do_step`, which the host receives as
fmi2Discard. Nothing is ever raised: pythonfmu's library frees the slave when an exception reaches it, and
the host's next call then crashes. A host that goes on after a refused step reads NaN, not old values.
"""

import atexit
import contextlib
import ctypes
import hashlib
import json
import math
import os
import sys
import threading
from collections.abc import Callable
from dataclasses import asdict, dataclass, field, replace
from functools import partial, partialmethod
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from pythonfmu.enums import Fmi2Status
from pythonfmu.fmi2slave import Fmi2Slave

from warmlink.fmus.component import Component
from warmlink.fmus.component.instance import VECTORS, Instance, Snapshot, is_possible
from warmlink.fmus.errors import InputError

_TIME_TOLERANCE = 1e-6
"""Share of a step by which two communication points may differ and be the same."""

_RUIN = b"damaged"
"""What a state that could not be read is serialised to, which cannot be read either."""

_known: set[str] = set()


@dataclass
class _Memory:
    """All that a slave remembers beside its instance, whose snapshot is part of it where it is handed out."""

    snapshot: Snapshot | None = None  # without one this is the ruin of a state that could not be read
    unfit: str | None = None  # why the instance could not begin
    refused: list[str] = field(default_factory=list)  # for which the next step is discarded
    discarded: bool = False  # whether the last step was
    lost: bool = False  # whether the host went on all the same

    def is_well(self, component: Component) -> bool:
        """Whether a slave of the component could have remembered this."""
        assert self.snapshot is not None
        told = [*self.refused, *([] if self.unfit is None else [self.unfit])]
        return (
            is_possible(component, self.snapshot)
            and isinstance(self.refused, list)
            and all(isinstance(each, str) for each in told)
            and type(self.discarded) is type(self.lost) is bool
        )


class ComponentSlave(Fmi2Slave):
    """A slave for one component, which a subclass names.

    The form differs between versions of the FMU, so that none takes another's serialised state.
    """

    component: ClassVar[Component]
    form: ClassVar[str]

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        resources = str(kwargs.get("resources", ""))
        playing, lost = _with_tables(self.component, resources)
        self._instance = Instance(playing, self.instance_name)
        self._instance.warn = lambda sentence: self.log(sentence, Fmi2Status.warning)
        self._types = {s.reference: s.variable.type for s in self.component.scalars()}
        self._begun = False
        self._memory = _Memory(unfit=lost and f"{self.instance_name}: {lost}")
        _finish_at_exit(resources)

    # pythonfmu's library calls what follows by names that it expects.

    def setup_experiment(
        self, start_time: float, stop_time: float | None = None, tolerance: float | None = None
    ) -> None:
        """Take the start time in s; there is no tolerance to set."""
        self._attempt(partial(self._instance.begin, start_time))

    def exit_initialization_mode(self) -> None:
        """Fix the parameters; what is wrong with them is held for the first step."""
        try:
            self._instance.initialize()
        except Exception as error:
            self._memory.unfit = self._sentence(error)
        if self._memory.unfit is not None:
            self.log(self._memory.unfit, Fmi2Status.warning)
        self._begun = True

    def do_step(self, current_time: float, step_size: float) -> bool:
        """Step, or log why not and return False, leaving everything as it was."""
        memory, reached = self._memory, self._instance.time
        if memory.unfit is not None:
            memory.lost = True
            return self._discard(memory.unfit)
        if memory.discarded and abs(current_time - reached) > _TIME_TOLERANCE * abs(step_size):
            memory.lost = True
            return self._discard(
                f"{self.instance_name}: a step from {current_time:g} s, but the step from {reached:g} s was "
                "refused; repeat that one or restore a state"
            )
        if memory.refused:
            sentence, memory.refused = "; ".join(memory.refused), []
            return self._discard(sentence)
        try:
            self._instance.step(current_time, step_size)
        except Exception as error:
            return self._discard(self._sentence(error))
        memory.discarded = memory.lost = False
        return True

    def _get(self, kind: str, references: list[int]) -> list[Any]:
        """Values of a kind by reference; NaN, 0 and False for those that cannot be had."""
        values = [self._attempt(partial(self._value, kind, each)) for each in references]
        return [_CONVERSIONS[kind](math.nan if value is None else value) for value in values]

    def _set(self, kind: str, references: list[int], values: list[Any]) -> None:
        """Set variables of a kind by reference; no variable is a String."""
        for reference, value in zip(references, values, strict=False):
            self._attempt(partial(self._put, kind, reference, value))

    get_real = partialmethod(_get, "Real")
    get_integer = partialmethod(_get, "Integer")
    get_boolean = partialmethod(_get, "Boolean")
    get_string = partialmethod(_get, "String")
    set_real = partialmethod(_set, "Real")
    set_integer = partialmethod(_set, "Integer")
    set_boolean = partialmethod(_set, "Boolean")
    set_string = partialmethod(_set, "String")

    def _get_fmu_state(self) -> _Memory:
        return replace(self._memory, snapshot=self._instance.snapshot(), refused=list(self._memory.refused))

    def _set_fmu_state(self, state: _Memory) -> None:
        if state.snapshot is None:
            self._refuse("; ".join(state.refused))
            return
        self._instance.restore(state.snapshot)
        self._begun = state.snapshot.initialized or state.unfit is not None
        self._memory = replace(state, refused=list(state.refused))

    @classmethod
    def _fmu_state_to_bytes(cls, state: _Memory) -> bytes:
        """State with its vectors as the bytes of doubles in hex, so that even a NaN keeps its bits."""
        if state.snapshot is None:
            return _RUIN
        values = asdict(state)
        for name in VECTORS:
            values["snapshot"][name] = np.array(values["snapshot"][name], dtype="<f8").tobytes().hex()
        content = json.dumps(values).encode("utf-8")
        return b" ".join((cls.form.encode("utf-8"), _digest(content), content))

    @classmethod
    def _fmu_state_from_bytes(cls, state: bytes) -> _Memory:
        form, _, rest = bytes(state).partition(b" ")
        digest, _, content = rest.partition(b" ")
        if form != cls.form.encode("utf-8") and digest == _digest(content):
            return _Memory(refused=["the serialised state belongs to another version of this FMU"])
        try:
            values = json.loads(content)
            snapshot = values.pop("snapshot")
            for name in VECTORS:
                snapshot[name] = np.frombuffer(bytes.fromhex(snapshot[name]), dtype="<f8").tolist()
            found = _Memory(Snapshot(**snapshot), **values)
            if digest == _digest(content) and found.is_well(cls.component):
                return found
        except (ValueError, TypeError, KeyError, AttributeError, RecursionError):
            pass
        return _Memory(refused=["the serialised state is damaged; serialise it anew"])

    def _value(self, kind: str, reference: int) -> float:
        self._check_type(kind, reference)
        value = self._instance.get_reference(reference)
        computed = reference >= self.component.p.size + self.component.u.size
        return math.nan if self._memory.lost and computed else value

    def _put(self, kind: str, reference: int, value: Any) -> None:
        self._check_type(kind, reference)
        self._instance.set_reference(reference, float(value))

    def _check_type(self, kind: str, reference: int) -> None:
        if self._types.get(reference) != kind:
            raise InputError(
                f"{self.instance_name}: no {kind} variable has the value reference {reference}; "
                "take it from modelDescription.xml"
            )

    def _attempt(self, action: Callable[[], float | None]) -> float | None:
        """What an action returns; None where it fails, which is refused."""
        try:
            return action()
        except Exception as error:
            self._refuse(self._sentence(error))
            return None

    def _refuse(self, sentence: str) -> None:
        """Log what cannot be done; once the run has begun, the next step is discarded for it."""
        self.log(sentence, Fmi2Status.error)
        if self._begun:
            self._memory.refused.append(sentence)

    def _discard(self, sentence: str) -> bool:
        # With the status of a discard libcosim would show the sentence to those alone who ask for debugging.
        self.log(sentence, Fmi2Status.warning, "logStatusDiscard")
        self._memory.discarded = True
        return False

    def _sentence(self, error: Exception) -> str:
        if isinstance(error, InputError):
            return str(error)
        return f"{self.instance_name}: {type(error).__name__} at {self._instance.time:g} s: {error}"


def _with_tables(component: Component, resources: str) -> tuple[Component, str | None]:
    """The component with the tables in the FMU's resources in place of those it was declared with.

    Beside it why there are none, or None; then it has those that it was declared with.
    """
    found = []
    for each in component.tables:
        path = Path(resources) / each.file
        try:
            found.append(each.read(path.read_bytes(), str(path)))
        except OSError as fault:
            return component, f"{path}: cannot be read ({fault.strerror}); unpack the FMU whole"
        except InputError as fault:
            return component, str(fault)
    return replace(component, tables=tuple(found)) if found else component, None


def _integer(value: float) -> int:
    """The nearest that FMI's integers have, 0 for none."""
    return 0 if math.isnan(value) else int(min(max(value, -(2.0**31)), 2.0**31 - 1))


_CONVERSIONS: dict[str, Callable[[float], Any]] = {
    "Real": float,
    "Integer": _integer,
    "Boolean": lambda value: value == 1,
    "String": lambda value: "",
}


def _digest(content: bytes) -> bytes:
    return hashlib.sha256(content).hexdigest()[:16].encode("ascii")


def _finish_at_exit(resources: str) -> None:
    """Have the library of an FMU give up its hold on the interpreter before the process ends.

    On Linux version 0.7.0 does that twice as the process ends, once in a destructor of its own after the
    held object was destroyed, and corrupts the heap; with nothing held any more, both do nothing. The folder
    is that of the resources beside the library.
    """
    if not sys.platform.startswith("linux"):
        return
    for library in set(map(str, Path(resources).parent.glob("binaries/*/*.so"))) - _known:
        _known.add(library)
        # A library that is not loaded, or has no such function, needs none of this.
        with contextlib.suppress(OSError, AttributeError):
            loaded = ctypes.CDLL(library, mode=os.RTLD_NOLOAD | os.RTLD_NOW)
            atexit.register(_finish, loaded.finalizePythonInterpreter)


def _finish(release: Any) -> None:
    # In a host that is not Python the library runs the interpreter in a thread of its own, which ends it
    # here and cannot wait for itself.
    if threading.get_native_id() == os.getpid():
        release()
