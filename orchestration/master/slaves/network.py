"""Slaves and the connections between them, with the values last exchanged."""

from __future__ import annotations

import math
import os
from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.orchestration.master.slaves.slave import Names, Slave, SlaveError
from warmlink.orchestration.system.model import INTEGER_RANGES, Connection, Value

if TYPE_CHECKING:
    from warmlink.orchestration.system.description import FmuVariable


@dataclass(frozen=True)
class Wire:
    """Where an input takes its value from: `factor * outputs[slave][position] + offset`.

    Its `limits` are the least and largest value that it holds, where the output may have others; some
    `values` that are no Reals become others.
    """

    slave: int
    position: int
    factor: float
    offset: float
    real: bool
    limits: tuple[int, int] | None = None
    values: Mapping[Value, Value] = field(default_factory=dict)

    def convert(self, value: Value) -> Value:
        """Give the input's value for an output's value."""
        if not self.real:
            return self.values.get(value, value) if self.values else value
        # A plain wire passes the very same bits, -0.0 included.
        if self.factor == 1.0 and self.offset == 0.0:
            return float(value)
        return self.factor * float(value) + self.offset


@dataclass(frozen=True)
class SlaveStates:
    """Everything that a rollback of some slaves needs."""

    members: tuple[int, ...]
    states: tuple[object, ...]
    outputs: tuple[list[Value], ...]
    inputs: tuple[list[Value], ...]


