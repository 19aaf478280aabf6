"""Joining components by wires into one component.

States, parameters and outputs of the parts lie side by side under `instance.variable`; inputs that a wire
feeds are gone, the others stay. Parts that are joined themselves are taken apart first, so that nesting
changes the names and order of variables, and nothing that is computed.

Signals that jump (outputs declared discrete) are held over each micro step of the continuous states, as a
master holds them from one communication point to the next. Sampled parts are sampled one after another in
the order of stepping, each with the newest values, as a Gauss-Seidel master does.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from functools import partial, reduce
from types import SimpleNamespace
from typing import Any, TypeVar

from warmlink.fmus.component import FIELD, Check, Clock, Component, Input, Output, Record, Terminal, Values
from warmlink.fmus.component.arithmetic import Number, stack
from warmlink.fmus.component.dependencies import Orders, Schedule
from warmlink.fmus.component.table import Played
from warmlink.fmus.component.variables import Named
from warmlink.fmus.errors import InputError

Wire = tuple[str, str]
"""Source and target of a connection between scalars, as `("motor.heat_flow", "link.heat_flow")`."""

Observe = Callable[[str, Record], Values]

Variable = TypeVar("Variable", bound=Named)


def join(
    name: str, parts: Mapping[str, Component], wires: Iterable[Wire] = (), description: str = ""
) -> Component:
    """Join components into one.

    Checks, bounds, units and descriptions are the parts'. InputError: there is no part, two have one name, a
    wire's end does not exist, an input is fed twice, units differ, or wires close a loop in which each signal
    depends on the next at once.

    Parameters
    ----------
    name : name of the joined component, as `WarmupCell`
    parts : components by instance name, each used as often as wanted
    wires : from outputs to inputs
    description : one line; made up from the parts if there is none
    """
    flat: dict[str, Component] = {}
    every = list(wires)
    for key, part in parts.items():
        inside = {key: part}
        if part.joint is not None:
            inside = {f"{key}.{inner}": component for inner, component in part.joint.parts.items()}
            every += [(f"{key}.{source}", f"{key}.{target}") for target, source in part.joint.wires.items()]
        if twice := inside.keys() & flat.keys():
            raise InputError(f"{name}: two parts are called {min(twice)}; call one of them otherwise")
        flat |= inside
    if not flat:
        raise InputError(f"{name}: has no parts; give one or more to join")
    source_of = _validated(name, flat, every)
    joint = Joint(flat, source_of)
    continuous = [part.micro_step for part in parts.values() if part.rates is not None]

    def together(kind: str, parts: Mapping[str, Component] = flat) -> tuple[Any, ...]:
        """Variables of a kind of all parts, side by side."""
        return tuple(_prefixed(key, v) for key, part in parts.items() for v in getattr(part, kind))

    return Component(
        name=name,
        description=description or f"{', '.join(f'{key} ({part.name})' for key, part in flat.items())}",
        inputs=tuple(_free_inputs(flat, source_of)),
        parameters=together("parameters"),
        derived=together("derived"),
        states=together("states", joint.parts),
        outputs=together("outputs"),
        rates=joint.rates if continuous else None,
        observe=joint.observe,
        derive=joint.derive if any(part.derived for part in flat.values()) else None,
        clocks=tuple(joint.clocks()),
        joint=joint,
        terminals=tuple(_terminals(flat, source_of)),
        tables=tuple(_prefixed_table(key, each) for key, part in flat.items() for each in part.tables),
        checks=tuple(_prefixed_check(key, check) for key, part in flat.items() for check in part.checks),
        micro_step=min(continuous, default=1.0),
        default_stop_time=max(part.default_stop_time for part in parts.values()),
        default_step_size=min(part.default_step_size for part in parts.values()),
    )


class Joint:
    """The parts of a joined component, none of them joined itself; how they are wired; its behaviour.

    The wires give the source of each input that one feeds, both as `instance.variable`.
    """

    def __init__(self, parts: dict[str, Component], wires: dict[str, str]) -> None:
        self._orders = Orders.of(parts, wires)
        # Continuous states first, then the sampled ones in the order of sampling.
        self.parts, self.wires = {key: parts[key] for key in self._orders.parts}, wires
        self._moving = self._before(key for key, part in parts.items() if part.rates is not None)
        self._sampling = {key: self._before([key]) for key, part in parts.items() if part.sampled}
        # Looked up once, as the equations of an arm are gone through thousands of times.
        self._shown = {
            key: [
                (output.name, None if output.size is None else i, name, f"{key}.{name}")
                for output in part.outputs
                for i, name in enumerate(output.scalar_names)
            ]
            for key, part in parts.items()
        }
        self._fed = {
            key: [
                (each, [(name, wires.get(f"{key}.{name}")) for name in each.scalar_names])
                for each in part.inputs
            ]
            for key, part in parts.items()
        }

    @property
    def starting(self) -> list[str]:
        """Parts with states in an order in which they may begin; some come more than once.

        In the first round their outputs become right, in the second the states that no output shows.
        """
        begun = (key for key, _ in self._orders.starting)
        return [key for key in (*begun, *self.parts) if self.parts[key].states]

    def derive(self, p: Record) -> Values:
        """What the parameters settle, by name."""
        return _named({k: part.derive(part_of(p, k)) for k, part in self.parts.items() if part.derive})

    def begin(self, u: Record, p: Record, time: Number) -> Values:
        """Start values of the states by name, each part's from what the others begin with."""

        def begun(key: str, inputs: Record) -> Values:
            part, own = self.parts[key], part_of(p, key)
            states = part.x.read(part.x.flat(part.started(inputs, own))) if part.states else None
            return part.observe(states, inputs, own, time)

        signals = self._followed(self._orders.starting, begun, u)
        stateful = [
            (key, part, self._record(key, signals, u)) for key, part in self.parts.items() if part.states
        ]
        return _named({key: part.started(inputs, part_of(p, key)) for key, part, inputs in stateful})

    def rates(self, x: Record, u: Record, p: Record, time: Number, held_at: Number | None = None) -> Values:
        """Time derivatives of the continuous states by name; `held_at` as for `Component.rates_of`."""
        signals, found = self._signals(self._moving, x, u, p, time, held_at), {}
        for key, part in self.parts.items():
            if part.rates is not None and part.states:
                inputs = self._record(key, signals, u)
                found[key] = part.rates(part_of(x, key), inputs, part_of(p, key), time)
        return _named(found)

    def observe(self, x: Record, u: Record, p: Record, time: Number) -> Values:
        """Outputs by name."""
        signals = self._signals(self._orders.running, x, u, p, time)
        found = {}
        for key, part in self.parts.items():
            for output in part.outputs:
                values = [signals[f"{key}.{name}"] for name in output.scalar_names]
                found[f"{key}.{output.name}"] = stack(*values) if output.size else values[0]
        return found

    def inputs(self, key: str, x: Record, u: Record, p: Record, time: Number) -> Number:
        """Flat inputs of a part during the run."""
        return self.parts[key].u.flat(
            self._inputs_of(key, self._signals(self._before([key]), x, u, p, time), u)
        )

    def clocks(self) -> Iterable[Clock]:
        """One for each clock of a part, in the order of the parts."""
        for key, part in self.parts.items():
            for clock in part.clocks:
                states = tuple(_prefixed(key, state) for state in clock.states)
                yield Clock(f"{key}.{clock.sample_time}", states, partial(self._updated, key, clock))

    def _updated(
        self, key: str, clock: Clock, x: Record, u: Record, p: Record, time: Number, step: Number
    ) -> Values:
        inputs = self._record(key, self._signals(self._sampling[key], x, u, p, time), u)
        return _named({key: clock.update(part_of(x, key), inputs, part_of(p, key), time, step)})

    def _before(self, keys: Iterable[str]) -> Schedule:
        """What is evaluated, in which order, for the inputs of some parts."""
        inputs = (f"{key}.{name}" for key in keys for name in self.parts[key].u.names)
        return self._orders.before(inputs, self.wires)

    def _signals(
        self,
        schedule: Schedule,
        x: Record,
        u: Record,
        p: Record,
        time: Number,
        held_at: Number | None = None,
    ) -> dict[str, Number]:
        """Scalar outputs of the parts by name; discrete ones are evaluated at `held_at`."""

        def observed(key: str, inputs: Record) -> Values:
            part = self.parts[key]
            states = part_of(x, key) if part.states else None
            found = dict(part.observe(states, inputs, part_of(p, key), time))
            if held_at is not None and held_at is not time:
                before = part.observe(states, inputs, part_of(p, key), held_at)
                found |= {output.name: before[output.name] for output in part.outputs if output.discrete}
            return found

        return self._followed(schedule, observed, u)

    def _followed(self, schedule: Schedule, observe: Observe, free: Record) -> dict[str, Number]:
        """Scalar outputs of the parts by name, found part after part."""
        signals: dict[str, Number] = {}
        for key, ready in schedule:
            given = observe(key, self._record(key, signals, free))
            for output, element, name, full in self._shown[key]:
                if name in ready:
                    signals[full] = given[output] if element is None else given[output][element]
        return signals

    def _record(self, key: str, signals: Values, free: Record) -> Record:
        return self.parts[key].u.record(self._inputs_of(key, signals, free))

    def _inputs_of(self, key: str, signals: Values, free: Record) -> Values:
        """Inputs of a part by name; those not known yet stand at their start value."""
        found: dict[str, Number] = {}
        own = part_of(free, key)
        for variable, ends in self._fed[key]:
            if not any(wire for _, wire in ends):
                found[variable.name] = getattr(own, variable.name)
                continue
            values = [
                getattr(own, name) if wire is None else signals.get(wire, variable.start)
                for name, wire in ends
            ]
            found[variable.name] = values[0] if variable.size is None else stack(*values)
        return found


