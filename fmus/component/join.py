"""Joining components by wires into one component.

States, parameters and outputs of the parts lie side by side under `instance.variable`; inputs that a wire
feeds are gone, the others stay. Parts that are joined themselves are taken apart first, so that nesting
changes names and nothing else.

Signals that jump (outputs declared discrete) are held over each micro step of the continuous states, as a
master holds them from one communication point to the next. Sampled parts are sampled one after another in
the order of stepping, each with the newest values, as a Gauss-Seidel master does.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

from warmlink.fmus.component import FIELD, Check, Component, Input, Output, Terminal
from warmlink.fmus.component.dependencies import direct_dependencies
from warmlink.fmus.component.order import stepping_order
from warmlink.fmus.component.wiring import Wiring, part_of, prefixed
from warmlink.fmus.errors import InputError

Wire = tuple[str, str]
"""Source and target of a connection between scalars, as `("motor.heat_flow", "link.heat_flow")`."""


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
    found = {key: direct_dependencies(part) for key, part in flat.items()}
    # Continuous states first, then the sampled ones in the order of sampling.
    order = [key for key, part in flat.items() if not part.sampled] + _sampling_order(flat, fed)
    joint = Wiring({key: flat[key] for key in order}, fed, found)
    held = joint.parts.items()
    continuous = [part.micro_step for _, part in held if part.rates is not None]
    return Component(
        name=name,
        description=description or f"{', '.join(f'{key} ({part.name})' for key, part in flat.items())}",
        inputs=tuple(_inputs(flat, fed)),
        parameters=tuple(prefixed(key, v) for key, part in flat.items() for v in part.parameters),
        derived=tuple(prefixed(key, v) for key, part in flat.items() for v in part.derived),
        states=tuple(prefixed(key, v) for key, part in held for v in part.states),
        outputs=tuple(prefixed(key, v) for key, part in flat.items() for v in part.outputs),
        rates=joint.rates if continuous else None,
        observe=joint.observe,
        derive=joint.derive if any(part.derived for part in flat.values()) else None,
        begin=joint.begin,
        clocks=tuple(joint.clocks()),
        joint=joint,
        terminals=tuple(_terminals(flat, fed)),
        checks=tuple(_check(key, check) for key, part in flat.items() for check in part.checks),
        micro_step=min(continuous, default=1.0),
        default_stop_time=max(part.default_stop_time for part in flat.values()),
        default_step_size=min(part.default_step_size for part in flat.values()),
    )


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
                yield prefixed(key, variable)
            else:
                yield from (replace(variable, name=f"{key}.{name}", size=None) for name in free)


def _terminals(parts: Mapping[str, Component], wires: Mapping[str, str]) -> Iterable[Terminal]:
    """Terminals of the parts with those members that no wire feeds."""
    for key, part in parts.items():
        for terminal in part.terminals:
            full = ((member, f"{key}.{scalar}") for member, scalar in terminal.members)
            members = tuple((member, scalar) for member, scalar in full if scalar not in wires)
            yield Terminal(f"{key}.{terminal.name}", terminal.kind, members)


def _check(key: str, check: Check) -> Check:
    """A part's check as one of the whole: the names in its sentence are the whole's."""
    sentence = f"{key}." + FIELD.sub(lambda field: f"{{{key}.{field[1]}}}", check.sentence)
    return Check(lambda p: check.margin(part_of(p, key)), sentence)
