"""What one kind of part of a joined component computes: functions made once, called for each such part."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from warmlink.fmus.calls import Written, called
from warmlink.fmus.component import Component
from warmlink.fmus.component.dependencies import dependencies
from warmlink.fmus.component.integrator import GAMMA
from warmlink.fmus.packaging.native.casadi_code import (
    Expression,
    Function,
    Symbols,
    beginning,
    function,
    sampling,
)
from warmlink.fmus.packaging.native.groups import groups_by_work

_SHORT = 60
"""Instructions up to which a function is written out where it is needed."""


Place = tuple[int, int]
"""Row and column."""


@dataclass(frozen=True)
class Block:
    """Outputs of a part that are computed together.

    Attributes
    ----------
    outputs : their indices
    inputs : indices of the inputs that they depend on at once
    discrete : whether they jump, so that they are held over a micro step
    """

    outputs: tuple[int, ...]
    inputs: tuple[int, ...]
    discrete: bool


class Kind:
    """Functions of one kind of part.

    Parameters
    ----------
    component : the part
    several : whether there are several such parts, so that long functions stay calls
    """

    def __init__(self, component: Component, several: bool) -> None:
        self.component, self.several = component, several
        self._s = Symbols.of(component)
        self._made: dict[object, Any] = {}

    @cached_property
    def blocks(self) -> tuple[Block, ...]:
        """Blocks that hold every output once: those of one share work, and the same inputs act on them."""
        part, direct = self.component, dependencies(self.component).outputs
        names = part.y.names
        jumps = [variable.discrete for variable in part.outputs for _ in variable.scalar_names]
        found: dict[tuple[int, tuple[int, ...], bool], list[int]] = {}
        for number, group in enumerate(groups_by_work(part)):
            for i in group:
                inputs = tuple(part.u.index[n] for n in direct[names[i]] if n in part.u.index)
                found.setdefault((number, inputs, jumps[i]), []).append(i)
        return tuple(Block(tuple(of), inputs, jump) for (_, inputs, jump), of in found.items())

    @cached_property
    def place(self) -> dict[str, Place]:
        """For each output its block's number, and where in that it lies."""
        names = self.component.y.names
        blocks = enumerate(self.blocks)
        return {names[i]: (number, at) for number, each in blocks for at, i in enumerate(each.outputs)}

    def _of(self, number: int) -> Expression:
        """Outputs of a block as expressions."""
        return self._y[list(self.blocks[number].outputs)]

    @cached_property
    def _y(self) -> Expression:
        import casadi

        return casadi.SX(self.component.outputs_of(*self._s.now))

    @cached_property
    def _slope(self) -> Expression:
        return self._slope_for(self._s.d)

    def settle(self) -> Any:
        """Function from the parameters to what they settle."""
        return self._once("settle", lambda: ([self._s.p], self.component.settled(self._s.p)))

    def margins(self) -> Any:
        """Function from the parameters to the margins of the checks."""
        import casadi

        p, read = self._s.p, self.component.p.read
        return self._once(
            "margins", lambda: ([p], casadi.vertcat(*(c.margin(read(p)) for c in self.component.checks)))
        )

    def begin(self) -> Any:
        """Function from inputs, settled parameters and time to the states at the start."""
        return self._once("begin", lambda: self._beginning[0][1:])

    def begin_tangent(self) -> Any:
        """Function for the derivative of the states at the start along inputs and time."""
        return self._once("begin_tangent", lambda: self._beginning[1][1:])

    @cached_property
    def _beginning(self) -> list[Function]:
        return [*beginning(self.component)]

    def update(self) -> Any:
        """Function for the states after a sample."""
        return self._once("update", lambda: sampling(self.component, 0)[1:])

    def outputs(self, number: int) -> Any:
        """Function of states, inputs, settled parameters and time for the outputs of a block."""
        return self._once(f"outputs_{number}", lambda: (self._s.now, self._of(number)))

    def outputs_tangent(self, number: int) -> Any:
        """Function for the derivative of a block's outputs along a direction of states, inputs and time."""
        return self._once(f"outputs_tangent_{number}", lambda: self._tangent(self._of(number)))

    def rates_tangent(self) -> Any:
        """Function for the derivative of the rates along a direction of states, inputs and time."""
        return self._once("rates_tangent", lambda: self._tangent(self._slope))

    def rates(self) -> Any:
        """Function for the rates; without what is rare where all that brings it is 0."""
        return self._with_rare("rates", self._s.now, self._slope_for)

    @cached_property
    def rate_inputs(self) -> tuple[int, ...]:
        """Indices of the inputs that act on the rates."""
        import casadi

        _, columns = casadi.jacobian_sparsity(self._slope, self._s.u).get_triplet()
        return tuple(sorted(set(columns)))

    def gradient(self, number: int) -> tuple[Any, list[Place]]:
        """Function for the derivatives of a block's outputs by continuous states and inputs.

        Beside it where they stand: the output's place, and the state's or, after all states, the input's.
        """
        import casadi

        by = casadi.vertcat(self._s.x[: self.component.continuous.size], self._s.u)
        slopes = casadi.jacobian(self._of(number), by)
        places = list(zip(*slopes.sparsity().get_triplet(), strict=True))
        return self._once(f"gradient_{number}", lambda: (self._s.now, _nonzeros(slopes))), places

    def linearised(self, inputs: Sequence[int], fed_back: Sequence[Place]) -> tuple[Any, list[Place]]:
        """Function for the rates, and after those for what a step's matrix is made of.

        These are elements of I - gamma step J by the part's own states, and derivatives of rates by inputs.
        The function takes after the time the step size, and derivatives of inputs by the part's own states,
        which come back to it by way of others. Beside it is where the elements and derivatives stand: the
        rate's place, and the state's or, after all states, the input's among those given.

        Parameters
        ----------
        inputs : their indices
        fed_back : indices of the input and of the state
        """
        import casadi

        s, size, back = self._s, self.component.continuous.size, casadi.SX.sym("back", len(fed_back))
        # Each such input as what it is at no state, and so much more by state.
        rest = casadi.SX.sym("rest", s.u.numel())
        more = casadi.SX(s.u.numel(), 1)
        for k, (place, state) in enumerate(fed_back):
            more[place] += back[k] * s.x[state]

        def slopes(d: Expression) -> Expression:
            fed = casadi.jacobian(self._slope_for(d, rest + more), s.x[:size])
            own = casadi.substitute(fed, rest, s.u - more)
            return casadi.horzcat(own, casadi.jacobian(self._slope_for(d), s.u[list(inputs)]))

        sparsity = slopes(s.d).sparsity()
        places = list(zip(*sparsity.get_triplet(), strict=True))

        def whole(d: Expression) -> Expression:
            each = zip(places, casadi.project(slopes(d), sparsity).nonzeros(), strict=True)
            made = (float(i == j) - GAMMA * s.step * n if j < size else n for (i, j), n in each)
            return casadi.vertcat(self._slope_for(d), *made)

        key = "linearised", *inputs, *fed_back
        return self._with_rare(key, [*s.now, s.step, back], whole), places

    def _slope_for(self, d: Expression, u: Expression | None = None) -> Expression:
        import casadi

        s = self._s
        return casadi.SX(self.component.rates_of(s.x, s.u if u is None else u, d, s.time))

    def _tangent(self, expression: Expression) -> tuple[list[Expression], Expression]:
        import casadi

        moving = [self._s.x, self._s.u, self._s.time]
        along = [casadi.SX.sym("also", each.numel()) for each in moving]
        slope = casadi.jtimes(expression, casadi.vertcat(*moving), casadi.vertcat(*along))
        return [*self._s.now, *along], slope

    def _once(self, key: str, make: Callable[[], tuple[list[Expression], Expression]]) -> Any:
        """A function, made when it is first wanted."""
        if key not in self._made:
            whole = function(f"{key}_{self.component.name}", *make())
            long = self.several and whole.n_instructions() > _SHORT
            self._made[key] = called(whole) if long else whole
        return self._made[key]

    def _with_rare(
        self, key: object, arguments: list[Expression], result: Callable[[Expression], Expression]
    ) -> Any:
        """A function of settled parameters, which goes without what is rare where all that brings it is 0."""
        import casadi

        if key not in self._made:
            name = f"{key if isinstance(key, str) else 'linearised'}_{self.component.name}"
            seldom = [self.component.d.index[each.name] for each in self.component.parameters if each.rare]
            usual = casadi.SX(self._s.d)
            usual[seldom] = 0
            whole = function(name, arguments, result(self._s.d))
            less = function(f"{name}_usual", arguments, result(usual))
            self._made[key] = (
                _Asking(called(whole, Written(whole, otherwise=less)), seldom) if seldom else called(whole)
            )
        return self._made[key]


@dataclass(frozen=True)
class _Asking:
    """A function that is asked first whether any rare parameter acts."""

    function: Any
    seldom: list[int]

    def __call__(self, *given: Expression) -> Expression:
        import casadi

        return self.function(casadi.sum1(given[2][self.seldom] != 0), *given)


def _nonzeros(matrix: Expression) -> Expression:
    import casadi

    return casadi.vertcat(casadi.SX(0, 1), *matrix.nonzeros())
