"""The FMU that is checked: what it says of itself, where it lies, and how it is made to move."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from warmlink.fmus.packaging.inspection.host import REALS, Host, readable


@dataclass(frozen=True)
class Subject:
    """An extracted FMU.

    Attributes
    ----------
    description : FMPy's model description
    folder : where the FMU lies extracted
    """

    description: Any
    folder: Path

    def declares(self, *capabilities: str) -> bool:
        """Whether the FMU declares one of these capabilities for co-simulation.

        FMPy 0.3 does not read all of FMI 3.0's.
        """
        simulation = self._tree.find("CoSimulation")
        given = {} if simulation is None else simulation.attrib
        return any(given.get(name) in ("true", "1") for name in capabilities)

    @cached_property
    def inputs(self) -> list[Any]:
        """Inputs that are one number each."""
        return [v for v in self.description.modelVariables if v.causality == "input" and readable(v)]

    @cached_property
    def outputs(self) -> list[str]:
        """Names of the outputs that are one number each."""
        return [v.name for v in self.description.modelVariables if v.causality == "output" and readable(v)]

    @property
    def start_time(self) -> float:
        """Start of the default experiment in s."""
        return _number(self._experiment, "startTime", 0.0)

    @property
    def stop_time(self) -> float:
        """End of the default experiment in s."""
        return _number(self._experiment, "stopTime", self.start_time + 1.0)

    @property
    def step_size(self) -> float:
        """Communication step size that the FMU proposes, else a hundredth of the experiment, in s."""
        return _number(self._experiment, "stepSize", (self.stop_time - self.start_time) / 100)

    def open(self, name: str = "checked") -> Host:
        """Give a fresh instance, initialized with the inputs of step 0."""
        host = Host(self.description, self.folder, name)
        host.initialize(self.start_time, self.excitation(0))
        return host

    def excitation(self, index: int) -> dict[str, float]:
        """Values of the real inputs in a step: about their start values, never twice the same."""
        return {
            v.name: within(v, start_of(v) + 0.05 * scale_of(v) * (1.5 + math.sin(0.7 * index + i)))
            for i, v in enumerate(self.inputs)
            if v.type in REALS
        }

    def run(self, host: Host, first: int, count: int) -> list[list[float]]:
        """Outputs after each of so many steps."""
        rows = []
        for index in range(first, first + count):
            host.set(self.excitation(index))
            host.step(self.start_time + index * self.step_size, self.step_size)
            rows.append(host.get(self.outputs))
        return rows

    @property
    def _experiment(self) -> Any:
        return self.description.defaultExperiment

    @cached_property
    def _tree(self) -> ElementTree.Element:
        return ElementTree.parse(self.folder / "modelDescription.xml").getroot()


def start_of(variable: Any) -> float:
    """Start value of a variable as a number."""
    text = str(variable.start if variable.start is not None else 0).lower()
    return {"true": 1.0, "false": 0.0}.get(text) if text in ("true", "false") else float(text)  # type: ignore[return-value]


def scale_of(variable: Any) -> float:
    """Size of an ordinary value: nominal, else start, else 1."""
    return abs(float(variable.nominal or 0)) or abs(start_of(variable)) or 1.0


def within(variable: Any, value: float) -> float:
    """Value held inside the variable's declared range."""
    low = -math.inf if variable.min is None else float(variable.min)
    high = math.inf if variable.max is None else float(variable.max)
    return min(max(value, low), high)


def _number(experiment: Any, name: str, otherwise: float) -> float:
    value = getattr(experiment, name, None) if experiment is not None else None
    return otherwise if value is None else float(value)
