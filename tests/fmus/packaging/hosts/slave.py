"""FMPy as a host that keeps what the slave logs, for scripts that run in processes of their own."""

from __future__ import annotations

import ctypes
from pathlib import Path

from fmpy import extract, read_model_description
from fmpy.fmi2 import (
    FMU2Slave,
    defaultCallbacks,
    fmi2CallbackAllocateMemoryTYPE,
    fmi2CallbackFreeMemoryTYPE,
    fmi2CallbackFunctions,
    fmi2CallbackLoggerTYPE,
    fmi2StepFinishedTYPE,
)

OK, WARNING, DISCARD, ERROR, FATAL = range(5)

_GETTERS = {"Real": "getReal", "Integer": "getInteger", "Boolean": "getBoolean"}
_SETTERS = {"Real": "setReal", "Integer": "setInteger", "Boolean": "setBoolean"}


class Slave:
    """One instance of an FMU, its variables by name, its messages as (status, category, text)."""

    def __init__(self, fmu: Path | str, name: str = "one", start: float = 0.0) -> None:
        self.description = read_model_description(str(fmu))
        self.variables = {v.name: v for v in self.description.modelVariables}
        self.messages: list[tuple[int, str, str]] = []
        self.fmu = FMU2Slave(
            guid=self.description.guid,
            unzipDirectory=extract(str(fmu)),
            modelIdentifier=self.description.coSimulation.modelIdentifier,
            instanceName=name,
        )
        self._callbacks = fmi2CallbackFunctions(
            logger=fmi2CallbackLoggerTYPE(self._log),
            allocateMemory=fmi2CallbackAllocateMemoryTYPE(defaultCallbacks.allocateMemory),
            freeMemory=fmi2CallbackFreeMemoryTYPE(defaultCallbacks.freeMemory),
            stepFinished=fmi2StepFinishedTYPE(),
        )
        self.fmu.instantiate(callbacks=self._callbacks, loggingOn=True)
        self.fmu.setupExperiment(startTime=start)

    def _log(self, environment: int, instance: bytes, status: int, category: bytes, text: bytes) -> None:
        self.messages.append((status, (category or b"").decode(), text.decode()))

    def initialize(self, values: dict[str, float] | None = None) -> Slave:
        self.fmu.enterInitializationMode()
        self.set(values or {})
        self.fmu.exitInitializationMode()
        return self

    def set(self, values: dict[str, float]) -> None:
        for name, value in values.items():
            variable = self.variables[name]
            kind = {"Real": float, "Integer": int, "Boolean": bool}[variable.type]
            getattr(self.fmu, _SETTERS[variable.type])([variable.valueReference], [kind(value)])

    def get(self, *names: str) -> list[float]:
        return [
            getattr(self.fmu, _GETTERS[self.variables[n].type])([self.variables[n].valueReference])[0]
            for n in names
        ]

    def step(self, time: float, step: float) -> int:
        """Status of a step, where FMPy itself would raise."""
        function = self.fmu.dll.fmi2DoStep
        return int(function(self.fmu.component, ctypes.c_double(time), ctypes.c_double(step), 1))

    def outputs(self) -> list[float]:
        return self.get(*(n for n, v in self.variables.items() if v.causality == "output"))

    def named(self, causality: str) -> list[str]:
        return [n for n, v in self.variables.items() if v.causality == causality]

    def sentences(self, status: int) -> list[str]:
        return [text for each, _, text in self.messages if each == status]
