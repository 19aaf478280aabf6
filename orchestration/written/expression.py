"""Expressions over a system's variables, by which a scenario scores."""

from __future__ import annotations

import ast
import copy
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from warmlink.fmus.component.expression import NotAnExpressionError, evaluated
from warmlink.fmus.errors import InputError
from warmlink.fmus.syntax import parsed

_FUNCTIONS: Mapping[str, tuple[int, Callable[[Any], Any]]] = {"sqrt": (1, np.sqrt), "abs": (1, np.abs)}

LONGEST = 2000
"""Characters of an expression; no score takes more, and a longer one may nest deeper than Python reads."""

_PROBES = 20
"""Points, drawn alike each time, at which a weighted sum must be one."""


@dataclass(frozen=True)
class Expression:
    """Sum, difference, product, quotient, power, `sqrt` and `abs` of variables and numbers; else InputError.

    In the text variables are `instance.variable`, with `[1]` for an element of a vector; `where` it stands is
    put before an error message.
    """

    text: str
    where: str = "score"

    def __post_init__(self) -> None:
        self.value(lambda name: 1.0)

    @cached_property
    def variables(self) -> tuple[str, ...]:
        """Names of the variables, in the order in which they first occur."""
        found: dict[str, float] = {}
        self.value(lambda name: found.setdefault(name, 1.0))
        return tuple(found)

    def value(self, of: Callable[[str], Any]) -> Any:
        """Evaluate the expression; the variables' values are numbers, or arrays of one shape."""
        try:
            with np.errstate(all="ignore"):
                return evaluated(self._tree, self._variable(of), _FUNCTIONS, number=np.float64)
        except NotAnExpressionError as part:
            raise InputError(
                f"{self.where}: {part} is neither a variable nor a number; use instance.variable, "
                f"+ - * / ** and {', '.join(_FUNCTIONS)}"
            ) from None
        except (RecursionError, OverflowError):
            raise InputError(
                f"{self.where}: {self.text[:40]!r}... nests too deep or counts too far"
            ) from None

    def without(self, names: Collection[str]) -> Expression:
        """The same expression with some variables replaced by 0."""

        class Zero(ast.NodeTransformer):
            def generic_visit(self, node: ast.AST) -> ast.AST:
                if isinstance(node, ast.Attribute | ast.Subscript) and ast.unparse(node) in names:
                    return ast.Constant(0.0)
                return super().generic_visit(node)

        tree = Zero().visit(copy.deepcopy(self._tree))
        return Expression(ast.unparse(tree), self.where)

    @cached_property
    def javascript(self) -> str:
        """The expression for a web page, with `v["link.elongation"][i]` for a variable at a step."""

        class Written(ast.NodeTransformer):
            def generic_visit(self, node: ast.AST) -> ast.AST:
                if isinstance(node, ast.Attribute | ast.Subscript):
                    return ast.parse(f"v[{ast.unparse(node)!r}][i]", mode="eval").body
                node = super().generic_visit(node)
                match node:
                    case ast.BinOp(left, ast.Pow(), right):
                        return ast.Call(ast.Name("Math.pow"), [left, right], [])
                    case ast.Call(ast.Name(name), arguments) if name in _FUNCTIONS:
                        return ast.Call(ast.Name(f"Math.{name}"), arguments, [])
                return node

        return ast.unparse(Written().visit(copy.deepcopy(self._tree)))

    def weights(self) -> dict[str, float]:
        """Weight of each variable in a linear expression.

        Raises InputError if the expression is not linear, or has a constant part.
        """
        zero, count = dict.fromkeys(self.variables, 0.0), len(self.variables)
        found = {name: float(self.value({**zero, name: 1.0}.__getitem__)) for name in self.variables}
        random = np.random.default_rng(0)
        # Of both signs and of every size: else `abs` is linear, and what bends somewhere far off.
        sizes = 10.0 ** random.uniform(-6, 6, (_PROBES, count)) * random.choice([-1.0, 1.0], (_PROBES, count))
        for probe in ([1.0] * count, [-1.0] * count, *sizes.tolist()):
            values = dict(zip(self.variables, probe, strict=True))
            parts = [found[name] * value for name, value in values.items()]
            if not abs(self.value(values.__getitem__) - sum(parts)) <= 1e-9 * sum(map(abs, parts)):
                told = f"{self.text} is not linear in its variables; give a weighted sum"
                raise InputError(f"{self.where}: {told}")
        return found

    @cached_property
    def _tree(self) -> ast.expr:
        if len(self.text) > LONGEST:
            raise InputError(f"{self.where}: {len(self.text)} characters are too many; keep to {LONGEST}")
        try:
            return parsed(self.text, "eval").body
        except (SyntaxError, ValueError, RecursionError, MemoryError):
            raise InputError(
                f"{self.where}: {self.text!r} is no expression; write one as "
                '"link.elongation - compensator.correction"'
            ) from None

    @staticmethod
    def _variable(of: Callable[[str], Any]) -> Callable[[str], Any]:
        """Function that gives the value of a variable, which has its instance before the dot."""

        def value(name: str) -> Any:
            if "." not in name:
                raise NotAnExpressionError(name)
            return np.float64(of(name))

        return value
