"""Signals between the parts of a joined component, as calls of what each kind of part computes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property

from warmlink.fmus.component import Component
from warmlink.fmus.component.variables import split_name
from warmlink.fmus.packaging.native.casadi_code import Expression
from warmlink.fmus.packaging.native.kinds import Kind


class WirePlan:
    """Where the parts of a joined component lie in its vectors, and the kind of each."""

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
        """For each part where its parameters, what they settle, and its states lie."""
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
        """For each part, by input, the output that feeds it, or the index of the whole's input that it is."""
        index, wires = self.component.u.index, self.joint.wires
        return {
            key: [wires.get(f"{key}.{n}", None) or index[f"{key}.{n}"] for n in part.u.names]
            for key, part in self.joint.parts.items()
        }


class _ByPart:
    """Something of each output of the parts, block by block, and only where it is asked for."""

    def __init__(self, plan: WirePlan, of_inputs: Expression) -> None:
        self.plan = plan
        self._of_inputs = of_inputs
        self._blocks: dict[tuple[str, int], Expression] = {}

    def block(self, key: str, number: int) -> Expression:
        """That of the outputs of a part that are computed together."""
        if (key, number) not in self._blocks:
            self._blocks[key, number] = self._computed(key, number)
        return self._blocks[key, number]

    def output(self, name: str) -> Expression:
        """That of one output, by its full name."""
        key, own = split_name(name)
        number, at = self.plan.kinds[key].place[own]
        return self.block(key, number)[at]

    def inputs(self, key: str, wanted: Sequence[int] | None = None) -> Expression:
        """That of a part's inputs; with 0 in place of those that are not wanted."""
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
    """Values of outputs and inputs of the parts at an instant.

    Parameters
    ----------
    plan : of the joined component
    x : states by part
    u, d, time : inputs and settled parameters of the whole, and time in s
    since : where given, the time at which signals that jump are taken
    """

    def __init__(
        self,
        plan: WirePlan,
        x: Mapping[str, Expression],
        u: Expression,
        d: Expression,
        time: Expression,
        since: Expression | None = None,
    ) -> None:
        super().__init__(plan, u)
        self.x, self.d, self.time = x, d, time
        self.since = time if since is None else since

    def own(self, key: str) -> Expression:
        """What the parameters of a part settle."""
        return self.d[self.plan.places[key][1]]

    def now(self, key: str, wanted: Sequence[int] | None = None) -> list[Expression]:
        """States, inputs, settled parameters of a part, and time."""
        return [self.x[key], self.inputs(key, wanted), self.own(key), self.time]

    def _computed(self, key: str, number: int) -> Expression:
        kind = self.plan.kinds[key]
        block = kind.blocks[number]
        *given, _ = self.now(key, block.inputs)
        return kind.outputs(number)(*given, self.since if block.discrete else self.time)


class Tangents(_ByPart):
    """Derivatives of outputs and inputs of the parts along a direction of states, inputs and time."""

    def __init__(
        self, signals: WiredSignals, dx: Mapping[str, Expression], du: Expression, dtime: Expression
    ) -> None:
        super().__init__(signals.plan, du)
        self.signals, self.dx, self.dtime = signals, dx, dtime

    def along(self, key: str, wanted: Sequence[int] | None = None) -> list[Expression]:
        """States, inputs, settled parameters of a part, time, and their direction."""
        return [*self.signals.now(key, wanted), self.dx[key], self.inputs(key, wanted), self.dtime]

    def _computed(self, key: str, number: int) -> Expression:
        kind = self.plan.kinds[key]
        return kind.outputs_tangent(number)(*self.along(key, kind.blocks[number].inputs))
