"""Parts that are wired: the behaviour of a joined component."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial, reduce
from typing import Any, TypeVar

from warmlink.fmus.component import Clock, Component, Input, Record
from warmlink.fmus.component.arithmetic import Number, stack
from warmlink.fmus.component.dependencies import Dependencies
from warmlink.fmus.component.variables import Named
from warmlink.fmus.errors import InputError

Values = Mapping[str, Number]

Variable = TypeVar("Variable", bound=Named)


class Wiring:
    """The parts and how they are wired; the behaviour of the joined component."""

    def __init__(
        self, parts: dict[str, Component], wires: dict[str, str], found: Mapping[str, Dependencies]
    ) -> None:
        self.parts, self.wires = parts, wires
        self._running = self._schedule({key: each.outputs for key, each in found.items()})
        self._starting = self._schedule({key: each.initial for key, each in found.items()})

    def derive(self, p: Record) -> Values:
        """What the parameters settle, by name."""
        return {
            f"{key}.{name}": value
            for key, part in self.parts.items()
            if part.derive is not None
            for name, value in part.derive(part_of(p, key)).items()
        }

    def observe(self, x: Record, u: Record, p: Record, time: Number) -> Values:
        """Outputs by name."""
        signals = self._signals(x, u, p, time, time)
        return {
            f"{key}.{v.name}": signals.vector(key, v.scalar_names) if v.size else signals[f"{key}.{v.name}"]
            for key, part in self.parts.items()
            for v in part.outputs
        }

    def rates(
        self, x: Record, u: Record, p: Record, time: Number, since: Number | None = None
    ) -> dict[str, Number]:
        """Time derivatives of the continuous states by name."""
        signals = self._signals(x, u, p, time, time if since is None else since)
        found: dict[str, Number] = {}
        for key, part in self.parts.items():
            if part.rates is not None and part.states:
                given = part.rates(part_of(x, key), signals.inputs(key), part_of(p, key), time)
                found |= {f"{key}.{name}": value for name, value in given.items()}
        return found

    def begin(self, u: Record, p: Record) -> dict[str, Number]:
        """Start values of the states by name, each part's from what the others begin with."""
        signals = _Signals(self, partial(self._begun, p), u)
        signals.follow(self._starting)
        found: dict[str, Number] = {}
        for key, part in self.parts.items():
            if part.states:
                states = part.started(signals.inputs(key), part_of(p, key))
                found |= {f"{key}.{name}": value for name, value in states.items()}
        return found

    def inputs(self, key: str, x: Record, u: Record, p: Record, time: Number) -> Number:
        """Flat inputs of a part during the run."""
        return self._signals(x, u, p, time, time).flat_inputs(key)

    @property
    def starting(self) -> list[str]:
        """Parts with states in an order in which they may begin; some come more than once.

        In the first round their outputs become right, in the second the states that no output shows.
        """
        return [key for key in (*(key for key, _ in self._starting), *self.parts) if self.parts[key].states]

    def _signals(self, x: Record, u: Record, p: Record, time: Number, since: Number) -> _Signals:
        signals = _Signals(self, partial(self._observed, x, p, time, since), u)
        signals.follow(self._running)
        return signals

    def clocks(self) -> Iterable[Clock]:
        """One for each clock of a part, in the order of the parts."""
        for key, part in self.parts.items():
            for clock in part.clocks:
                states = tuple(prefixed(key, state) for state in clock.states)
                yield Clock(f"{key}.{clock.sample_time}", states, partial(self._updated, key, clock))

    def _updated(
        self, key: str, clock: Clock, x: Record, u: Record, p: Record, time: Number, step: Number
    ) -> Values:
        signals = self._signals(x, u, p, time, time)
        given = clock.update(part_of(x, key), signals.inputs(key), part_of(p, key), time, step)
        return {f"{key}.{name}": value for name, value in given.items()}

    def _observed(self, x: Record, p: Record, time: Number, since: Number, key: str, u: Record) -> Values:
        """Outputs of one part; those that jump are taken at `since`."""
        part = self.parts[key]
        states = part_of(x, key) if part.states else None
        found = dict(part.observe(states, u, part_of(p, key), time))
        if since is not time:
            before = part.observe(states, u, part_of(p, key), since)
            found |= {output.name: before[output.name] for output in part.outputs if output.discrete}
        return found

    def _begun(self, p: Record, key: str, u: Record) -> Values:
        part = self.parts[key]
        begun = part.x.read(part.x.flat(part.started(u, part_of(p, key)))) if part.states else None
        return part.observe(begun, u, part_of(p, key), 0.0)

    def _schedule(self, direct: Mapping[str, Mapping[str, Sequence[str]]]) -> list[tuple[str, list[str]]]:
        """Which parts to evaluate in which order, and which of their outputs are right by then.

        A part comes more than once where some of its outputs feed others that its remaining ones wait for,
        as the link's temperature feeds the motor, whose heat flow the link waits for.
        """
        needs = {
            f"{key}.{output}": {self.wires[f"{key}.{n}"] for n in known if f"{key}.{n}" in self.wires}
            for key, of in direct.items()
            for output, known in of.items()
        }
        steps: list[tuple[str, list[str]]] = []
        known: set[str] = set()
        while len(known) < len(needs):
            before = len(known)
            for key, part in self.parts.items():
                names = [n for n in part.y.names if f"{key}.{n}" not in known]
                ready = [n for n in names if needs[f"{key}.{n}"] <= known]
                if ready:
                    steps.append((key, ready))
                    known |= {f"{key}.{n}" for n in ready}
            if len(known) == before:
                raise InputError(_loop({name: on - known for name, on in needs.items() if name not in known}))
        return steps


