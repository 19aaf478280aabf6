"""Outputs and inputs of a joined component's parts, as CasADi expressions.

These call one function per kind of part.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property

from warmlink.fmus.component import Component
from warmlink.fmus.component.variables import split_name
from warmlink.fmus.packaging.native.casadi_code import Expression
from warmlink.fmus.packaging.native.kinds import Kind


class WirePlan:
    """Parts of a joined component: their kinds, and which elements of the whole's vectors belong to each."""

    def __init__(self, component: Component) -> None:
        assert component.joint is not None
        self.component, self.joint = component, component.joint
        parts = [*self.joint.parts.values()]
        kinds: list[Kind] = []
        self.kinds: dict[str, Kind] = {}
        for key, part in self.joint.parts.items():
            kind = next((each for each in kinds if each.component is part), None)
            if kind is None:
                kind = Kind(part, sum(other is part for other in parts) > 1)
                kinds.append(kind)
            self.kinds[key] = kind

    @property
    def repeats(self) -> bool:
        """Whether there are several parts of a kind."""
        return any(kind.several for kind in self.kinds.values())

    @cached_property
    def places(self) -> dict[str, tuple[slice, slice, slice]]:
        """Slices of the whole's parameters, settled parameters and states that each part has."""
        whole, found = self.component, dict[str, tuple[slice, slice, slice]]()
        for key, part in self.joint.parts.items():
            pairs = ((whole.p, part.p), (whole.d, part.d), (whole.x, part.x))
            firsts = [layout.index[f"{key}.{own.names[0]}"] if own.size else 0 for layout, own in pairs]
            sizes = (own.size for _, own in pairs)
            p, d, x = (slice(first, first + size) for first, size in zip(firsts, sizes, strict=True))
            found[key] = p, d, x
        return found

    def states(self, x: Expression) -> dict[str, Expression]:
        """States of each part from those of the whole."""
        return {key: x[place] for key, (_, _, place) in self.places.items()}

    @cached_property
    def feeds(self) -> dict[str, list[str | int]]:
        """What feeds each input of each part: an output, by name, or an input of the whole, by index."""
        index, wires = self.component.u.index, self.joint.wires
        return {
            key: [wires.get(f"{key}.{n}", None) or index[f"{key}.{n}"] for n in part.u.names]
            for key, part in self.joint.parts.items()
        }


class _ByPart:
    """A quantity of each output and input of the parts, as its value or a derivative.

    The outputs of a block are computed together, once one of them is asked for. `of_inputs` holds the
    quantity of the whole's inputs.
    """

    def __init__(self, plan: WirePlan, of_inputs: Expression) -> None:
        self.plan = plan
        self._of_inputs = of_inputs
        self._blocks: dict[tuple[str, int], Expression] = {}

    def block(self, key: str, number: int) -> Expression:
        """Quantity of each output in a block of a part, by the block's number."""
        if (key, number) not in self._blocks:
            self._blocks[key, number] = self._computed(key, number)
        return self._blocks[key, number]

    def output(self, name: str) -> Expression:
        """Quantity of one output, by its full name."""
        key, own = split_name(name)
        number, at = self.plan.kinds[key].place[own]
        return self.block(key, number)[at]

    def inputs(self, key: str, wanted: Sequence[int] | None = None) -> Expression:
        """Quantity of each input of a part, 0 for those whose indices are not `wanted`; None wants all."""
        import casadi

        feeds = self.plan.feeds[key]
        used = range(len(feeds)) if wanted is None else wanted
        values = [self._fed(feed) if i in used else casadi.MX(0) for i, feed in enumerate(feeds)]
        return casadi.vertcat(casadi.MX(0, 1), *values)

    def _fed(self, feed: str | int) -> Expression:
        return self._of_inputs[feed] if isinstance(feed, int) else self.output(feed)

    def _computed(self, key: str, number: int) -> Expression:
        raise NotImplementedError


class WiredSignals(_ByPart):
    """Values of the outputs and inputs of all parts at one time.

    Parameters
    ----------
    plan : parts of the joined component
    x : states by part
    u, d, time : inputs and settled parameters of the whole, and time in s
    held_at : time in s at which discrete outputs are evaluated, the beginning of the step; `time` if None
    """

    def __init__(
        self,
        plan: WirePlan,
        x: Mapping[str, Expression],
        u: Expression,
        d: Expression,
        time: Expression,
        held_at: Expression | None = None,
    ) -> None:
        super().__init__(plan, u)
        self.x, self.d, self.time = x, d, time
        self.held_at = time if held_at is None else held_at

    def own(self, key: str) -> Expression:
        """Settled parameters of a part."""
        return self.d[self.plan.places[key][1]]

    def now(self, key: str, wanted: Sequence[int] | None = None) -> list[Expression]:
        """Arguments of a part's functions: its states, inputs and settled parameters, and time."""
        return [self.x[key], self.inputs(key, wanted), self.own(key), self.time]

    def _computed(self, key: str, number: int) -> Expression:
        kind = self.plan.kinds[key]
        block = kind.blocks[number]
        *given, _ = self.now(key, block.inputs)
        return kind.outputs(number)(*given, self.held_at if block.discrete else self.time)


class Tangents(_ByPart):
    """Derivatives of the outputs and inputs of all parts along a direction of states, inputs and time.

    `dx`, by part, `du` of the whole and `dtime` are the direction.
    """

    def __init__(
        self, signals: WiredSignals, dx: Mapping[str, Expression], du: Expression, dtime: Expression
    ) -> None:
        super().__init__(signals.plan, du)
        self.signals, self.dx, self.dtime = signals, dx, dtime

    def along(self, key: str, wanted: Sequence[int] | None = None) -> list[Expression]:
        """Arguments of a part's tangent functions: those of `now`, then the direction."""
        return [*self.signals.now(key, wanted), self.dx[key], self.inputs(key, wanted), self.dtime]

    def _computed(self, key: str, number: int) -> Expression:
        kind = self.plan.kinds[key]
        return kind.outputs_tangent(number)(*self.along(key, kind.blocks[number].inputs))
