"""FMPy as a host that keeps what the slave logs, for scripts that run in processes of their own."""

from __future__ import annotations

import ctypes
import functools
import struct
import zipfile
from collections.abc import Iterable
from pathlib import Path
from xml.etree import ElementTree as ET

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

_KINDS = {"Real": float, "Integer": int, "Boolean": bool}


@functools.cache
def _read(fmu: str) -> tuple:
    with zipfile.ZipFile(fmu) as archive:
        root = ET.fromstring(archive.read("modelDescription.xml"))
    accepting = root.find("VendorAnnotations/Tool/acceptsNaN")
    names = set() if accepting is None else set(accepting.get("variables", "").split())
    return read_model_description(fmu), extract(fmu), names


class Slave:
    """One instance of an FMU, its variables by name, its messages as (status, category, text)."""

    def __init__(self, fmu: Path | str, name: str = "one", start: float = 0.0) -> None:
        self.description, folder, self.accepting_nan = _read(str(fmu))
        self.variables = {v.name: v for v in self.description.modelVariables}
        self.messages: list[tuple[int, str, str]] = []
        self.time = start
        self.fmu = FMU2Slave(
            guid=self.description.guid,
            unzipDirectory=folder,
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
        for kind, (names, convert) in self._by_type(values).items():
            references = [self.variables[n].valueReference for n in names]
            getattr(self.fmu, f"set{kind}")(references, [convert(values[n]) for n in names])

    def get(self, *names: str) -> list[float]:
        found: dict[str, float] = {}
        for kind, (some, _) in self._by_type(names).items():
            references = [self.variables[n].valueReference for n in some]
            found |= zip(some, getattr(self.fmu, f"get{kind}")(references), strict=True)
        return [found[n] for n in names]

    def _by_type(self, names: Iterable[str]) -> dict[str, tuple[list[str], type]]:
        groups: dict[str, tuple[list[str], type]] = {}
        for name in names:
            kind = self.variables[name].type
            groups.setdefault(kind, ([], _KINDS[kind]))[0].append(name)
        return groups

    def step(self, time: float, step: float) -> int:
        """Status of a step, where FMPy itself would raise."""
        function = self.fmu.dll.fmi2DoStep
        return int(function(self.fmu.component, ctypes.c_double(time), ctypes.c_double(step), 1))

    def outputs(self) -> list[float]:
        return self.get(*(n for n, v in self.variables.items() if v.causality == "output"))

    def named(self, causality: str) -> list[str]:
        return [n for n, v in self.variables.items() if v.causality == causality]

    def bits(self) -> str:
        return struct.pack(f"{len(self.named('output'))}d", *self.outputs()).hex()

    def sentences(self, category: str) -> list[str]:
        return [text for _, each, text in self.messages if each == category]
