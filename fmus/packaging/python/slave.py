"""The inside of a Python FMU: a component's instance behind pythonfmu's slave interface.

Whatever goes wrong is logged and answered with `False` from `do_step`, which the host receives as
fmi2Discard. Nothing is ever raised: pythonfmu's library frees the slave when an exception reaches it, and
the host's next call then crashes. A host that goes on after a refused step reads NaN, not old values.
"""

from __future__ import annotations

import hashlib
import json
import math
import struct
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from typing import Any, ClassVar

from pythonfmu.enums import Fmi2Status
from pythonfmu.fmi2slave import Fmi2Slave

from warmlink.fmus.component import Component
from warmlink.fmus.component.instance import Instance
from warmlink.fmus.component.snapshot import VECTORS, Snapshot, contradiction
from warmlink.fmus.errors import InputError
from warmlink.fmus.packaging.python.exporter import finish_at_exit

_TIME_TOLERANCE = 1e-6
"""Share of a step by which two communication points may differ and be the same."""


@dataclass(frozen=True)
class _State:
    """All that a slave remembers; without a snapshot it is the ruin of a state that could not be read."""

    snapshot: Snapshot | None
    unfit: str | None = None
    refused: list[str] = field(default_factory=list)
    discarded: bool = False
    lost: bool = False

    def is_well(self, component: Component) -> bool:
        """Whether a slave of the component could have remembered this."""
        return (
            self.snapshot is not None
            and contradiction(component, self.snapshot) is None
            and isinstance(self.unfit, str | None)
            and isinstance(self.refused, list)
            and all(isinstance(sentence, str) for sentence in self.refused)
            and isinstance(self.discarded, bool)
            and isinstance(self.lost, bool)
        )


def _digest(content: bytes) -> bytes:
    return hashlib.sha256(content).hexdigest()[:16].encode("ascii")


def _integer(value: float) -> int:
    """The nearest that FMI's integers have, 0 for none."""
    return 0 if math.isnan(value) else int(min(max(value, -(2.0**31)), 2.0**31 - 1))


def _packed(values: dict[str, Any]) -> dict[str, Any]:
    """State with its vectors as the bytes of doubles in hex, so that even a NaN keeps its bits."""
    snapshot = {
        name: struct.pack(f"<{len(value)}d", *value).hex() if name in VECTORS else value
        for name, value in values["snapshot"].items()
    }
    return values | {"snapshot": snapshot}


def _unpacked(values: dict[str, Any]) -> dict[str, Any]:
    snapshot = {
        name: [each for (each,) in struct.iter_unpack("<d", bytes.fromhex(value))]
        if name in VECTORS
        else value
        for name, value in values["snapshot"].items()
    }
    return values | {"snapshot": snapshot}