def part_of(record: Record, key: str) -> Any:
    """What a record holds of one part: nothing of one that has no such variables."""
    return reduce(lambda held, name: getattr(held, name, _NOTHING), key.split("."), record)


_NOTHING = SimpleNamespace()


def _named(by_part: Mapping[str, Values]) -> dict[str, Number]:
    """Values by their full names."""
    return {f"{key}.{name}": value for key, values in by_part.items() for name, value in values.items()}


def _prefixed(key: str, variable: Variable) -> Variable:
    """A part's variable as one of the whole, `instance.variable`."""
    return replace(variable, name=f"{key}.{variable.name}")


def _validated(name: str, parts: Mapping[str, Component], wires: Iterable[Wire]) -> dict[str, str]:
    """Source by target of each wire, once both ends are known to fit."""
    ends = {f"{key}.{scalar.name}": scalar for key, part in parts.items() for scalar in part.scalars()}
    fed: dict[str, str] = {}
    for source, target in wires:
        where = f"{name}, wire {source} -> {target}"
        for end, kind in ((source, Output), (target, Input)):
            if end not in ends or not isinstance(ends[end].variable, kind):
                if f"{end}[1]" in ends:
                    raise InputError(f"{where}: {end} is a vector; connect its elements, as {end}[1]")
                raise InputError(f"{where}: {end} is no {kind.__name__.lower()} of its parts")
        if target in fed:
            raise InputError(f"{where}: {target} is fed by {fed[target]} already; leave one out")
        units = [ends[end].variable.unit for end in (source, target)]
        if units[0] != units[1]:
            raise InputError(f"{where}: {units[0]} does not fit {units[1]}; connect equal units")
        fed[target] = source
    return fed


