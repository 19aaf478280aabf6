"""The filters a sample later: losses, surroundings and unknown heat drive the modes, and errors grow."""

from functools import partial
from typing import NamedTuple

from warmlink.controllers.matrices import diagonal, matrix, outer, symmetric, upper
from warmlink.controllers.observer.filters import Filters, allowed_for
from warmlink.controllers.observer.model import MODES, BelievedDuty, known_heat
from warmlink.fmus.calls import as_c_function, vectorised_pair
from warmlink.fmus.component import Record
from warmlink.fmus.component.arithmetic import Number, absolute, accumulated, beside, stack


def predict(filters: Filters, u: BelievedDuty, p: Record) -> Filters:
    """Beliefs one sample later: losses, ambient temperature and unknown heat drive the modes."""
    errors = _errors(u.speed, p)
    none = 0.0 * errors.added
    return Filters(
        _mean_later(filters.mean, u, p),
        _carried_over(filters.spread, errors.added, errors.lost, errors.lost_alike, errors.by_heat),
        _carried_over(filters.noise_spread, none, errors.lost, errors.lost_alike, errors.by_heat),
    )


@partial(vectorised_pair, paired=1)
def _mean_later(mean: Number, u: BelievedDuty, p: Record) -> Number:
    """The estimate one sample later."""
    modes, disturbances = mean[:MODES], mean[MODES:]
    unknown_heat = p.shaft_heat_gain * disturbances[0] + p.link_heat_gain * disturbances[1]
    drive = known_heat(modes, u, p) + unknown_heat
    change = stack((p.decay - 1.0) * modes + p.reach * drive, (p.fade - 1.0) * disturbances)
    return accumulated(mean, change)


class Errors(NamedTuple):
    """What a sample does to the errors.

    Attributes
    ----------
    lost : of each element of the state, the share by which it changes, shape (n,)
    lost_alike : of each covariance, the share by which these change it, packed
    by_heat : what each mode gains of each unknown heat; 0 for the elements after the modes, shapes (n,)
    added : variances that either filter adds, side by side
    """

    lost: Number
    lost_alike: Number
    by_heat: tuple[Number, Number]
    added: Number


@as_c_function
def _errors(speed: Number, p: Record) -> Errors:
    # Only the diagonal of convection's effect on the errors is kept: the rest is a hundredth of it.
    modes = (p.decay - 1.0) + p.reach * absolute(speed) * diagonal(matrix(p.convection, MODES))
    lost = stack(modes, p.fade - 1.0)
    one = lost * 0.0 + 1.0
    alike = upper(outer(lost, one) + outer(one, lost) + outer(lost, lost))
    designed = stack(p.profile_std**2 * (1.0 - p.decay**2), p.disturbance_std**2 * (1.0 - p.fade**2))
    added = beside(*(allowed_for(designed, share) for share in (1.0, p.quiet_share)))
    none = p.fade * 0.0
    by_heat = tuple(stack(p.reach * gain, none) for gain in (p.shaft_heat_gain, p.link_heat_gain))
    return Errors(lost, alike, (by_heat[0], by_heat[1]), added)


@partial(vectorised_pair, paired=2)
def _carried_over(
    packed: Number, added: Number, lost: Number, lost_alike: Number, by_heat: tuple[Number, Number]
) -> Number:
    """Covariance of the errors one sample later, packed, with the variances that are added.

    F P F^T with F = 1 + diag(lost) + G, where G has the two columns `by_heat`, as what it changes.
    """
    before = symmetric(packed, lost.shape[0])
    change = lost_alike * packed + upper(diagonal(added))
    for k, gained in enumerate(by_heat):
        of_heat = before[:, MODES + k]
        half = [0.5 * before[MODES + j, MODES + k] * each for j, each in enumerate(by_heat)]
        across = of_heat + lost * of_heat + half[0] + half[1]
        change = change + upper(outer(across, gained) + outer(gained, across))
    return accumulated(packed, change)