class ComponentSlave(Fmi2Slave):
    """A slave for one component, which a subclass names.

    Attributes
    ----------
    component : the declaration
    form : text that differs between versions of the FMU, so that none takes another's serialised state
    """

    component: ClassVar[Component]
    form: ClassVar[str]

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self._instance = Instance(self.component, self.instance_name)
        self._instance.warn = lambda sentence: self.log(sentence, Fmi2Status.warning)
        self._types = {s.reference: s.variable.type for s in self.component.scalars()}
        self._first_output = self.component.p.size + self.component.u.size
        self._begun = False
        self._unfit: str | None = None
        self._refused: list[str] = []
        self._discarded = self._lost = False
        finish_at_exit(kwargs.get("resources", ""))

    # The functions below are called by pythonfmu's library and have the names that it expects.

    def setup_experiment(
        self, start_time: float, stop_time: float | None = None, tolerance: float | None = None
    ) -> None:
        """Take the start time in s; there is no tolerance to set."""
        self._guarded(lambda: self._instance.begin(start_time))

    def exit_initialization_mode(self) -> None:
        """Fix the parameters; what is wrong with them is held for the first step."""
        try:
            self._instance.initialize()
        except Exception as error:
            self._unfit = self._sentence(error)
            self.log(self._unfit, Fmi2Status.warning)
        self._begun = True

    def do_step(self, current_time: float, step_size: float) -> bool:
        """Step, or log why not and return False, leaving everything as it was."""
        if self._unfit is not None:
            self._lost = True
            return self._discard(self._unfit)
        if self._discarded and abs(current_time - self._instance.time) > _TIME_TOLERANCE * abs(step_size):
            self._lost = True
            return self._discard(
                f"{self.instance_name}: a step from {current_time:g} s, but the step from "
                f"{self._instance.time:g} s was refused; repeat that one or restore a state"
            )
        if self._refused:
            sentence = "; ".join(self._refused)
            self._refused = []
            return self._discard(sentence)
        try:
            self._instance.step(current_time, step_size)
        except Exception as error:
            return self._discard(self._sentence(error))
        self._discarded = self._lost = False
        return True

    def get_real(self, vrs: list[int]) -> list[float]:
        """Values of Real variables by value reference; NaN for one that cannot be had."""
        return self._get("Real", vrs)

    def get_integer(self, vrs: list[int]) -> list[int]:
        """Values of Integer variables by value reference; 0 for one that cannot be had."""
        return [_integer(value) for value in self._get("Integer", vrs)]

    def get_boolean(self, vrs: list[int]) -> list[bool]:
        """Values of Boolean variables by value reference; False for one that cannot be had."""
        return [bool(value == 1) for value in self._get("Boolean", vrs)]

    def get_string(self, vrs: list[int]) -> list[str]:
        """No variable is a String."""
        self._get("String", vrs)
        return ["" for _ in vrs]

    def set_real(self, vrs: list[int], values: list[float]) -> None:
        """Set Real variables by value reference."""
        self._set("Real", vrs, values)

    def set_integer(self, vrs: list[int], values: list[int]) -> None:
        """Set Integer variables by value reference."""
        self._set("Integer", vrs, values)

    def set_boolean(self, vrs: list[int], values: list[bool]) -> None:
        """Set Boolean variables by value reference."""
        self._set("Boolean", vrs, values)

    def set_string(self, vrs: list[int], values: list[str]) -> None:
        """No variable is a String."""
        self._set("String", vrs, values)

    def _get_fmu_state(self) -> _State:
        return _State(
            self._instance.snapshot(), self._unfit, list(self._refused), self._discarded, self._lost
        )

    def _set_fmu_state(self, state: _State) -> None:
        if state.snapshot is None:
            self._refuse("; ".join(state.refused))
            return
        self._instance.restore(state.snapshot)
        self._begun = state.snapshot.initialized or state.unfit is not None
        self._unfit, self._refused = state.unfit, list(state.refused)
        self._discarded, self._lost = state.discarded, state.lost

    @classmethod
    def _fmu_state_to_bytes(cls, state: _State) -> bytes:
        content = json.dumps(_packed(asdict(state))).encode("utf-8")
        return b" ".join((cls.form.encode("utf-8"), _digest(content), content))

    @classmethod
    def _fmu_state_from_bytes(cls, state: bytes) -> _State:
        form, _, rest = bytes(state).partition(b" ")
        digest, _, content = rest.partition(b" ")
        if form != cls.form.encode("utf-8") and digest == _digest(content):
            return _State(None, refused=["the serialised state belongs to another version of this FMU"])
        try:
            values = _unpacked(json.loads(content))
            found = _State(Snapshot(**values.pop("snapshot")), **values)
        except (ValueError, TypeError, KeyError, AttributeError, RecursionError, struct.error):
            found = None
        if digest != _digest(content) or found is None or not found.is_well(cls.component):
            return _State(None, refused=["the serialised state is damaged; serialise it anew"])
        return found

    def _get(self, kind: str, references: list[int]) -> list[float]:
        values = []
        for reference in references:
            try:
                self._check_type(kind, reference)
                value = self._instance.get_reference(reference)
                values.append(math.nan if self._lost and reference >= self._first_output else value)
            except Exception as error:
                self._refuse(self._sentence(error))
                values.append(math.nan)
        return values

    def _set(self, kind: str, references: list[int], values: list[Any]) -> None:
        for reference, value in zip(references, values, strict=False):
            try:
                self._check_type(kind, reference)
                self._instance.set_reference(reference, float(value))
            except Exception as error:
                self._refuse(self._sentence(error))

    def _check_type(self, kind: str, reference: int) -> None:
        if self._types.get(reference) != kind:
            raise InputError(
                f"{self.instance_name}: no {kind} variable has the value reference {reference}; "
                "take it from modelDescription.xml"
            )

    def _guarded(self, action: Callable[[], None]) -> None:
        try:
            action()
        except Exception as error:
            self._refuse(self._sentence(error))

    def _refuse(self, sentence: str) -> None:
        """Log what cannot be done; once the run has begun, the next step is discarded for it."""
        self.log(sentence, Fmi2Status.error)
        if self._begun:
            self._refused.append(sentence)

    def _discard(self, sentence: str) -> bool:
        # With the status of a discard libcosim would show the sentence to those alone who ask for debugging.
        self.log(sentence, Fmi2Status.warning, "logStatusDiscard")
        self._discarded = True
        return False

    def _sentence(self, error: Exception) -> str:
        if isinstance(error, InputError):
            return str(error)
        return f"{self.instance_name}: {type(error).__name__} at {self._instance.time:g} s: {error}"
