"""A native FMU in this process, by the names of its variables, for tests."""

from __future__ import annotations

import tempfile
import threading
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

import pytest
from fmpy import calloc, extract, fmi2, fmi3, free, read_model_description
from fmpy.fmi1 import FMICallException

from warmlink.fmus.component import Component
from warmlink.fmus.packaging.views import opened

# FMPy loads a library from within its folder, and the process has but one working directory.
_LOADING = threading.Lock()


class Native:
    """One instance, with what it logs in `messages`; statuses other than OK raise."""

    def __init__(self, path: Path, component: Component, name: str | None = None, **options: Any) -> None:
        self.description = read_model_description(str(path), validate=False)
        self.modern = self.description.fmiVersion == "3.0"
        self.messages: list[str] = []
        self.scalars = {s.name: s for s in opened(component).scalars()}
        self._folder = tempfile.TemporaryDirectory(prefix="warmlink-")
        extract(str(path), self._folder.name)
        arguments = {
            "guid": self.description.guid,
            "unzipDirectory": self._folder.name,
            "modelIdentifier": component.name,
            "instanceName": name or component.snake_name,
        }
        if self.modern:
            with _LOADING:
                self.fmu: Any = fmi3.FMU3Slave(**arguments)
            self.fmu.instantiate(logMessage=lambda *call: self.messages.append(call[-1].decode()), **options)
        else:
            # Held here too: a further instantiation would let go of functions that this instance still calls.
            self._callbacks = callbacks = fmi2.fmi2CallbackFunctions()
            callbacks.logger = fmi2.fmi2CallbackLoggerTYPE(
                lambda *call: self.messages.append(call[4].decode())
            )
            callbacks.allocateMemory = fmi2.fmi2CallbackAllocateMemoryTYPE(calloc)
            callbacks.freeMemory = fmi2.fmi2CallbackFreeMemoryTYPE(free)
            with _LOADING:
                self.fmu = fmi2.FMU2Slave(**arguments)
            self.fmu.instantiate(callbacks=callbacks)

    def set(self, values: Mapping[str, float]) -> None:
        for name, value in values.items():
            kind = self._kind(name)
            given = float(value) if kind in ("Real", "Float64") else int(value)
            getattr(self.fmu, f"set{kind}")([self.scalars[name].reference], [given])

    def get(self, name: str) -> float:
        return float(getattr(self.fmu, f"get{self._kind(name)}")([self.scalars[name].reference])[0])

    def initialize(self, start: float = 0.0, stop: float | None = None) -> None:
        self.enter(start, stop)
        self.fmu.exitInitializationMode()

    def enter(self, start: float = 0.0, stop: float | None = None) -> None:
        if self.modern:
            self.fmu.enterInitializationMode(startTime=start, stopTime=stop)
        else:
            self.fmu.setupExperiment(startTime=start, stopTime=stop)
            self.fmu.enterInitializationMode()

    def step(self, time: float, step: float) -> Any:
        return self.fmu.doStep(time, step)

    def references(self, names: Iterable[str]) -> list[int]:
        return [self.scalars[name].reference for name in names]

    def close(self) -> None:
        """Free the instance and unload the library; every test must be able to."""
        getattr(self.fmu, "fmi3FreeInstance" if self.modern else "fmi2FreeInstance")(self.fmu.component)
        self._folder.cleanup()

    def _kind(self, name: str) -> str:
        variable = self.scalars[name].variable
        if self.modern and variable.choice is not None:
            return "Int64"
        kind = variable.type
        return {"Real": "Float64", "Integer": "Int32"}.get(kind, kind) if self.modern else kind


DISCARD, ERROR = 2, 3


def refused(native: Native, action: Callable[[], object], status: int = ERROR) -> str:
    """The sentence that an action which must be refused with a status leaves in the log."""
    before = len(native.messages)
    with pytest.raises(FMICallException) as answer:
        action()
    assert answer.value.status == status, f"status {answer.value.status}, not {status}"
    assert len(native.messages) > before, "nothing was logged"
    return native.messages[before]
