"""The filters a sample later: losses, surroundings and unknown heat drive the modes, and errors grow."""

from functools import partial
from typing import NamedTuple

from warmlink.controllers.kalman import carried_over
from warmlink.controllers.matrices import blocks, diagonal, matrix, outer, upper
from warmlink.controllers.observer.filters import Filters, allowed_for
from warmlink.controllers.observer.model import MODES, BelievedDuty, known_heat
from warmlink.fmus.calls import as_c_function, vectorised_pair
from warmlink.fmus.component import Record
from warmlink.fmus.component.arithmetic import Number, absolute, beside, placed, stack


def predict(filters: Filters, u: BelievedDuty, p: Record) -> Filters:
    """Beliefs one sample later: losses, ambient temperature and unknown heat drive the modes."""
    errors = _errors(u.speed, p)
    return Filters(
        _mean_later(filters.mean, u, p),
        _carried_over(filters.spread, errors.added, errors.own, errors.by_heat, p.fade),
        _carried_over(filters.noise_spread, 0.0 * errors.added, errors.own, errors.by_heat, p.fade),
    )


@partial(vectorised_pair, paired=1)
def _mean_later(mean: Number, u: BelievedDuty, p: Record) -> Number:
    """The estimate one sample later."""
    modes, disturbances = mean[:MODES], mean[MODES:]
    unknown_heat = p.shaft_heat_gain * disturbances[0] + p.link_heat_gain * disturbances[1]
    drive = known_heat(modes, u, p) + unknown_heat
    return stack(p.decay * modes + p.reach * drive, p.fade * disturbances)


class Errors(NamedTuple):
    """What a sample does to the errors.

    Attributes
    ----------
    own : of each mode, what is left of it
    by_heat : what each mode gains of each unknown heat
    added : variances that either filter adds, side by side
    """

    own: Number
    by_heat: tuple[Number, Number]
    added: Number


@as_c_function
def _errors(speed: Number, p: Record) -> Errors:
    # Only the diagonal of convection's effect on the errors is kept: the rest is a hundredth of it.
    own = p.decay + p.reach * absolute(speed) * diagonal(matrix(p.convection, MODES))
    designed = stack(p.profile_std**2 * (1.0 - p.decay**2), p.disturbance_std**2 * (1.0 - p.fade**2))
    added = beside(*(allowed_for(designed, share) for share in (1.0, p.quiet_share)))
    return Errors(own, (p.reach * p.shaft_heat_gain, p.reach * p.link_heat_gain), added)


@partial(vectorised_pair, paired=2)
def _carried_over(
    packed: Number, added: Number, own: Number, by_heat: tuple[Number, Number], fade: Number
) -> Number:
    """Covariance of the errors one sample later, packed, with the variances that are added."""
    count = fade.shape[0]
    gained = outer(by_heat[0], placed(1.0, 0, count)) + outer(by_heat[1], placed(1.0, 1, count))
    transition = blocks(diagonal(own), gained, diagonal(fade))
    return carried_over(packed, transition) + upper(diagonal(added))
