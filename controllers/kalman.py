"""Steps of a Kalman filter that computes its gain and its reported error from two different covariances.

The gain follows from `spread`, the covariance of the error if unknown heat of the expected size acts all
the time. The reported error follows from `noise_spread`, the covariance with the same gain if no unknown
heat acts (Joseph's form, which is valid for any gain). Their difference is the effect of unknown heat of
that size. R. F. Stengel, *Optimal Control and Estimation*, Dover 1994, chapter 4.
"""

from typing import NamedTuple

from warmlink.controllers.matrices import dot, outer, symmetric, upper
from warmlink.fmus.calls import as_c_function
from warmlink.fmus.component.arithmetic import Number, accumulated, maximum, stack, where


class Belief(NamedTuple):
    """An estimate, shape (n,), and its two covariances, each as the rows of its upper triangle."""

    mean: Number
    spread: Number
    noise_spread: Number


def carried_over(packed: Number, transition: Number) -> Number:
    """Covariance of errors, packed, that a matrix of shape (n, n) carries over a step."""
    return upper(transition @ symmetric(packed, transition.shape[0]) @ transition.T)


class CrossCovariance(NamedTuple):
    """Covariances of the state with what is measured, shape (n,), by either covariance of a belief."""

    spread: Number
    noise_spread: Number


@as_c_function
def cross_covariance(belief: Belief, row: Number) -> CrossCovariance:
    """Covariances of the state with a scalar measurement, for both covariances of a belief.

    Parameters
    ----------
    row : derivative of the measured quantity by the first elements of the state; by the others it is 0
    """
    size = belief.mean.shape[0]
    row = stack(row, *[0.0] * (size - row.shape[0]))
    return CrossCovariance(*(symmetric(each, size) @ row for each in belief[1:]))


class Gain(NamedTuple):
    """How far a measurement moves the state.

    Attributes
    ----------
    share : change of the state for each unit of innovation, divided by the cross covariance
    times : share times innovation
    """

    share: Number
    times: Number


def gain_of(row: Number, across: CrossCovariance, innovation: Number, variance: Number, use: Number) -> Gain:
    """Gain of a scalar measurement by the covariance `spread`; 0 where `use` is 0.

    Parameters
    ----------
    row : as for `cross_covariance`
    innovation : measured minus predicted; of no effect, and may be NaN, where it is not used
    variance : variance of the measurement's noise
    use : 1 to use the measurement, 0 to leave it out
    """
    share = use / (maximum(dot(row, across.spread[: row.shape[0]]), 0.0) + variance)
    return Gain(share, share * where(use > 0, innovation, 0.0))


def updated(belief: Belief, across: CrossCovariance, gain: Gain, row: Number, variance: Number) -> Belief:
    """Belief after a scalar measurement, by the gain of that measurement."""
    moved = across.spread * gain.share
    return Belief(
        accumulated(belief.mean, across.spread * gain.times),
        # The gain is the best there is for this covariance, so that Joseph's form is simple.
        accumulated(belief.spread, -upper(outer(moved, across.spread))),
        _after(belief.noise_spread, row, across.noise_spread, moved, variance),
    )


def updated_in_part(
    belief: Belief, across: CrossCovariance, gain: Gain, row: Number, variance: Number, last: int
) -> Belief:
    """Belief as for `updated`, where the measurement may change only the state's `last` so many elements."""
    seen = across.spread[-last:]
    moved, change = (stack(*[0.0] * (row.shape[0] - last), each * seen) for each in gain)
    seen_by = zip(belief[1:], across, strict=True)
    return Belief(belief.mean + change, *(_after(each, row, of, moved, variance) for each, of in seen_by))


def either(which: Number, one: Belief, other: Belief) -> Belief:
    """The one belief where `which` is 1, the other where it is 0, without a branch for each number."""
    return Belief(*(which * a + (1.0 - which) * b for a, b in zip(one, other, strict=True)))


def covariance_along(packed: Number, a: Number, b: Number) -> Number:
    """Covariance of two quantities whose derivatives by the state are `a` and `b`."""
    return dot(a, symmetric(packed, a.shape[0]) @ b)


def variance_along(packed: Number, row: Number) -> Number:
    """Variance of a quantity whose derivative by the state is `row`; rounding leaves none below 0."""
    return maximum(covariance_along(packed, row, row), 0.0)


def _after(packed: Number, row: Number, across: Number, gain: Number, variance: Number) -> Number:
    """Covariance after a scalar measurement taken with any gain: Joseph's form, multiplied out."""
    rest = across - 0.5 * (dot(row, across[: row.shape[0]]) + variance) * gain
    return packed - upper(outer(gain, rest)) - upper(outer(rest, gain))
