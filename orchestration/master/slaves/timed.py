"""Slaves whose calls are counted and timed."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import field
from typing import Any

from warmlink.fmus.records import dataclass
from warmlink.orchestration.master.slaves.slave import Slave, SlaveError

CALLS = ("step", "set", "get", "state", "restore")
"""What is counted: steps, values set and got, copies of the state, and returns to one (rollbacks)."""


@dataclass
class Calls:
    """Calls of one kind: how many, how long in s, and how many were refused (discard or error)."""

    count: int = 0
    seconds: float = 0.0
    refused: int = 0


@dataclass
class SlaveStatistics:
    """What a slave was asked for in a run: `calls` by the names of `CALLS`, and steps by their size in s."""

    name: str
    calls: Mapping[str, Calls] = field(default_factory=lambda: {name: Calls() for name in CALLS})
    step_sizes: dict[float, int] = field(default_factory=dict)


class TimedSlave:
    """A slave as it is, but that its calls are counted."""

    def __init__(self, slave: Slave) -> None:
        self._slave = slave
        self.statistics = SlaveStatistics(slave.name)
        for name in CALLS:
            setattr(self, name, self._timed(name, getattr(slave, name)))

    def __getattr__(self, name: str) -> Any:
        return getattr(self._slave, name)

    def _timed(self, name: str, call: Callable[..., Any]) -> Callable[..., Any]:
        calls, sizes = self.statistics.calls[name], self.statistics.step_sizes

        def timed(*given: Any) -> Any:
            calls.count += 1
            if name == "step":
                size = float(f"{given[1]:.6g}")
                sizes[size] = sizes.get(size, 0) + 1
            began = time.perf_counter()
            try:
                return call(*given)
            except SlaveError:
                calls.refused += 1
                raise
            finally:
                calls.seconds += time.perf_counter() - began

        return timed