class Network:
    """The slaves by index, what is read from each, what is written to each, and the values.

    Attributes
    ----------
    reads, writes : for each slave the outputs read from it and the inputs written to it
    outputs, inputs : for each slave the values last read and last written, in those orders
    wires : for each slave the sources of its inputs, as `writes`
    checked : for each slave the positions of its outputs that must be finite
    ends : sentences of those slaves that have stepped and ask to end the simulation there
    """

    def __init__(
        self,
        slaves: Sequence[Slave],
        connections: Sequence[Connection],
        watched: Collection[str] = (),
        process: int | None = None,
    ) -> None:
        """Lay the wires; InputError where a connection's end is unknown or an input has two sources.

        The outputs `watched`, as `slave.variable`, are read at every communication point too. A copy of the
        `process` that the slaves were made in (default: this one), made by an FMU that forks, ends itself.
        """
        self.slaves = list(slaves)
        self.index = {slave.name: k for k, slave in enumerate(self.slaves)}
        for k, slave in enumerate(self.slaves):
            if self.index[slave.name] != k:
                raise InputError(f"{slave.name}: two slaves have this name; give each its own")
        reads: list[dict[str, int]] = [{} for _ in self.slaves]
        laid: list[dict[str, Wire]] = [{} for _ in self.slaves]
        for link in connections:
            source, target = (self._end(link, end) for end in (0, 1))
            position = reads[source].setdefault(link.source_variable, len(reads[source]))
            if link.target_variable in laid[target]:
                told = "the input has another source already; an input takes one"
                raise InputError(f"connection {link.source} -> {link.target}: {told}")
            taking = self.slaves[target].variables[link.target_variable]
            limits = _limits(self.slaves[source].variables[link.source_variable], taking)
            real, values = taking.kind == "Real", dict(link.values)
            laid[target][link.target_variable] = Wire(
                source, position, link.factor, link.offset, real, limits, values
            )
        for component, variable in map(self.locate, watched):
            reads[component].setdefault(variable, len(reads[component]))
        self.reads: list[Names] = [tuple(names) for names in reads]
        self.writes: list[Names] = [tuple(wires) for wires in laid]
        self.wires = [list(wires.values()) for wires in laid]
        # Where nothing is converted, places in `outputs` suffice.
        self._bare = [
            [(wire.slave, wire.position) for wire in wires] if all(map(self._is_bare, wires)) else None
            for wires in self.wires
        ]
        self.outputs: list[list[Value]] = [[] for _ in self.slaves]
        self.inputs: list[list[Value]] = [[] for _ in self.slaves]
        self.checked = [self._finite_positions(k) for k in range(len(self.slaves))]
        self._process = os.getpid() if process is None else process
        self.time = 0.0
        self.steps = self.sweeps = 0
        self.rejected = Counter[str]()  # by the slave that was in the way
        self.ends: dict[int, str] = {}
        self._copies: list[tuple[int, object]] = []

    def locate(self, name: str) -> tuple[int, str]:
        """Give slave index and variable of a full name; InputError where no slave has such a variable."""
        for k, slave in enumerate(self.slaves):
            variable = name.removeprefix(f"{slave.name}.")
            if variable != name and variable in slave.variables:
                return k, variable
        known = (f"{slave.name}.{variable}" for slave in self.slaves for variable in slave.variables)
        raise InputError(f"{name}: no slave has such a variable; {instead(name, known)}")

    def _end(self, link: Connection, end: int) -> int:
        """Give the slave at one end of a connection, 0 or 1."""
        component, variable = link.ends[end]
        if component in self.index and variable in self.slaves[self.index[component]].variables:
            return self.index[component]
        told = f"its {('source', 'target')[end]} {component}.{variable} does not exist; correct the name"
        raise InputError(f"connection {link.source} -> {link.target}: {told}")

    def source(self, wire: Wire) -> FmuVariable:
        """Give the output that a wire begins at."""
        return self.slaves[wire.slave].variables[self.reads[wire.slave][wire.position]]

    def _is_bare(self, wire: Wire) -> bool:
        plain = (wire.factor, wire.offset, wire.limits, wire.values) == (1.0, 0.0, None, {})
        return plain and (self.source(wire).kind == "Real" or not wire.real)

    def _finite_positions(self, k: int) -> tuple[int, ...]:
        """Give the positions of the Real outputs of a slave that must be finite.

        An output may be NaN where it says so itself or where everything it feeds accepts that.
        """
        slave = self.slaves[k]
        takers: dict[int, list[bool]] = {}
        for taker, names, wires in zip(self.slaves, self.writes, self.wires, strict=True):
            for name, wire in zip(names, wires, strict=True):
                if wire.slave == k:
                    takers.setdefault(wire.position, []).append(name in taker.accepts_nan)
        return tuple(
            position
            for position, name in enumerate(self.reads[k])
            if slave.variables[name].kind == "Real"
            and name not in slave.accepts_nan
            and not all(takers.get(position, [False]))
        )

    def read(self, k: int) -> None:
        """Read a slave's outputs; SlaveError where one is NaN or infinite and must not be."""
        names = self.reads[k]
        if names:
            self.outputs[k] = values = self.slaves[k].get(names)
            self.check(k, values)

    def check(self, k: int, values: Sequence[Any]) -> None:
        """Refuse values of a slave's outputs that are not finite."""
        checked = self.checked[k]
        # One sum instead of many questions; where it overflows, they are asked after all.
        finite = values if len(checked) == len(values) else [values[p] for p in checked]
        for position in () if math.isfinite(sum(finite)) else checked:
            if not math.isfinite(values[position]):
                told = f"the output is {values[position]}; no input that it feeds accepts that"
                variable = self.reads[k][position]
                raise SlaveError(self.slaves[k].name, "not finite", self.time, told, variable)

    def gather(self, k: int) -> list[Value]:
        """Give the values that a slave's inputs should have, from the outputs last read."""
        outputs, bare = self.outputs, self._bare[k]
        if bare is not None:
            return [outputs[slave][position] for slave, position in bare]
        return [self.arriving(k, position) for position in range(len(self.wires[k]))]

    def arriving(self, k: int, position: int) -> Value:
        """Give the value that one of a slave's inputs should have, from the outputs last read.

        SlaveError where it cannot hold that: FMI would pass the last bits, another number.
        """
        wire = self.wires[k][position]
        value = wire.convert(self.outputs[wire.slave][wire.position])
        if wire.limits and not wire.limits[0] <= int(value) <= wire.limits[1]:
            slave, name = self.slaves[k], self.writes[k][position]
            least, most = wire.limits
            told = f"{value} is sent to it, but {slave.variables[name].type} holds {least} to {most} alone"
            raise SlaveError(slave.name, "error", self.time, told, name)
        return value

    def write(self, k: int) -> None:
        """Set a slave's inputs from the outputs last read."""
        if self.writes[k]:
            self.put(k, self.gather(k))

    def put(self, k: int, values: list[Value]) -> None:
        """Set a slave's connected inputs to given values."""
        self.inputs[k] = values
        self.slaves[k].set(self.writes[k], values)

    def step(self, k: int, time: float, step_size: float) -> None:
        """Advance one slave; its outputs are then those of `time + step_size`."""
        self.time = time
        ends = self.slaves[k].step(time, step_size)
        self.end_copies()
        if ends is not None:
            self.ends[k] = ends
        elif self.ends:  # that of a step which is repeated
            self.ends.pop(k, None)
        self.time = time + step_size
        self.steps += 1

    def end(self) -> SlaveError | None:
        """Give the end of the simulation at the present time, if a slave asks for it."""
        for k, told in self.ends.items():
            return SlaveError(self.slaves[k].name, "ended", self.time, told)
        return None

    def end_copies(self) -> None:
        """End this process if it is a copy that an FMU made; the other one goes on."""
        if os.getpid() != self._process:
            os._exit(0)

    def snapshot(self, members: Sequence[int] | None = None, reuse: SlaveStates | None = None) -> SlaveStates:
        """Copy the states of some slaves (default: all) and all values, over a snapshot given for reuse."""
        chosen = tuple(range(len(self.slaves)) if members is None else members)
        old = (None,) * len(chosen) if reuse is None else reuse.states
        states = tuple(self.slaves[k].state(state) for k, state in zip(chosen, old, strict=True))
        if reuse is None:
            self._copies += zip(chosen, states, strict=True)
        outputs, inputs = (tuple(list(each) for each in held) for held in (self.outputs, self.inputs))
        return SlaveStates(chosen, states, outputs, inputs)

    def rewind(self, snapshot: SlaveStates) -> None:
        """Return to a snapshot, which may be used again."""
        for k, state in zip(snapshot.members, snapshot.states, strict=True):
            self.slaves[k].restore(state)
        self.ends.clear()
        self.outputs = [list(values) for values in snapshot.outputs]
        self.inputs = [list(values) for values in snapshot.inputs]

    def release(self) -> None:
        """Free all copied states; slaves that can no longer do so do not keep the others from it."""
        while self._copies:
            k, state = self._copies.pop()
            with suppress(SlaveError):
                self.slaves[k].free(state)

    def unable_to_restore(self) -> tuple[str, ...]:
        """Name the slaves that cannot be rolled back."""
        return tuple(s.name for s in self.slaves if not s.capabilities.get_set_state)

    def of_one_step(self) -> tuple[str, ...]:
        """Name the slaves that cannot change their step."""
        return tuple(s.name for s in self.slaves if not s.capabilities.variable_step)


def _limits(giving: FmuVariable, taking: FmuVariable) -> tuple[int, int] | None:
    """Give what an input can hold where an output may have other values; None if it has none."""
    if not {giving.type, taking.type} <= INTEGER_RANGES.keys():
        return None
    (least, most), held = INTEGER_RANGES[giving.type], INTEGER_RANGES[taking.type]
    return None if held[0] <= least and most <= held[1] else held
