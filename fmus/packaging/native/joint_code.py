"""Functions of a joined component: each kind of part once, called for each part with what the wires bring.

Written out whole, six observers would be six times their thousands of lines.
"""

from collections.abc import Iterator
from typing import Any

from warmlink.fmus.calls import called
from warmlink.fmus.component import Component
from warmlink.fmus.component.join import Joint
from warmlink.fmus.packaging.native.casadi_code import (
    Expression,
    Function,
    Symbols,
    beginning,
    function,
    sampling,
)


def starting(component: Component, joint: Joint) -> Iterator[Function]:
    """Yield `settle`, `begin` and `begin_tangent` of the whole.

    Parts that wait for each other's first outputs begin more than once.
    """
    import casadi

    s, now = Symbols.of(component, calls=True), Symbols.of(component).now
    along = [casadi.SX.sym("also", each.numel()) for each in now[:2]]
    of: dict[str, Any] = {}
    for kind in {part.name: part for part in joint.parts.values()}.values():
        p = casadi.SX.sym("p", kind.p.size)
        parts = (f"settle_{kind.name}", [p], kind.settled(p)), *beginning(kind, f"_{kind.name}")
        of |= {each[0]: called(function(*each)) for each in parts}
    settled, begun, moved = {}, {}, {}
    du = casadi.MX.sym("also", component.u.size)
    for key, part in joint.parts.items():
        first, d, _ = _places(component, key, part)
        settled[d] = of[f"settle_{part.name}"](s.p[first : first + part.p.size])
        begun[key] = moved[key] = casadi.MX.zeros(part.x.size)
    for key in joint.starting:
        part = joint.parts[key]
        _, d, _ = _places(component, key, part)
        own, when = s.d[d : d + part.d.size], [casadi.vertcat(*begun.values()), s.u, s.d, casadi.MX(0)]
        inputs = casadi.SX(part_inputs(component, joint, key, now))
        slope = casadi.jtimes(inputs, casadi.vertcat(*now[:2]), casadi.vertcat(*along))
        given = called(function(f"inputs_{part.name}", now, inputs))(*when)
        tangent = called(function(f"inputs_tangent_{part.name}", [*now, *along], slope))
        turned = tangent(*when, casadi.vertcat(*moved.values()), du)
        moved[key] = of[f"begin_tangent_{part.name}"](given, own, turned)
        begun[key] = of[f"begin_{part.name}"](given, own)
    yield "settle", [s.p], casadi.vertcat(*(settled[d] for d in sorted(settled)))
    yield "begin", [s.u, s.d], casadi.vertcat(*begun.values())
    yield "begin_tangent", [s.u, s.d, du], casadi.vertcat(*moved.values())


def samples(component: Component, joint: Joint) -> Iterator[Function]:
    """Yield `sample_0` and so on of the whole: what each clock does."""
    s, now = Symbols.of(component, calls=True), Symbols.of(component).now
    kinds = {part.name: part for _, part, *_ in sampled_parts(component, joint)}
    update = {name: called(function(*sampling(kind, 0, f"update_{name}"))) for name, kind in kinds.items()}
    for clock, (key, part, d, x) in enumerate(sampled_parts(component, joint)):
        states, own = s.x[x : x + part.x.size], s.d[d : d + part.d.size]
        inputs = function(f"inputs_{clock}", now, part_inputs(component, joint, key, now))(*s.now)
        yield f"sample_{clock}", [*s.now, s.step], update[part.name](states, inputs, own, s.time, s.step)


def sampled_parts(component: Component, joint: Joint) -> Iterator[tuple[str, Component, int, int]]:
    """Yield name of each sampled part, the part, and where `d` and `x` of it begin."""
    for key, part in joint.parts.items():
        if part.sampled:
            _, d, x = _places(component, key, part)
            yield key, part, d, x


def part_inputs(component: Component, joint: Joint, key: str, now: list[Expression]) -> Expression:
    """Flat inputs of a part as expressions of the whole's symbols."""
    x, u, d, time = now
    return joint.inputs(key, component.x.read(x), component.u.read(u), component.d.read(d), time)


def _places(component: Component, key: str, part: Component) -> tuple[int, int, int]:
    """Where a part's parameters, what they settle, and its states begin in the vectors of the whole."""
    layouts = ((component.p, part.p), (component.d, part.d), (component.x, part.x))
    p, d, x = (whole.index[f"{key}.{own.names[0]}"] if own.size else 0 for whole, own in layouts)
    return p, d, x
