"""Steps of a Kalman filter that computes its gain and its reported error from two different covariances.

The gain follows from `spread`, the covariance of the error if unknown heat of the expected size acts all
the time. The reported error follows from `noise_spread`, the covariance with the same gain if no unknown
heat acts (Joseph's form, which is valid for any gain). Their difference is the effect of unknown heat of
that size. R. F. Stengel, *Optimal Control and Estimation*, Dover 1994, chapter 4.
"""

from typing import NamedTuple

from warmlink.controllers.matrices import dot, outer, symmetric, upper
from warmlink.fmus.calls import kept_whole
from warmlink.fmus.component.arithmetic import Number, maximum, stack, where


class Belief(NamedTuple):
    """An estimate, shape (n,), and its two covariances, each as the rows of its upper triangle."""

    mean: Number
    spread: Number
    noise_spread: Number


def carried_over(packed: Number, transition: Number) -> Number:
    """Covariance of errors, packed, that a matrix of shape (n, n) carries over a step."""
    return upper(transition @ symmetric(packed, transition.shape[0]) @ transition.T)


class Sight(NamedTuple):
    """Covariances of the state with what is measured, shape (n,), by either covariance of a belief."""

    spread: Number
    noise_spread: Number


@kept_whole
def sighted(belief: Belief, row: Number) -> Sight:
    """How a belief sees what is measured.

    Parameters
    ----------
    row : derivative of the measured quantity by the first elements of the state; by the others it is 0
    """
    size = belief.mean.shape[0]
    row = stack(row, *[0.0] * (size - row.shape[0]))
    return Sight(*(symmetric(each, size) @ row for each in belief[1:]))


class Counts(NamedTuple):
    """What a measurement counts.

    Attributes
    ----------
    share : of what `Sight` has, that the state changes for each unit of innovation
    times : share times innovation
    """

    share: Number
    times: Number


def counted(row: Number, sight: Sight, innovation: Number, variance: Number, use: Number) -> Counts:
    """What a scalar measurement counts, by the covariance `spread`; nothing where `use` is 0.

    Parameters
    ----------
    row : as for `sighted`
    innovation : measured minus predicted; of no effect, and may be NaN, where it is not used
    variance : variance of the measurement's noise
    use : 1 to use the measurement, 0 to leave it out
    """
    share = use / (maximum(dot(row, sight.spread[: row.shape[0]]), 0.0) + variance)
    return Counts(share, share * where(use > 0, innovation, 0.0))


def taught(belief: Belief, sight: Sight, counts: Counts, row: Number, variance: Number) -> Belief:
    """Belief after a scalar measurement that counts so much."""
    gain = sight.spread * counts.share
    return Belief(
        belief.mean + sight.spread * counts.times,
        # The gain is the best there is for this covariance, so that Joseph's form is simple.
        belief.spread - upper(outer(gain, sight.spread)),
        _after(belief.noise_spread, row, sight.noise_spread, gain, variance),
    )


def taught_in_part(
    belief: Belief, sight: Sight, counts: Counts, row: Number, variance: Number, last: int
) -> Belief:
    """Belief as for `taught`, where the measurement may change only the state's `last` so many elements."""
    seen = sight.spread[-last:]
    gain, change = (stack(*[0.0] * (row.shape[0] - last), each * seen) for each in counts)
    seen_by = zip(belief[1:], sight, strict=True)
    return Belief(belief.mean + change, *(_after(each, row, of, gain, variance) for each, of in seen_by))


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
