"""One instance of anybody's FMU, of FMI 2.0 or FMI 3.0 for co-simulation, by the names of its variables."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

_TYPES = {
    "2.0": {"Real": "Real", "Integer": "Integer", "Enumeration": "Integer", "Boolean": "Boolean"},
    "3.0": {
        **{
            name: name
            for name in ("Float32", "Float64", "Int8", "UInt8", "Int16", "UInt16", "Int32", "UInt32")
        },
        **{name: name for name in ("Int64", "UInt64", "Boolean")},
        "Enumeration": "Int64",
    },
}
REALS = ("Real", "Float64", "Float32")


def readable(variable: Any) -> bool:
    """Whether a variable of FMPy's model description is one number: no text, clock or array."""
    return any(variable.type in types for types in _TYPES.values()) and not variable.dimensions


class Host:
    """One instance, which it holds until `close`.

    Parameters
    ----------
    description : FMPy's model description of the FMU
    folder : where the FMU lies extracted
    name : of the instance

    Raises
    ------
    Exception
        FMPy's own, wherever the FMU answers with discard, error or fatal.
    """

    def __init__(self, description: Any, folder: Path, name: str) -> None:
        self.messages: list[str] = []
        self._types = _TYPES["2.0" if description.fmiVersion == "2.0" else "3.0"]
        self._modern = description.fmiVersion != "2.0"
        self._variables = {v.name: v for v in description.modelVariables}
        common = {
            "guid": description.instantiationToken if self._modern else description.guid,
            "modelIdentifier": description.coSimulation.modelIdentifier,
            "unzipDirectory": str(folder),
            "instanceName": name,
        }
        self.fmu = self._modern_slave(common) if self._modern else self._slave(common)

    def initialize(self, start: float, values: Mapping[str, float]) -> None:
        """Set start values and go through initialization at a time in s."""
        if self._modern:
            self.fmu.enterInitializationMode(startTime=start)
        else:
            self.fmu.setupExperiment(startTime=start)
            self.fmu.enterInitializationMode()
        self.set(values)
        self.fmu.exitInitializationMode()

    def set(self, values: Mapping[str, float]) -> None:
        """Set variables by name."""
        for name, value in values.items():
            kind = self._types[self._variables[name].type]
            given: float | int = float(value) if kind in REALS else int(value)
            getattr(self.fmu, f"set{kind}")([self._variables[name].valueReference], [given])

    def get(self, names: Iterable[str]) -> list[float]:
        """Values of variables by name."""
        values = []
        for name in names:
            variable = self._variables[name]
            values.append(getattr(self.fmu, f"get{self._types[variable.type]}")([variable.valueReference])[0])
        return values

    def step(self, time: float, step: float) -> None:
        """Go from a time to `time + step`, in s."""
        self.fmu.doStep(time, step)

    def stepper(self) -> Callable[[float, float], int]:
        """Function of time and step that steps, with little around it, and gives the status."""
        from ctypes import c_bool, c_double, c_int, c_void_p, pointer

        instance = self.fmu.component
        if not self._modern:
            step2 = self.fmu.dll["fmi2DoStep"]
            step2.argtypes, step2.restype = [c_void_p, c_double, c_double, c_int], c_int
            return lambda time, step: step2(instance, time, step, 1)
        step3 = self.fmu.dll["fmi3DoStep"]
        step3.argtypes, step3.restype = [c_void_p, c_double, c_double, c_bool, *[c_void_p] * 4], c_int
        answers = pointer(c_bool()), pointer(c_bool()), pointer(c_bool()), pointer(c_double())
        return lambda time, step: step3(instance, time, step, True, *answers)

    def save(self) -> Any:
        """FMU state, to be given back to `restore` and `forget`."""
        return self.fmu.getFMUState() if self._modern else self.fmu.getFMUstate()

    def restore(self, state: Any) -> None:
        """Go back to an FMU state."""
        if self._modern:
            self.fmu.setFMUState(state)
        else:
            self.fmu.setFMUstate(state)

    def forget(self, state: Any) -> None:
        """Free an FMU state."""
        if self._modern:
            self.fmu.freeFMUState(state)
        else:
            self.fmu.freeFMUstate(state)

    def serialized(self, state: Any) -> bytes:
        """Bytes of an FMU state."""
        return bytes(self.fmu.serializeFMUState(state) if self._modern else self.fmu.serializeFMUstate(state))

    def deserialized(self, content: bytes) -> Any:
        """FMU state of its bytes."""
        return (
            self.fmu.deserializeFMUState(content) if self._modern else self.fmu.deSerializeFMUstate(content)
        )

    def derivative(self, unknown: str, known: str) -> float:
        """Directional derivative of an output by an input."""
        references = [[self._variables[name].valueReference] for name in (unknown, known)]
        return float(self.fmu.getDirectionalDerivative(*references, [1.0])[0])

    def close(self) -> None:
        """Terminate and free the instance; the library stays loaded."""
        self.fmu.terminate()
        if self._modern:
            self.fmu.fmi3FreeInstance(self.fmu.component)
        else:
            self.fmu.fmi2FreeInstance(self.fmu.component)

    def _slave(self, common: dict[str, str]) -> Any:
        from fmpy import calloc, fmi2, free

        callbacks = fmi2.fmi2CallbackFunctions()
        callbacks.logger = fmi2.fmi2CallbackLoggerTYPE(lambda *call: self._note(call[-1]))
        callbacks.allocateMemory = fmi2.fmi2CallbackAllocateMemoryTYPE(calloc)
        callbacks.freeMemory = fmi2.fmi2CallbackFreeMemoryTYPE(free)
        slave = fmi2.FMU2Slave(**common)
        slave.instantiate(callbacks=callbacks)
        return slave

    def _modern_slave(self, common: dict[str, str]) -> Any:
        from fmpy import fmi3

        slave = fmi3.FMU3Slave(**common)
        slave.instantiate(logMessage=lambda *call: self._note(call[-1]))
        return slave

    def _note(self, message: bytes | None) -> None:
        self.messages.append((message or b"").decode("utf-8", "replace"))


def same(a: Iterable[float], b: Iterable[float]) -> bool:
    """Whether two lists of values are the same, NaN being itself."""
    pairs = zip(a, b, strict=True)
    return all(x == y or (isinstance(x, float) and math.isnan(x) and math.isnan(y)) for x, y in pairs)
