"""One arithmetic for floats, complex numbers, NumPy arrays and CasADi expressions.

Equations written with these functions serve the Python FMU (floats), its Jacobian (a complex step) and
the native FMU (CasADi, hence C). Comparisons and clips look at the real part alone, so that the derivative
carried in the imaginary part passes through them unchanged.
"""

import math
from collections.abc import Callable
from functools import cache, partial
from typing import Any

import numpy as np

Number = Any
"""A float, a complex number, an array of either, or a CasADi expression."""


class Traced:
    """An expression that remembers how it is computed, and follows NumPy's protocols for arrays.

    Equations that are run with such expressions leave behind what is printed as a law's export: vectors stay
    vectors, and functions that are kept whole stay functions.
    """

    __slots__ = ()

    def erf(self) -> "Traced":
        """The error function of it, which NumPy has not."""
        raise NotImplementedError

    def accumulated(self, change: Any) -> "Traced":
        """The sum with a change, and what rounding leaves of it if that is carried on."""
        raise NotImplementedError

    def __getitem__(self, key: Any) -> "Traced":
        raise NotImplementedError

    def whole(self, function: Callable[..., Any], given: tuple[Any, ...], idle: bool) -> Any:
        """A call of a function that is kept whole, as `fmus.calls` says, with arguments like this one."""
        raise NotImplementedError


LARGEST = 1e300
"""Beyond this a number is taken for not finite; IEEE comparisons with NaN are false."""


def symbolic(*values: Number) -> bool:
    """Whether any of the values is a CasADi expression."""
    for value in values:  # noqa: SIM110
        if _from_casadi(value.__class__):
            return True
    return False


def real(value: Number) -> Number:
    """Real part; a CasADi expression is returned as it is."""
    return value if _from_casadi(value.__class__) else value.real


def where(condition: Number, then: Number, otherwise: Number) -> Number:
    """`then` where the condition holds, else `otherwise`; the branch not taken may be NaN.

    It stands for `if` in a law or an equation, so that the same lines become C.

    Parameters
    ----------
    condition : a comparison, of `real(...)` where the numbers may be complex
    then, otherwise : values of any unit, the same for both
    """
    if _from_casadi(condition.__class__) or _from_casadi(then.__class__) or _from_casadi(otherwise.__class__):
        import casadi

        return casadi.if_else(condition, then, otherwise)
    if getattr(condition, "ndim", 0) == 0 and not isinstance(condition, Traced):
        return then if condition else otherwise
    return np.where(condition, then, otherwise)


def truth(condition: Number) -> Number:
    """1 where the condition holds, else 0."""
    return 1.0 * condition


def absolute(value: Number) -> Number:
    """Absolute value that lets a complex step through."""
    if symbolic(value):
        return alike("fabs", value)
    return where(real(value) < 0, -value, value)


def minimum(a: Number, b: Number) -> Number:
    """The value whose real part is the smaller; `b` where they are equal or one is NaN.

    Every arithmetic decides alike, derivatives at a tie included, which C's fmin would not.
    """
    return where(real(a) < real(b), a, b)


def maximum(a: Number, b: Number) -> Number:
    """The value whose real part is the larger; `b` where they are equal or one is NaN."""
    return where(real(a) > real(b), a, b)


def clip(value: Number, lower: Number, upper: Number) -> Number:
    """The value held between two bounds."""
    return minimum(maximum(value, lower), upper)


def floor(value: Number) -> Number:
    """Largest whole number not above the real part; its derivative is zero."""
    return alike("floor", real(value))


def alike(name: str, *values: Number) -> Number:
    """Value of a function that NumPy and CasADi call by the same name."""
    if symbolic(*values):
        import casadi

        return getattr(casadi, name)(*values)
    return getattr(np, name)(*values)


exp = partial(alike, "exp")
log = partial(alike, "log")
sqrt = partial(alike, "sqrt")
cos = partial(alike, "cos")
sin = partial(alike, "sin")
"""Functions of a number; the cosine's and the sine's is an angle in rad."""


def finite(value: Number) -> Number:
    """Whether a number is neither NaN nor infinite.

    Parameters
    ----------
    value : a float, an array or an expression, as an input of a law
    """
    return alike("fabs" if symbolic(value) else "abs", value) < LARGEST


def erf(value: Number) -> Number:
    """Error function.

    A complex step is carried by the first-order term, erf(a + ib) = erf(a) + ib 2/sqrt(pi) exp(-a^2):
    exact to double precision for the tiny b of a complex step.
    """
    if symbolic(value):
        return alike("erf", value)
    if isinstance(value, Traced):
        return value.erf()
    a = np.real(value)
    result: Number = math.erf(a) if np.ndim(a) == 0 else np.array([math.erf(each) for each in a])
    if np.iscomplexobj(value):
        return result + 1j * np.imag(value) * 2 / math.sqrt(math.pi) * np.exp(-(a**2))
    return result


def stack(*parts: Number) -> Number:
    """One vector of the given scalars and vectors, in order."""
    if symbolic(*parts):
        import casadi

        return casadi.vertcat(*parts)
    # `ndim` of an array is quicker to ask for than `numpy.ndim`, which makes an array of a number.
    whole = [part if getattr(part, "ndim", 0) else _single(part) for part in parts]
    return np.concatenate(whole) if whole else np.zeros(0)


def _single(value: Number) -> Number:
    """A number as a vector of one."""
    return value[None] if isinstance(value, Traced) else (value,)


def beside(one: Number, other: Number) -> Number:
    """Two numbers or vectors of a size as one vector, each element beside the other's."""
    if symbolic(one, other):
        import casadi

        return casadi.vec(casadi.horzcat(one, other).T)
    return np.column_stack((one, other)).ravel()


def side(which: int, both: Number) -> Number:
    """The one (0) or the other (1) of two numbers or vectors that lie side by side."""
    return both[which::2] if both.shape[0] > 2 else both[which]


def placed(value: Number, index: int, size: int) -> Number:
    """Vector of a size that is zero but for one element."""
    if isinstance(value, Traced):
        return stack(*[0.0] * index, value, *[0.0] * (size - index - 1))
    if symbolic(value):
        result: Number = type(value).zeros(size)
    else:
        result = np.zeros(size, dtype=np.result_type(value, float))
    result[index] = value
    return result


def accumulated(value: Number, change: Number) -> Number:
    """A value and a change that is small beside it, from sample to sample.

    It is their sum. An export in single precision adds what rounding has left of such sums before, if the
    value comes from a state that is `slow` (Kahan's summation).
    """
    return value.accumulated(change) if isinstance(value, Traced) else value + change


def total(values: Number) -> Number:
    """Sum of a vector."""
    return alike("sum1" if symbolic(values) else "sum", values)


@cache
def _from_casadi(kind: type) -> bool:
    """Whether a type is CasADi's; `real` and `where`, which most operations use, ask it directly."""
    return kind.__module__.startswith("casadi")