def _free_inputs(parts: Mapping[str, Component], wires: Mapping[str, str]) -> Iterable[Input]:
    """Inputs that no wire feeds; of a vector that some wires feed, the elements left over."""
    for key, part in parts.items():
        for variable in part.inputs:
            free = [name for name in variable.scalar_names if f"{key}.{name}" not in wires]
            if len(free) == variable.count:
                yield _prefixed(key, variable)
            else:
                yield from (replace(variable, name=f"{key}.{name}", size=None) for name in free)


def _terminals(parts: Mapping[str, Component], wires: Mapping[str, str]) -> Iterable[Terminal]:
    """Terminals of the parts with those members that no wire feeds."""
    for key, part in parts.items():
        for terminal in part.terminals:
            full = ((member, f"{key}.{scalar}") for member, scalar in terminal.members)
            members = tuple((member, scalar) for member, scalar in full if scalar not in wires)
            yield Terminal(f"{key}.{terminal.name}", terminal.kind, members)


def _prefixed_table(key: str, played: Played) -> Played:
    """A table that a part plays as one of the whole."""
    columns = tuple(_prefixed(key, each) for each in played.columns)
    return replace(played, name=f"{key}.{played.name}", columns=columns)


def _prefixed_check(key: str, check: Check) -> Check:
    """A part's check as one of the whole: the names in its sentence are the whole's."""
    sentence = f"{key}." + FIELD.sub(lambda field: f"{{{key}.{field[1]}}}", check.sentence)
    return Check(lambda p: check.margin(part_of(p, key)), sentence)
