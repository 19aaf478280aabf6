"""Expressions that people write, worked out in any arithmetic from their syntax tree: nothing is executed."""

from __future__ import annotations

import ast
import operator
from collections.abc import Callable, Mapping

from warmlink.fmus.component.arithmetic import Number

Function = Callable[..., Number]

_BINARY: Mapping[type[ast.operator], Function] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
}
_UNARY: Mapping[type[ast.unaryop], Function] = {ast.USub: operator.neg, ast.UAdd: operator.pos}


class NotAnExpressionError(ValueError):
    """A part of an expression that means nothing in it; the part as it was written."""


def evaluated(
    node: ast.expr,
    of: Callable[[str], Number],
    functions: Mapping[str, tuple[int, Function]],
    power: Function = operator.pow,
    number: Callable[[float], Number] = float,
) -> Number:
    """Value of an expression: sums, products, quotients, powers, functions, names and numbers.

    Parameters
    ----------
    node : syntax tree of the expression
    of : value of a name: `speed`, `motor.speed` or `link.sensor_temperature[2]`
    functions : by name, how many arguments each takes, and the function
    power : function of a base and its exponent
    number : makes a number of a constant

    Raises
    ------
    NotAnExpressionError
        A part is none of these.
    """

    def value(node: ast.expr) -> Number:
        match node:
            case ast.Constant(value=int() | float() as given) if not isinstance(given, bool):
                return number(given)
            case ast.BinOp(left, ast.Pow(), right):
                return power(value(left), value(right))
            case ast.BinOp(left, op, right) if type(op) in _BINARY:
                return _BINARY[type(op)](value(left), value(right))
            case ast.UnaryOp(op, operand) if type(op) in _UNARY:
                return _UNARY[type(op)](value(operand))
            case ast.Call(ast.Name(name), arguments, []) if name in functions:
                count, function = functions[name]
                if len(arguments) == count:
                    return function(*map(value, arguments))
            case ast.Name() | ast.Attribute() | ast.Subscript(ast.Attribute(), ast.Constant(int())):
                return of(ast.unparse(node))
        raise NotAnExpressionError(ast.unparse(node))

    return value(node)
