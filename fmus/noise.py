"""Random numbers whose generator is part of a component's state.

The combined multiplicative congruential generator of P. L'Ecuyer, "Efficient and portable combined random
number generators", Communications of the ACM 31 (1988) 742-774. Every product stays below 2^53, so doubles
carry it exactly: the Python and the native form, and every restored state, draw the same numbers.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from warmlink.fmus.arithmetic import Number, cos, floor, log, sqrt, stack, where

_MODULUS_A, _FACTOR_A = 2147483563.0, 40014.0
_MODULUS_B, _FACTOR_B = 2147483399.0, 40692.0

STATE_SIZE = 2
"""Doubles in the generator's state."""


def start(seed: Number, channel: int = 0) -> Number:
    """State of a generator, shape (2,), for a seed (a whole number) and a channel of its own."""
    return stack(*starts(seed, (channel,)))


def advance(state: Number) -> Number:
    """Next state of the generator, shape (2,)."""
    return stack(*_next(state[0], state[1]))


def uniform(state: Number) -> Number:
    """Number in (0, 1) that belongs to a state."""
    return _share(state[0], state[1])


def normal(state: Number) -> tuple[Number, Number]:
    """Draw from the standard normal distribution (Box and Muller): the number, and the next state."""
    number, a, b = normals(state[0], state[1])
    return number, stack(a, b)


def starts(seed: Number, channels: Sequence[int]) -> tuple[Number, Number]:
    """First and second halves of the states of one generator a channel, each of shape (channels,)."""
    whole = floor(seed)
    a = stack(*(1.0 + _remainder(1e4 * whole + 7919.0 * c + 12345.0, _MODULUS_A - 1.0) for c in channels))
    b = stack(*(1.0 + _remainder(3e4 * whole + 104729.0 * c + 67890.0, _MODULUS_B - 1.0) for c in channels))
    for _ in range(4):
        a, b = _next(a, b)
    return a, b


def normals(a: Number, b: Number) -> tuple[Number, Number, Number]:
    """Draw once from each of many generators, given as the halves of their states.

    Returns
    -------
    tuple
        The numbers, and the halves of the next states, each of the shape of `a`.
    """
    first = _next(a, b)
    second = _next(*first)
    number = sqrt(-2.0 * log(_share(*first))) * cos(2.0 * math.pi * _share(*second))
    return number, *second


def _next(a: Number, b: Number) -> tuple[Number, Number]:
    return _remainder(_FACTOR_A * a, _MODULUS_A), _remainder(_FACTOR_B * b, _MODULUS_B)


def _share(a: Number, b: Number) -> Number:
    difference = a - b
    return where(difference < 1, difference + (_MODULUS_A - 1.0), difference) / _MODULUS_A


def _remainder(value: Number, modulus: float) -> Number:
    return value - modulus * floor(value / modulus)
