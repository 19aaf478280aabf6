"""Random numbers whose generator is part of a component's state.

The combined multiplicative congruential generator of P. L'Ecuyer, "Efficient and portable combined random
number generators", Communications of the ACM 31 (1988) 742-774. Every product stays below 2^53, so doubles
carry it exactly: the Python and the native form, and every restored state, draw the same numbers.
"""

import math
from collections.abc import Sequence

from warmlink.fmus.calls import as_c_function, skip_if_zero
from warmlink.fmus.component.arithmetic import Number, cos, floor, log, sqrt, stack, where

_MODULUS_A, _FACTOR_A = 2147483563.0, 40014.0
_MODULUS_B, _FACTOR_B = 2147483399.0, 40692.0

_MIXING_MODULUS = 16777213.0
"""A prime small enough for the quotient of its squares to be exact in doubles."""


def starts(seed: Number, channels: Sequence[int]) -> tuple[Number, Number]:
    """First and second halves of the states of one generator for each channel, each of shape (channels,).

    The state depends on the squares of seed and channel. The generator is linear: if the state depended
    linearly on the seed, the sequences of any two seeds would differ by the same numbers.
    """
    whole = floor(seed)
    a = stack(*(_mixed(1e6 * whole + 15485863.0 * channel + 12345.0) for channel in channels))
    b = stack(*(_mixed(9e5 * whole + 32452843.0 * channel + 67890.0) for channel in channels))
    for _ in range(4):
        a, b = advanced(a, b)
    return a, b


def normals(a: Number, b: Number, wanted: Number = 1.0) -> tuple[Number, Number, Number]:
    """Draw once from each of many generators, given as the halves of their states.

    Gives the numbers, 0 where they are not `wanted`, and the halves of the next states, in the shape of `a`.
    """
    shares, *following = _drawn(a, b)
    return _normal(0.0 * a, *shares, wanted), *following


@as_c_function
def _drawn(a: Number, b: Number) -> tuple[tuple[Number, Number], Number, Number]:
    """Two numbers in (0, 1) for each generator, and the halves of the next states."""
    first = advanced(a, b)
    second = advanced(*first)
    return (uniform(*first), uniform(*second)), *second


@skip_if_zero
def _normal(none: Number, first: Number, second: Number, wanted: Number) -> Number:
    """Standard normal numbers from two in (0, 1) for each, where they are wanted."""
    return where(wanted > 0, sqrt(-2.0 * log(first)) * cos(2.0 * math.pi * second), none)


def advanced(a: Number, b: Number) -> tuple[Number, Number]:
    """Next state of each generator, in the two halves."""
    return _multiplied(a, _FACTOR_A, _MODULUS_A), _multiplied(b, _FACTOR_B, _MODULUS_B)


def _multiplied(state: Number, factor: float, modulus: float) -> Number:
    """Remainder of a product by a prime.

    None is a multiple of it, so that the rounding of its reciprocal never reaches the next whole number.
    """
    product = factor * state
    return product - modulus * floor(product * (1.0 / modulus))


def uniform(a: Number, b: Number) -> Number:
    """Number in (0, 1) that belongs to the state of each generator."""
    difference = a - b
    return (difference + (_MODULUS_A - 1.0) * (difference < 1)) / _MODULUS_A


def _mixed(number: Number) -> Number:
    """Whole number from 1 to 127 times the mixing modulus, which stays below either generator's modulus."""
    mixed = _remainder(number, _MIXING_MODULUS)
    for _ in range(3):
        mixed = _remainder(mixed * mixed + 31337.0, _MIXING_MODULUS)
    return 127.0 * mixed + 1.0


def _remainder(value: Number, modulus: float) -> Number:
    return value - modulus * floor(value / modulus)
