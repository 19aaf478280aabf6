"""The law of a term: an expression for heat in W, in the arithmetic of the components.

Functions are `abs(x)`, `sqrt(x)`, `exp(x)`, `max(x, y)`, `min(x, y)`, `sign(x)` (-1, 0 or 1), `step(x)`
(1 above 0, else 0), and `lag(x, tau)`: x after a first-order lag with a time constant in s, from 0 at the
start. A power that is not written as a whole number is 0 for a base that is not above 0, so that
`(speed - b)**1.5` acts above b alone.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from warmlink.fmus.component import arithmetic
from warmlink.fmus.component.arithmetic import Number, maximum, minimum, real, truth, where
from warmlink.fmus.component.expression import Function, NotAnExpressionError, evaluated
from warmlink.fmus.errors import InputError
from warmlink.fmus.syntax import parsed

TIME = "time"
"""Name of the time in s."""

LAG = "lag"

LONGEST = 500
"""Characters of a law."""

_EXAMPLE = '"a * max(speed - b, 0)**1.5"'


class PlainNumber(float):
    """A number as it stands in a law."""

    def __neg__(self) -> PlainNumber:
        return PlainNumber(-float(self))


def power(base: Number, exponent: Number) -> Number:
    """Power of a base; 0 where the base is not above 0 and the exponent is not written as a whole number.

    So it is the same for numbers and for symbols, of which nobody knows whether they are whole.
    """
    if isinstance(exponent, PlainNumber) and exponent.is_integer():
        return base ** int(exponent)
    above = real(base) > 0.0
    return where(above, where(above, base, 1.0) ** exponent, 0.0)


def step(value: Number) -> Number:
    """1 where a value is above 0, else 0."""
    return truth(real(value) > 0.0)


FUNCTIONS: Mapping[str, tuple[int, Function]] = {
    "abs": (1, arithmetic.absolute),
    "sqrt": (1, lambda value: power(value, 0.5)),
    "exp": (1, arithmetic.exp),
    "max": (2, maximum),
    "min": (2, minimum),
    "sign": (1, lambda value: step(value) - step(-value)),
    "step": (1, step),
}
"""Functions of a law, with the number of their arguments; a lag is a state, and stands for itself."""


@dataclass(frozen=True)
class HeatLaw:
    """An expression for heat in W; InputError, with `where` it stands, if it is none."""

    text: str
    where: str = "heat"

    def __post_init__(self) -> None:
        self._checked(lambda: self.variables)
        self._checked(lambda: self.heat(lambda name: _PROBE, [_PROBE] * self.lag_count, _PROBE))

    @cached_property
    def variables(self) -> tuple[str, ...]:
        """Names in the expression, time and lags aside, in the order in which they first occur."""
        found: dict[str, float] = {}

        def of(name: str) -> float:
            if name != TIME and name not in self._memory:
                found.setdefault(name, 1.0)
            return 1.0

        for tree in (self._tree, *(each for pair in self._lags for each in pair)):
            evaluated(tree, of, _ANY, power=lambda base, exponent: 1.0)
        return tuple(found)

    @property
    def lag_count(self) -> int:
        """Number of lags, each of which is a state."""
        return len(self._lags)

    def heat(self, of: Callable[[str], Number], lagged: Any, time: Number) -> Number:
        """Heat in W, for the values of names, of the lags, shape (lag_count,), and the time in s."""
        return self._value(self._tree, of, lagged, time)

    def lag_rates(self, of: Callable[[str], Number], lagged: Any, time: Number) -> list[Number]:
        """Time derivative of each lag, in its unit per s."""
        every = ([self._value(tree, of, lagged, time) for tree in pair] for pair in self._lags)
        return [(wanted - lagged[i]) / constant for i, (wanted, constant) in enumerate(every)]

    def in_arithmetic(
        self,
        of: Callable[[str], Any],
        functions: Mapping[str, tuple[int, Function]],
        power: Function,
        number: Callable[[float], Any],
    ) -> Any:
        """The expression in another arithmetic, which has a function `lag` too; raises as `evaluated`."""
        return evaluated(self._whole, of, functions, power, number)

    def _value(self, tree: ast.expr, of: Callable[[str], Number], lagged: Any, time: Number) -> Number:
        def named(name: str) -> Number:
            if name in self._memory:
                return lagged[self._memory.index(name)]
            return time if name == TIME else of(name)

        return evaluated(tree, named, FUNCTIONS, power, PlainNumber)

    @property
    def _memory(self) -> list[str]:
        """Names that stand for the lags in the expression."""
        return [f"_lag{i}" for i in range(len(self._lags))]

    @cached_property
    def _split(self) -> tuple[ast.expr, tuple[tuple[ast.expr, ast.expr], ...]]:
        """The expression with a name for each lag, and what each follows with its time constant."""
        found: list[tuple[ast.expr, ast.expr]] = []

        class Lags(ast.NodeTransformer):
            def visit_Call(self, node: ast.Call) -> ast.AST:
                self.generic_visit(node)
                match node:
                    case ast.Call(ast.Name("lag"), [follows, constant], []):
                        found.append((follows, constant))
                        return ast.Name(f"_lag{len(found) - 1}", ast.Load())
                return node

        return Lags().visit(self._parse()), tuple(found)

    @property
    def _tree(self) -> ast.expr:
        return self._split[0]

    @property
    def _lags(self) -> tuple[tuple[ast.expr, ast.expr], ...]:
        return self._split[1]

    @cached_property
    def _whole(self) -> ast.expr:
        return self._parse()

    def _parse(self) -> Any:
        if len(self.text) > LONGEST:
            raise InputError(f"{self.where}: {len(self.text)} characters are too many; keep to {LONGEST}")
        try:
            return parsed(self.text.strip(), "eval").body
        except (SyntaxError, ValueError, RecursionError, MemoryError):
            raise InputError(
                f"{self.where}: {self.text!r} is no expression; write one as {_EXAMPLE}"
            ) from None

    def _checked(self, asked: Callable[[], object]) -> None:
        try:
            with np.errstate(all="ignore"):
                asked()
        except NotAnExpressionError as part:
            known = ", ".join((*FUNCTIONS, LAG))
            raise InputError(
                f"{self.where}: {part} means nothing in {self.text!r}; use names, numbers, + - * / ** and "
                f"{known}, as in {_EXAMPLE}"
            ) from None
        except (ArithmeticError, RecursionError):
            raise InputError(
                f"{self.where}: {self.text[:60]!r} cannot be worked out; write one as {_EXAMPLE}"
            ) from None


_PROBE = 1.2345
"""Value by which a law is tried: no ordinary difference or quotient of such values is out of range."""

_ANY = {name: (count, lambda *given: 1.0) for name, (count, _) in FUNCTIONS.items()}
"""Functions by which only names are looked for."""


def identifier(name: str) -> str:
    """Name of a component's variable for a name in an expression: `link_sensor_temperature_2`."""
    return re.sub(r"\W+", "_", name).strip("_")
