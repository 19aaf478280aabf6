"""Joining components by wires into one component.

States, parameters and outputs of the parts lie side by side under `instance.variable`; inputs that a wire
feeds are gone, the others stay. Parts that are joined themselves are taken apart first, so that nesting
changes names and nothing else.

Signals that jump (outputs declared discrete) are held over each micro step of the continuous states, as a
master holds them from one communication point to the next. Sampled parts are sampled one after another in
the order of stepping, each with the newest values, as a Gauss-Seidel master does.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial, reduce
from typing import Any, TypeVar

from warmlink.fmus.arithmetic import Number, stack
from warmlink.fmus.errors import InputError
from warmlink.fmus.packaging.component import (
    FIELD,
    Check,
    Clock,
    Component,
    Derived,
    Input,
    Output,
    Parameter,
    Record,
    State,
)
from warmlink.fmus.packaging.dependencies import Dependencies, dependencies
from warmlink.fmus.packaging.order import stepping_order

Wire = tuple[str, str]
"""Source and target of a connection between scalars, as `("motor.heat_flow", "link.heat_flow")`."""

Values = Mapping[str, Number]

Named = TypeVar("Named", Input, Parameter, Output, State, Derived)


def join(
    name: str, parts: Mapping[str, Component], wires: Iterable[Wire] = (), description: str = ""
) -> Component:
    """Join components into one.

    Parameters
    ----------
    name : name of the joined component, as `WarmupCell`
    parts : components by instance name, each used as often as wanted
    wires : from outputs to inputs
    description : one line; made up from the parts where there is none

    Returns
    -------
    Component
        Its checks, bounds, units and descriptions are the parts'.

    Raises
    ------
    InputError
        A wire's end does not exist, an input is fed twice, units differ, or wires close a loop in which
        each signal depends on the next at once (an algebraic loop).
    """
    flat, inner = _taken_apart(parts)
    fed = _checked(name, flat, [*inner, *wires])
    each = {id(part): part for part in flat.values()}
    known = {number: dependencies(part) for number, part in each.items()}
    found = {key: known[id(part)] for key, part in flat.items()}
    # Continuous states first, then the sampled ones in the order of sampling.
    order = [key for key, part in flat.items() if not part.sampled] + _sampling_order(flat, fed)
    joint = _Joint({key: flat[key] for key in order}, fed, found)
    held = joint.parts.items()
    continuous = [part.micro_step for _, part in held if part.rates is not None]
    return Component(
        name=name,
        description=description or f"{', '.join(f'{key} ({part.name})' for key, part in flat.items())}",
        inputs=tuple(_inputs(flat, fed)),
        parameters=tuple(_named(key, v) for key, part in flat.items() for v in part.parameters),
        derived=tuple(_named(key, v) for key, part in flat.items() for v in part.derived),
        states=tuple(_named(key, v) for key, part in held for v in part.states),
        outputs=tuple(_named(key, v) for key, part in flat.items() for v in part.outputs),
        rates=joint.rates if continuous else None,
        observe=joint.observe,
        derive=joint.derive if any(part.derived for part in flat.values()) else None,
        begin=joint.begin,
        clocks=tuple(joint.clocks()),
        joint=joint,
        checks=tuple(_check(key, check) for key, part in flat.items() for check in part.checks),
        micro_step=min(continuous, default=1.0),
        default_stop_time=max(part.default_stop_time for part in flat.values()),
        default_step_size=min(part.default_step_size for part in flat.values()),
    )


class _Joint:
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
            for name, value in part.derive(_of(p, key)).items()
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
                given = part.rates(_of(x, key), signals.inputs(key), _of(p, key), time)
                found |= {f"{key}.{name}": value for name, value in given.items()}
        return found

    def begin(self, u: Record, p: Record) -> dict[str, Number]:
        """Start values of the states by name, each part's from what the others begin with."""
        signals = _Signals(self, partial(self._begun, p), u)
        signals.follow(self._starting)
        found: dict[str, Number] = {}
        for key, part in self.parts.items():
            if part.states:
                states = part.started(signals.inputs(key), _of(p, key))
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
                states = tuple(_named(key, state) for state in clock.states)
                yield Clock(f"{key}.{clock.sample_time}", states, partial(self._updated, key, clock))

    def _updated(
        self, key: str, clock: Clock, x: Record, u: Record, p: Record, time: Number, step: Number
    ) -> Values:
        signals = self._signals(x, u, p, time, time)
        given = clock.update(_of(x, key), signals.inputs(key), _of(p, key), time, step)
        return {f"{key}.{name}": value for name, value in given.items()}

    def _observed(self, x: Record, p: Record, time: Number, since: Number, key: str, u: Record) -> Values:
        """Outputs of one part; those that jump are taken at `since`."""
        part = self.parts[key]
        states = _of(x, key) if part.states else None
        found = dict(part.observe(states, u, _of(p, key), time))
        if since is not time:
            before = part.observe(states, u, _of(p, key), since)
            found |= {output.name: before[output.name] for output in part.outputs if output.discrete}
        return found

    def _begun(self, p: Record, key: str, u: Record) -> Values:
        part = self.parts[key]
        begun = part.x.read(part.x.flat(part.started(u, _of(p, key)))) if part.states else None
        return part.observe(begun, u, _of(p, key), 0.0)

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

    def __init__(self, joint: _Joint, observe: Callable[[str, Record], Values], free: Record) -> None:
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
            return getattr(_of(self._free, key), variable.name)
        values = [
            self._values.get(wires[full], variable.start)
            if full in wires
            else getattr(_of(self._free, key), name)
            for full, name in zip(names, variable.scalar_names, strict=True)
        ]
        return values[0] if variable.size is None else stack(*values)


