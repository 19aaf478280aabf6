"""The FMU that is checked: where it lies, and how it is made to move."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from warmlink.orchestration.master.assembly import open_slave
from warmlink.orchestration.master.slaves.fmi import FmiSlave
from warmlink.orchestration.system.model import ModelInfo, Variable

Row = list[float]


@dataclass(frozen=True)
class Subject:
    """An unpacked FMU: what it says of itself, and the folder that it lies in."""

    info: ModelInfo
    folder: Path

    @cached_property
    def inputs(self) -> list[Variable]:
        """Inputs that are one number each."""
        return self._numbers("input")

    @cached_property
    def outputs(self) -> tuple[str, ...]:
        """Names of the outputs that are one number each."""
        return tuple(variable.name for variable in self._numbers("output"))

    @property
    def start_time(self) -> float:
        """Start of the default experiment in s."""
        return self.info.default_experiment.start_time

    @property
    def stop_time(self) -> float:
        """End of the default experiment in s."""
        stop = self.info.default_experiment.stop_time
        return self.start_time + 1.0 if stop is None else stop

    @property
    def step_size(self) -> float:
        """Communication step size that the FMU proposes, else a hundredth of the experiment, in s."""
        return self.info.default_experiment.step_size or (self.stop_time - self.start_time) / 100

    def open(self, name: str = "checked") -> FmiSlave:
        """Give a fresh instance, initialized with the inputs of step 0."""
        slave = open_slave(name, self.info, self.folder)
        slave.enter_initialization(self.start_time, None)
        put(slave, self.excitation(0))
        slave.exit_initialization()
        return slave

    def excitation(self, index: int) -> dict[str, float]:
        """Values of the real inputs in a step: about their start values, never twice the same."""
        return {
            v.name: within(v, start_of(v) + 0.05 * scale_of(v) * (1.5 + math.sin(0.7 * index + i)))
            for i, v in enumerate(self.inputs)
            if v.kind == "Real"
        }

    def run(self, slave: FmiSlave, first: int, count: int) -> list[Row]:
        """Outputs after each of so many steps."""
        rows = []
        for index in range(first, first + count):
            put(slave, self.excitation(index))
            slave.step(self.start_time + index * self.step_size, self.step_size)
            rows.append(get(slave, self.outputs))
        return rows

    def _numbers(self, causality: str) -> list[Variable]:
        found = [v for v in self.info.variables.values() if v.causality == causality]
        numbers = [v for v in found if v.kind not in (None, "String") and not v.dimensions]
        if self.info.fmi_version == "2.0":
            return numbers
        # In FMI 3.0 an alias is another name of the same variable.
        return list({(v.value_reference, v.element): v for v in reversed(numbers)}.values())[::-1]


def put(slave: FmiSlave, values: dict[str, float]) -> None:
    """Set variables by name."""
    slave.set(tuple(values), list(values.values()))


def get(slave: FmiSlave, names: tuple[str, ...]) -> Row:
    """Values of variables by name, as numbers."""
    return [float(value) for value in slave.get(names)]


def start_of(variable: Variable) -> float:
    """Start value of a variable as a number."""
    return float(variable.start or 0)


def scale_of(variable: Variable) -> float:
    """Size of an ordinary value: nominal, else start, else 1."""
    return abs(variable.nominal or 0) or abs(start_of(variable)) or 1.0


def within(variable: Variable, value: float) -> float:
    """Value held inside the variable's declared range."""
    low = -math.inf if variable.min is None else variable.min
    high = math.inf if variable.max is None else variable.max
    return min(max(value, low), high)


def same(a: Row, b: Row) -> bool:
    """Whether two lists of values are the same, NaN being itself."""
    return all(x == y or (math.isnan(x) and math.isnan(y)) for x, y in zip(a, b, strict=True))
