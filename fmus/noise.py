"""Random numbers whose generator is part of a component's state.

The combined multiplicative congruential generator of P. L'Ecuyer, "Efficient and portable combined random
number generators", Communications of the ACM 31 (1988) 742-774. Every product stays below 2^53, so doubles
carry it exactly: the Python and the native form, and every restored state, draw the same numbers.
"""

from __future__ import annotations

import math

from warmlink.fmus.arithmetic import Number, cos, floor, log, sqrt, stack, where

_MODULUS_A, _FACTOR_A = 2147483563.0, 40014.0
_MODULUS_B, _FACTOR_B = 2147483399.0, 40692.0

STATE_SIZE = 2
"""Doubles in the generator's state."""


def start(seed: Number, channel: int = 0) -> Number:
    """State of a generator, shape (2,), for a seed (a whole number) and a channel of its own."""
    a = 1.0 + _remainder(1e4 * floor(seed) + 7919.0 * channel + 12345.0, _MODULUS_A - 1.0)
    b = 1.0 + _remainder(3e4 * floor(seed) + 104729.0 * channel + 67890.0, _MODULUS_B - 1.0)
    state = stack(a, b)
    for _ in range(4):
        state = advance(state)
    return state


def advance(state: Number) -> Number:
    """Next state of the generator, shape (2,)."""
    return stack(_remainder(_FACTOR_A * state[0], _MODULUS_A), _remainder(_FACTOR_B * state[1], _MODULUS_B))


def uniform(state: Number) -> Number:
    """Number in (0, 1) that belongs to a state."""
    difference = state[0] - state[1]
    return where(difference < 1, difference + (_MODULUS_A - 1.0), difference) / _MODULUS_A


def normal(state: Number) -> tuple[Number, Number]:
    """Draw from the standard normal distribution (Box and Muller): the number, and the next state."""
    first = advance(state)
    second = advance(first)
    number = sqrt(-2.0 * log(uniform(first))) * cos(2.0 * math.pi * uniform(second))
    return number, second


def _remainder(value: Number, modulus: float) -> Number:
    return value - modulus * floor(value / modulus)
