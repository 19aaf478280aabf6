"""Steps of a Kalman filter that computes its gain and its reported error from two different covariances.

The gain follows from `spread`, the covariance of the error if unknown heat of the expected size acts all
the time. The reported error follows from `noise_spread`, the covariance with the same gain if no unknown
heat acts (Joseph's form, which is valid for any gain). Their difference is the effect of unknown heat of
that size. R. F. Stengel, *Optimal Control and Estimation*, Dover 1994, chapter 4.
"""

from __future__ import annotations

from typing import NamedTuple

from warmlink.controllers.matrices import dot, outer, product, symmetric, upper
from warmlink.fmus.calls import kept_whole
from warmlink.fmus.component.arithmetic import Number, maximum, where


class Belief(NamedTuple):
    """An estimate, shape (n,), and its two covariances, each as the rows of its upper triangle."""

    mean: Number
    spread: Number
    noise_spread: Number


def carried(belief: Belief, transition: Number, mean: Number, disturbance: Number) -> Belief:
    """Belief one step later.

    Parameters
    ----------
    transition : matrix by which errors are carried over, shape (n, n)
    mean : the estimate one step later
    disturbance : covariance that unknown heat adds in the step, as the rows of its upper triangle
    """
    spread = _carried_over(belief.spread, transition)
    return Belief(mean, spread + disturbance, _carried_over(belief.noise_spread, transition))


@kept_whole
def _carried_over(packed: Number, transition: Number) -> Number:
    covariance = symmetric(packed, transition.shape[0])
    return upper(product(product(transition, covariance), transition.T))


@kept_whole
def corrected(
    belief: Belief,
    row: Number,
    innovation: Number,
    variance: Number,
    use: Number,
    teaches: Number | None = None,
) -> Belief:
    """Belief after one scalar measurement; unchanged where `use` is 0.

    Parameters
    ----------
    row : derivative of the measured quantity by the state, shape (n,)
    innovation : measured minus predicted; of no effect, and may be NaN, where it is not used
    variance : variance of the measurement's noise
    use : 1 to use the measurement, 0 to leave it out
    teaches : 1 for the elements of the state that the measurement may change, 0 for the others, shape (n,);
        all of them where it is not given
    """
    covariance = symmetric(belief.spread, row.shape[0])
    across = product(covariance, row)
    gain = across * (use / (maximum(dot(row, across), 0.0) + variance))
    if teaches is None:  # the gain is the best there is for this covariance, and Joseph's form is simple
        spread = upper(covariance - outer(gain, across))
    else:
        gain = teaches * gain
        spread = _after(belief.spread, row, gain, variance)
    return Belief(
        belief.mean + gain * where(use > 0, innovation, 0.0),
        spread,
        _after(belief.noise_spread, row, gain, variance),
    )


@kept_whole
def either(which: Number, one: Belief, other: Belief) -> Belief:
    """The one belief where `which` is 1, the other where it is 0, without a branch for each number."""
    return Belief(*(which * a + (1.0 - which) * b for a, b in zip(one, other, strict=True)))


@kept_whole
def variance_along(packed: Number, row: Number) -> Number:
    """Variance of a quantity whose derivative by the state is `row`; rounding leaves none below 0."""
    return maximum(dot(row, product(symmetric(packed, row.shape[0]), row)), 0.0)


def _after(packed: Number, row: Number, gain: Number, variance: Number) -> Number:
    """Covariance after a scalar measurement taken with any gain: Joseph's form, multiplied out."""
    covariance = symmetric(packed, row.shape[0])
    across = product(covariance, row)
    change = outer(gain, across)
    return upper(covariance - change - change.T + (dot(row, across) + variance) * outer(gain, gain))
