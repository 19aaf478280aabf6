"""Functions of a joined component: each kind of part once, called for each part with what the wires bring.

Written out whole, six observers would be six times their thousands of lines.
"""

from collections.abc import Iterator

from warmlink.fmus.component import Component
from warmlink.fmus.packaging.native.casadi_code import Function, Symbols
from warmlink.fmus.packaging.native.groups import LARGEST_COUNT, fewer
from warmlink.fmus.packaging.native.wired import Tangents, WiredSignals, WirePlan


def starting(plan: WirePlan) -> Iterator[Function]:
    """Yield `margins`, `settle`, `begin` and `begin_tangent` of the whole.

    Parts that wait for each other's first outputs begin more than once.
    """
    import casadi

    component, joint, nothing = plan.component, plan.joint, casadi.MX(0, 1)
    s = Symbols.of(component, calls=True)
    du, dtime = casadi.MX.sym("also", component.u.size), casadi.MX.sym("also")
    keys = sorted(joint.parts, key=lambda key: plan.places[key][1].start)
    own = {key: s.p[plan.places[key][0]] for key in keys}
    margins = [plan.kinds[key].margins()(own[key]) for key in keys if joint.parts[key].checks]
    settled = [plan.kinds[key].settle()(own[key]) for key in keys if joint.parts[key].d.size]
    begun = {key: casadi.MX.zeros(part.x.size) for key, part in joint.parts.items()}
    moved = dict(begun)
    for key in joint.starting:
        kind = plan.kinds[key]
        signals = WiredSignals(plan, begun, s.u, s.d, s.time)
        along = Tangents(signals, moved, du, dtime)
        given = signals.inputs(key), signals.own(key), s.time
        moved = moved | {key: kind.begin_tangent()(*given, along.inputs(key), dtime)}
        begun = begun | {key: kind.begin()(*given)}
    yield "margins", [s.p], casadi.vertcat(nothing, *margins)
    yield "settle", [s.p], casadi.vertcat(nothing, *settled)
    yield "begin", [s.u, s.d, s.time], casadi.vertcat(nothing, *begun.values())
    yield "begin_tangent", [s.u, s.d, s.time, du, dtime], casadi.vertcat(nothing, *moved.values())


def samples(plan: WirePlan) -> Iterator[Function]:
    """Yield `sample_0` and so on of the whole: what each clock does."""
    s = Symbols.of(plan.component, calls=True)
    signals = WiredSignals(plan, plan.states(s.x), s.u, s.d, s.time)
    for clock, (key, *_) in enumerate(sampled_parts(plan)):
        yield f"sample_{clock}", [*s.now, s.step], plan.kinds[key].update()(*signals.now(key), s.step)


def sampled_parts(plan: WirePlan) -> Iterator[tuple[str, Component, int]]:
    """Yield name of each sampled part, the part, and where its states begin."""
    for key, part in plan.joint.parts.items():
        if part.sampled:
            yield key, part, plan.places[key][2].start


def output_functions(plan: WirePlan) -> tuple[list[list[int]], Iterator[Function]]:
    """Groups of the whole's outputs; `outputs_0` and so on, which compute them, and `tangent` of all."""
    index = plan.component.y.index
    blocks = [
        [index[f"{key}.{kind.component.y.names[i]}"] for i in block.outputs]
        for key, kind in plan.kinds.items()
        for block in kind.blocks
    ]
    groups = fewer(sorted(blocks), LARGEST_COUNT)
    return groups, _seen(plan, groups)


def _seen(plan: WirePlan, groups: list[list[int]]) -> Iterator[Function]:
    import casadi

    s, names = Symbols.of(plan.component, calls=True), plan.component.y.names
    signals = WiredSignals(plan, plan.states(s.x), s.u, s.d, s.time)
    for number, group in enumerate(groups):
        yield f"outputs_{number}", s.now, casadi.vertcat(*(signals.output(names[i]) for i in group))
    along = [casadi.MX.sym("also", each.numel()) for each in (s.x, s.u, s.time)]
    tangents = Tangents(signals, plan.states(along[0]), *along[1:])
    moving = (tangents.output(name) for name in names)
    yield "tangent", [*s.now, *along], casadi.vertcat(casadi.MX(0, 1), *moving)
