"""How numbers, and what CasADi does to them, are written in C: as numbers, or as vectors of several runs."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, NamedTuple


class Number(NamedTuple):
    """A number where it lies: in a vector at a place, or under a name, or as it is written."""

    name: str
    place: int | None = None

    def __str__(self) -> str:
        return self.name if self.place is None else f"{self.name}[{self.place}]"

    @property
    def pointer(self) -> str:
        """Where it and what lies beside it begins."""
        return f"{self.name}+{self.place}" if self.place else self.name


Numbers = list[Number]


def stride(numbers: Numbers) -> int | None:
    """How far numbers lie apart in one vector; None where they do not."""
    (name, first), (_, second) = numbers[0], numbers[1 % len(numbers)]
    if first is None or second is None:
        return None
    step = second - first if len(numbers) > 1 else 1
    return step if all(each == (name, first + step * i) for i, each in enumerate(numbers)) else None


@dataclass(frozen=True)
class Dialect:
    """How C is written.

    Attributes
    ----------
    real, constant : type of a number, and form of one that is written out
    operations : form of each operation on numbers, by CasADi's number of it
    choice, asked : forms of a choice of two, and of the question whether a number is not 0
    """

    real: str
    constant: str
    operations: Mapping[int, str]
    choice: str
    asked: str

    def literal(self, value: float) -> Number:
        """A number that is written out, with a point."""
        mantissa, e, exponent = repr(float(value)).partition("e")
        if "n" in mantissa:
            text = f"(double){mantissa.replace('inf', 'INFINITY').replace('nan', 'NAN')}"
        else:
            text = (mantissa if "." in mantissa else f"{mantissa}.") + e + exponent
        return Number(self.constant.format(f"({text})" if text[0] == "-" else text))


@cache
def dialect(lanes: bool) -> Dialect:
    """C for numbers, or for the vectors of `lanes.h`."""
    import casadi

    asked = {"LT": "{0}<{1}", "LE": "{0}<={1}", "EQ": "{0}=={1}", "NE": "{0}!={1}"}
    asked |= {"NOT": "{0}==0.", "AND": "({0}!=0.)&({1}!=0.)", "OR": "({0}!=0.)|({1}!=0.)"}
    forms = {name: f"TRUTH({form})" if lanes else f"({form})" for name, form in asked.items()}
    forms |= {"ADD": "({0}+{1})", "SUB": "({0}-{1})", "MUL": "({0}*{1})", "DIV": "({0}/{1})"}
    forms |= {"NEG": "(-{0})", "SQ": "({0}*{0})", "TWICE": "({0}+{0})", "INV": "(1./{0})"}
    own = "lanes_" if lanes else ""
    for names, given in (
        (("SQRT", "EXP", "EXPM1", "LOG", "LOG1P", "ERF", "FABS", "FLOOR", "CEIL"), "({0})"),
        (("SIN", "COS", "TAN", "ASIN", "ACOS", "ATAN"), "({0})"),
        (("SINH", "COSH", "TANH", "ASINH", "ACOSH", "ATANH"), "({0})"),
        (("POW", "FMOD", "REMAINDER", "ATAN2", "HYPOT", "COPYSIGN", "FMIN", "FMAX"), "({0},{1})"),
    ):
        forms |= {name: f"{own}{name.lower()}{given}" for name in names}
    forms["CONSTPOW"] = forms["POW"]
    forms["SIGN"] = "lanes_sign({0})" if lanes else "({0}<0?-1:{0}>0?1:{0})"
    forms["IF_ELSE_ZERO"] = "IF({0},{1})" if lanes else "({0}?{1}:0)"
    operations = {getattr(casadi, f"OP_{name}"): form for name, form in forms.items()}
    if lanes:
        return Dialect("lanes", "EACH({0})", operations, "EITHER({0},{1},{2})", "any_of({0})")
    return Dialect("double", "{0}", operations, "({0}?{1}:{2})", "{0}!=0")


@cache
def moves() -> dict[int, Callable[..., Any]]:
    """What only moves numbers, by CasADi's number of it: how it moves those of matrices, given its node."""
    import casadi

    return {
        casadi.OP_VERTCAT: lambda _, *parts: casadi.vertcat(*parts),
        casadi.OP_HORZCAT: lambda _, *parts: casadi.horzcat(*parts),
        casadi.OP_DIAGCAT: lambda _, *parts: casadi.diagcat(*parts),
        casadi.OP_TRANSPOSE: lambda _, matrix: matrix.T,
        casadi.OP_RESHAPE: lambda _, matrix: matrix,
        casadi.OP_SPARSITY_CAST: lambda _, matrix: matrix,
        casadi.OP_PROJECT: lambda node, matrix: casadi.project(matrix, node.sparsity()),
        casadi.OP_GETNONZEROS: lambda node, matrix: casadi.DM(
            [matrix.nonzeros()[i] if i >= 0 else 0 for i in _picked(**node.info())]
        ),
    }


def _picked(slice: Mapping[str, int] | None = None, nz: Sequence[int] = (), **twice: Any) -> Sequence[int]:
    """Places from which an expression takes numbers, from what CasADi tells of it; -1 where it has a zero."""
    if slice is not None:
        return range(slice["start"], slice["stop"], slice["step"])
    if twice:
        return [first + i for first in _picked(twice["outer"]) for i in _picked(twice["inner"])]
    return nz
