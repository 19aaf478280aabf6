"""The FMU that is checked, and instances of it."""

import math
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from warmlink.orchestration.master.assembly import open_slave
from warmlink.orchestration.master.slaves.slave import RunSpan, SlaveError
from warmlink.orchestration.system.model import FmuVariable, ModelInfo


class Subject:
    """The FMU that is checked, unpacked into a folder.

    `inputs`, and the names `outputs`, are of variables that are one number each; times and step size in s are
    those that it proposes, else a hundredth of 1 s. A check of many steps makes as many as fit into
    `seconds`.
    """

    def __init__(self, info: ModelInfo, folder: Path, seconds: float) -> None:
        self.info, self.folder, self.seconds = info, folder, seconds
        self.inputs = self._numbers("input")
        self.outputs = tuple(variable.name for variable in self._numbers("output"))
        proposed = info.default_experiment
        self.start_time = proposed.start_time
        self.stop_time = self.start_time + 1.0 if proposed.stop_time is None else proposed.stop_time
        self.step_size = proposed.step_size or (self.stop_time - self.start_time) / 100

    def time(self, index: int) -> float:
        """Time in s at which a step begins."""
        return self.start_time + index * self.step_size

    def excitation(self, index: int) -> dict[str, float]:
        """Values of the real inputs in a step: about their start values, never twice the same."""
        return {
            v.name: within(v, float(v.start or 0) + 0.05 * scale(v) * (1.5 + math.sin(0.7 * index + i)))
            for i, v in enumerate(self.inputs)
            if v.kind == "Real"
        }

    def other_parameters(self) -> dict[str, float]:
        """Values of the real parameters near their start values, but not those."""
        return {
            v.name: within(v, float(v.start or 0) + 0.01 * scale(v))
            for v in self._numbers("parameter")
            if v.kind == "Real" and v.variability != "constant"
        }

    def _numbers(self, causality: str) -> list[FmuVariable]:
        found = [v for v in self.info.variables.values() if v.causality == causality]
        numbers = [v for v in found if v.kind not in (None, "String", "Binary") and not v.dimensions]
        if self.info.fmi_version == "2.0":
            return numbers
        # In FMI 3.0 an alias is another name of the same variable.
        return list({(v.value_reference, v.element): v for v in reversed(numbers)}.values())[::-1]


class CheckedInstance:
    """A fresh instance of the FMU, initialized with the inputs of step 0.

    It is told whether the check `goes_back`, and takes `parameters` other than those it begins with.
    """

    def __init__(
        self,
        subject: Subject,
        name: str = "checked",
        *,
        goes_back: bool = False,
        parameters: Mapping[str, float] = MappingProxyType({}),
    ) -> None:
        self.subject = subject
        self.slave = open_slave(name, subject.info, subject.folder)
        self.slave.setup(RunSpan(subject.start_time, goes_back=goes_back))
        self.put(parameters)
        self.slave.enter_initialization()
        self.put(subject.excitation(0))
        self.slave.exit_initialization()

    def put(self, values: Mapping[str, float]) -> None:
        """Set variables by name."""
        self.slave.set(tuple(values), list(values.values()))

    def outputs(self) -> NDArray[np.float64]:
        """Values of the outputs as numbers."""
        return np.array([float(value) for value in self.slave.get(self.subject.outputs)])

    def step(self, index: int) -> None:
        """Take a step; an FMU that asks to end the simulation takes no other."""
        told = self.slave.step(self.subject.time(index), self.subject.step_size)
        if told is not None:
            raise SlaveError(self.slave.name, "ended", self.subject.time(index), told)

    def run(self, first: int, count: int) -> NDArray[np.float64]:
        """Outputs after each of so many steps, each with inputs of its own."""
        rows = []
        for index in range(first, first + count):
            self.put(self.subject.excitation(index))
            self.step(index)
            rows.append(self.outputs())
        return np.array(rows)

    def arrive(self, point: int) -> dict[str, float]:
        """Run to an operating point, and give the inputs set there."""
        self.run(5 * point, 5)
        values = self.subject.excitation(5 * point + 4)
        self.put(values)
        return values


def scale(variable: FmuVariable) -> float:
    """Size of an ordinary value: nominal, else start, else 1."""
    return abs(variable.nominal or 0) or abs(float(variable.start or 0)) or 1.0


def within(variable: FmuVariable, value: float) -> float:
    """Value held inside the variable's declared range."""
    low = -math.inf if variable.min is None else variable.min
    return min(max(value, low), math.inf if variable.max is None else variable.max)
