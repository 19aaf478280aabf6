"""What a component computes, as functions of CasADi."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from warmlink.fmus.component import Component

Expression = Any
"""A CasADi SX or MX."""

Function = tuple[str, list[Expression], Expression]
"""Name, arguments and result of a function that CasADi writes."""


@dataclass(frozen=True)
class Symbols:
    """What the functions of a component depend on, flat, as CasADi symbols."""

    x: Expression
    u: Expression
    p: Expression
    d: Expression
    time: Expression
    step: Expression

    @classmethod
    def of(cls, component: Component, calls: bool = False) -> "Symbols":
        """Fresh symbols for a component; `d` are the parameters and what they settle.

        With `calls` functions marked `as_c_function` stay calls, and vectors loops (MX); otherwise all is
        written out number by number (SX).
        """
        import casadi

        kind = casadi.MX if calls else casadi.SX
        sizes = {"x": component.x.size, "u": component.u.size, "p": component.p.size, "d": component.d.size}
        vectors = {name: kind.sym(name, size) for name, size in sizes.items()}
        return cls(**vectors, time=kind.sym("time"), step=kind.sym("step"))

    @property
    def now(self) -> list[Expression]:
        """States, inputs, settled parameters and time."""
        return [self.x, self.u, self.d, self.time]


def beginning(component: Component, suffix: str = "") -> Iterator[Function]:
    """Yield `begin`, the states at the start, and `begin_tangent`, their derivative along inputs and time."""
    import casadi

    if not component.states:
        return
    s = Symbols.of(component, calls=component.sampled)
    yield f"begin{suffix}", [s.u, s.d, s.time], component.states_at_start(s.u, s.d, s.time)
    s = Symbols.of(component)
    begun = component.states_at_start(s.u, s.d, s.time)
    along = [casadi.SX.sym("also", component.u.size), casadi.SX.sym("also")]
    moved = casadi.jtimes(begun, casadi.vertcat(s.u, s.time), casadi.vertcat(*along))
    yield f"begin_tangent{suffix}", [s.u, s.d, s.time, *along], moved


def sampling(component: Component, clock: int, name: str = "sample") -> Function:
    """States of a clock after a sample; the function's name ends with the clock's number."""
    s = Symbols.of(component, calls=component.sampled)
    updated = component.updated(s.x, s.u, s.d, s.time, s.step, component.clocks[clock])
    return f"{name}_{clock}", [*s.now, s.step], updated


def function(name: str, arguments: list[Expression], result: Expression) -> Any:
    """CasADi function of one result, in the kind of expression that its arguments are."""
    import casadi

    kind = type(arguments[0])
    with unsimplified():
        return casadi.Function(name, arguments, [casadi.cse(casadi.densify(kind(result)))])


def apart(results: list[Expression], *held: Expression) -> tuple[list[Expression], Expression, Expression]:
    """Results (SX) that read from a new vector what held arguments alone decide; it; what it stands for."""
    import casadi

    with unsimplified():
        dense = casadi.cse([casadi.densify(each) for each in results])
        rest, *both = casadi.extract_parametric(dense, casadi.vertcat(*held))
        known, found = (casadi.vertcat(casadi.SX(0, 1), *each) for each in both)
    return rest, known, found


@contextmanager
def unsimplified() -> Iterator[None]:
    """Keep expressions as they are written: CasADi turns each product with a reciprocal into a division."""
    import casadi

    casadi.GlobalOptions.setSimplificationOnTheFly(False)
    try:
        yield
    finally:
        casadi.GlobalOptions.setSimplificationOnTheFly(True)