class _Signals:
    """Outputs of the parts while they become known, and the inputs that follow from them."""

    def __init__(self, joint: Wiring, observe: Callable[[str, Record], Values], free: Record) -> None:
        self._joint, self._observe, self._free = joint, observe, free
        self._values: dict[str, Number] = {}

    def __getitem__(self, name: str) -> Number:
        return self._values[name]

    def vector(self, key: str, names: Sequence[str]) -> Number:
        """Several signals of one part as a vector."""
        return stack(*(self._values[f"{key}.{name}"] for name in names))

    def follow(self, steps: Sequence[tuple[str, list[str]]]) -> None:
        """Evaluate the parts in an order."""
        for key, ready in steps:
            part = self._joint.parts[key]
            given = self._observe(key, self.inputs(key))
            for output in part.outputs:
                for i, name in enumerate(output.scalar_names):
                    if name in ready:
                        value = given[output.name]
                        self._values[f"{key}.{name}"] = value if output.size is None else value[i]

    def inputs(self, key: str) -> Record:
        """Inputs of a part; those not known yet stand at their start value."""
        return self._joint.parts[key].u.record(self._inputs(key))

    def flat_inputs(self, key: str) -> Number:
        """The same as a flat vector, shape (u.size,)."""
        return self._joint.parts[key].u.flat(self._inputs(key))

    def _inputs(self, key: str) -> dict[str, Number]:
        return {v.name: self._input(key, v) for v in self._joint.parts[key].inputs}

    def _input(self, key: str, variable: Input) -> Number:
        wires = self._joint.wires
        names = [f"{key}.{name}" for name in variable.scalar_names]
        if not any(name in wires for name in names):
            return getattr(part_of(self._free, key), variable.name)
        values = [
            self._values.get(wires[full], variable.start)
            if full in wires
            else getattr(part_of(self._free, key), name)
            for full, name in zip(names, variable.scalar_names, strict=True)
        ]
        return values[0] if variable.size is None else stack(*values)


def prefixed(key: str, variable: Variable) -> Variable:
    """A part's variable as one of the whole, `instance.variable`."""
    return replace(variable, name=f"{key}.{variable.name}")


def part_of(record: Record, key: str) -> Any:
    """What a record holds of one part."""
    return reduce(getattr, key.split("."), record)


def _loop(waiting: Mapping[str, set[str]]) -> str:
    """Sentence that names a loop among outputs, each of which waits for others."""
    path = [next(iter(waiting))]
    while path[-1] not in path[:-1]:
        path.append(next(iter(waiting[path[-1]])))
    loop = path[path.index(path[-1]) :]
    return (
        f"{' <- '.join(loop)}: each of these signals depends on the next at once (an algebraic loop); "
        "put something with a memory between them"
    )