def _taken_apart(parts: Mapping[str, Component]) -> tuple[dict[str, Component], list[Wire]]:
    """Parts that are not joined themselves, by full name, and the wires within those that were."""
    flat: dict[str, Component] = {}
    wires: list[Wire] = []
    for key, part in parts.items():
        if part.joint is None:
            flat[key] = part
            continue
        flat |= {f"{key}.{inner}": component for inner, component in part.joint.parts.items()}
        wires += [(f"{key}.{source}", f"{key}.{target}") for target, source in part.joint.wires.items()]
    return flat, wires


def _checked(name: str, parts: Mapping[str, Component], wires: Iterable[Wire]) -> dict[str, str]:
    """Source by target of each wire, once both ends are known to fit."""
    ends = {f"{key}.{scalar.name}": scalar for key, part in parts.items() for scalar in part.scalars()}
    fed: dict[str, str] = {}
    for source, target in wires:
        where = f"{name}, wire {source} -> {target}"
        for end, kind in ((source, Output), (target, Input)):
            if end not in ends or not isinstance(ends[end].variable, kind):
                raise InputError(f"{where}: {end} is no {kind.__name__.lower()} of its parts")
        if target in fed:
            raise InputError(f"{where}: {target} is fed by {fed[target]} already; leave one out")
        units = [ends[end].variable.unit for end in (source, target)]
        if units[0] != units[1]:
            raise InputError(f"{where}: {units[0]} does not fit {units[1]}; connect equal units")
        fed[target] = source
    return fed


def _sampling_order(parts: Mapping[str, Component], wires: Mapping[str, str]) -> list[str]:
    """Instances that sample, in the order of data flow, be it through parts that have no memory."""
    sources: dict[str, set[str]] = {key: set() for key in parts}
    for target, source in wires.items():
        sources[target.rpartition(".")[0]].add(source.rpartition(".")[0])

    def sampled_before(key: str, seen: set[str]) -> set[str]:
        found: set[str] = set()
        for giver in sources[key] - seen:
            seen.add(giver)
            if parts[giver].sampled:
                found.add(giver)
            elif not parts[giver].states:
                found |= sampled_before(giver, seen)
        return found

    keys = [key for key, part in parts.items() if part.sampled]
    before = [{keys.index(giver) for giver in sampled_before(key, {key})} for key in keys]
    return [keys[i] for i in stepping_order([set() for _ in keys], before)]


def _inputs(parts: Mapping[str, Component], wires: Mapping[str, str]) -> Iterable[Input]:
    """Inputs that no wire feeds; of a vector that some wires feed, the elements left over."""
    for key, part in parts.items():
        for variable in part.inputs:
            free = [name for name in variable.scalar_names if f"{key}.{name}" not in wires]
            if len(free) == variable.count:
                yield _named(key, variable)
            else:
                yield from (replace(variable, name=f"{key}.{name}", size=None) for name in free)


def _named(key: str, variable: Named) -> Named:
    return replace(variable, name=f"{key}.{variable.name}")


def _check(key: str, check: Check) -> Check:
    """A part's check as one of the whole: the names in its sentence are the whole's."""
    sentence = f"{key}." + FIELD.sub(lambda field: f"{{{key}.{field[1]}}}", check.sentence)
    return Check(lambda p: check.margin(_of(p, key)), sentence)


def _of(record: Record, key: str) -> Any:
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
