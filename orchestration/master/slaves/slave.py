"""What the master asks of a slave, whatever stands behind it: an FMU, a process, a few lambdas."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Any, Literal, Protocol

if TYPE_CHECKING:
    from warmlink.orchestration.system.description import Capabilities, FmuVariable
    from warmlink.orchestration.system.model import Value

Names = tuple[str, ...]
_OfFmi = Literal["discard", "error", "fatal", "terminated", "ended"]
Status = _OfFmi | Literal["not finite", "not converged", "crash", "time limit", "interrupted"]


class SlaveError(Exception):
    """A slave could not do what was asked; the run ends there, and its results up to there are kept.

    The status is FMI's, or what stands in its place; the time in s is that of the communication point. A
    slave that asks to end the simulation has `ended` it, or `terminated` it if it complained of something.
    """

    def __init__(
        self, slave: str, status: Status, time: float, message: str, variable: str | None = None
    ) -> None:
        self.slave, self.status, self.time = slave, status, time
        self.message, self.variable = message, variable
        name = slave if variable is None else f"{slave}.{variable}"
        super().__init__(f"{name}: {status} at {time:.10g} s: {message}")

    def __reduce__(self) -> tuple[type[SlaveError], tuple[str, Status, float, str, str | None]]:
        # The default would hand the finished sentence to the constructor; errors cross processes.
        return type(self), (self.slave, self.status, self.time, self.message, self.variable)

    def because(self, more: str) -> SlaveError:
        """Give the same failure with more said of it."""
        return SlaveError(self.slave, self.status, self.time, f"{self.message}; {more}", self.variable)

    def asks_to_end_after(self, start_time: float) -> bool:
        """Tell whether the slave took steps from a time in s on and then only asked to end the simulation."""
        return self.status in ("terminated", "ended") and self.time > start_time


@dataclass(frozen=True)
class RunSpan:
    """What a slave is told of a run before it initializes.

    Parameters
    ----------
    start_time, stop_time : in s; None where the run may go on for ever
    tolerance : relative tolerance of what a slave solves inside; None leaves each slave its own
    goes_back : whether the master may restore a state of before the present communication point
    """

    start_time: float
    stop_time: float | None = None
    tolerance: float | None = None
    goes_back: bool = True


def nominal(variable: FmuVariable) -> float:
    """Give the size by which a variable's tolerances are scaled; 1 where the slave gives none."""
    return abs(variable.nominal) if variable.nominal else 1.0


class Slave(Protocol):
    """A co-simulation slave, from instantiated to terminated, which is called in the order of FMI.

    It has a name in the system, variables by name, capabilities beyond stepping, for each output the inputs
    that it depends on at once (direct feedthrough), inputs that take NaN to mean "no value" and outputs that
    give it in that sense, and remarks on its conduct. Every method raises `SlaveError` where the slave
    answers discard, error or fatal.
    """

    name: str
    variables: Mapping[str, FmuVariable]
    capabilities: Capabilities
    dependencies: Mapping[str, frozenset[str]]
    accepts_nan: frozenset[str]

    @property
    def remarks(self) -> Sequence[str]: ...  # noqa: D102

    def setup(self, experiment: RunSpan) -> None:
        """Set up the experiment; start values are set after that, before initialization mode."""

    def enter_initialization(self) -> None:
        """Enter initialization mode."""

    def exit_initialization(self) -> None:
        """Leave initialization mode; the slave is ready to step."""

    def get(self, names: Names) -> list[Value]:
        """Give the values of variables, in the order of `names`."""

    def set(self, names: Names, values: Sequence[Value]) -> None:
        """Set variables; pass the same `names` tuple again and again, it is prepared once."""

    def set_input_derivatives(self, names: Names, order: int, values: Sequence[float]) -> None:
        """Set time derivatives of Real inputs at the communication point, for the next step alone.

        Setting an input's value drops its derivatives.
        """

    def step(self, time: float, step_size: float) -> str | None:
        """Advance from `time` to `time + step_size`, both in s.

        Gives a sentence if the slave has done so and asks to end the simulation there, else None.
        """

    def state(self, reuse: object = None) -> object:
        """Copy the complete state, over an earlier copy where one is given; the caller frees it."""

    def restore(self, state: object) -> None:
        """Return to a copied state, which may be used again."""

    def free(self, state: object) -> None:
        """Release a copied state."""

    def serialize(self) -> bytes:
        """Give the present state as bytes that another instance of the same slave can take."""

    def deserialize(self, data: bytes) -> None:
        """Take a state that `serialize` gave."""

    def terminate(self) -> None:
        """End the simulation and release everything; harmless when called twice."""


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
        self._slave, self.statistics = slave, SlaveStatistics(slave.name)

    def __getattr__(self, name: str) -> Any:
        found = getattr(self._slave, name)
        return partial(self._timed, name, found) if name in CALLS else found

    def _timed(self, name: str, call: Callable[..., Any], *given: Any) -> Any:
        calls, sizes = self.statistics.calls[name], self.statistics.step_sizes
        calls.count += 1
        if name == "step":
            size = float(f"{given[1]:.6g}")
            sizes[size] = sizes.get(size, 0) + 1
        began = time.perf_counter()
        try:
            return call(*given)
        except SlaveError as fault:
            calls.refused += fault.status not in ("terminated", "ended")  # which refuses nothing
            raise
        finally:
            calls.seconds += time.perf_counter() - began
