"""Two filters side by side: one alert to unknown heat, one quiet, and which of them leads.

The alert filter expects unknown heat of the designed size all the time. It therefore follows a heating pad
within minutes and distinguishes it from a failing sensor, but lets through more of the thermometers' noise.
The quiet filter expects only the share `quiet_share` of that heat, and its innovations are white while
there is none. It uses a reading whenever the alert filter does, and the law reports its estimate. While
unknown heat is certain, and for as long as it is remembered, the alert filter leads: the quiet one
continues from it.
"""

from __future__ import annotations

from typing import NamedTuple

from warmlink.controllers.kalman import Belief, either
from warmlink.controllers.matrices import outer, packed_size, upper, upper_diagonal
from warmlink.controllers.observer.model import HEATS, MODES, STATES
from warmlink.fmus.calls import kept_whole
from warmlink.fmus.component import Record, State
from warmlink.fmus.component.arithmetic import Number, clip, exp, maximum, minimum, stack, total, where

EVIDENCE_SIGMAS = 3.0
"""Standard deviations of its noise beyond which an estimated disturbance counts as detected."""

CERTAIN_SIGMAS = 5.0
"""Standard deviations beyond which unknown heat is certain.

Among the thousands of estimates in a shift, chance exceeds three every hour, but five in hardly any shift.
"""

LARGEST_EVIDENCE = 4.0
"""Bound on the squared ratio of disturbances seen to disturbances designed for."""

_PREFIXES = ("", "quiet_")
"""What the names of each filter's states begin with."""


class Filters(NamedTuple):
    """The two beliefs, of the same size."""

    alert: Belief
    quiet: Belief


def filter_states(size: int) -> tuple[State, ...]:
    """States that hold both beliefs, each of `size` elements."""
    sizes = Belief(mean=size, spread=packed_size(size), noise_spread=packed_size(size))
    return tuple(
        State(name, "1", size=count)
        for prefix in _PREFIXES
        for name, count in zip(_names(prefix), sizes, strict=True)
    )


def filters_of(x: Record) -> Filters:
    """Both beliefs as they lie in a law's states."""
    return Filters(*(Belief(*(getattr(x, name) for name in _names(prefix))) for prefix in _PREFIXES))


def filters_named(filters: Filters) -> dict[str, Number]:
    """Both beliefs under the names of a law's states."""
    named: dict[str, Number] = {}
    for prefix, belief in zip(_PREFIXES, filters, strict=True):
        named.update(zip(_names(prefix), belief, strict=True))
    return named


def allowed_for(designed: Number, share: Number) -> Number:
    """Variances that what is unknown adds in a step, where a share of profile errors and heats is expected.

    What a camera reveals is no heat, and stays as designed.
    """
    others = designed.shape[0] - STATES
    return stack(*[share] * STATES, *[1.0] * others) ** 2 * designed


def quieted(alert: Belief, p: Record) -> Belief:
    """The belief from which the quiet filter goes on: the alert one's, with less doubt about unknown heat.

    The elongation's variance is the same in both, since the heats have no direct part in it.
    """
    others = alert.mean.shape[0] - STATES
    share = stack(*[1.0] * MODES, *[p.quiet_share] * HEATS, *[1.0] * others)
    return alert._replace(spread=upper(outer(share, share)) * alert.spread)


@kept_whole
def led(filters: Filters, seen: Number, begun_again: Number, p: Record) -> Filters:
    """The filters after it is decided which of them leads.

    Parameters
    ----------
    seen : evidence of disturbances, squared and relative to those designed for, what is remembered included
    begun_again : 1 where the alert filter has just begun again from the duty, else 0
    """
    alert, quiet = filters
    heats = alert.mean[MODES:STATES]
    noise = upper_diagonal(alert.noise_spread, alert.mean.shape[0])[MODES:STATES]
    certain = total(where(heats**2 > CERTAIN_SIGMAS**2 * noise, 1.0, 0.0))
    by_noise = noise / p.disturbance_std[:HEATS] ** 2
    least = (CERTAIN_SIGMAS**2 - EVIDENCE_SIGMAS**2) * maximum(by_noise[0], by_noise[1])
    remembered = where(seen > least, 1.0, 0.0)
    alert_leads = where(certain + remembered + begun_again > 0, 1.0, 0.0)
    return Filters(alert, either(alert_leads, quieted(alert, p), quiet))


@kept_whole
def evidence(before: Number, belief: Belief, of: tuple[int, int], p: Record, elapsed: Number) -> Number:
    """How strong disturbances are seen to be: squared, relative to those designed for.

    An estimate within three standard deviations of what noise alone makes of it is none; a larger one is
    remembered while it fades.

    Parameters
    ----------
    before : the evidence so far
    of : first of the disturbances, and the one after the last
    elapsed : time in s over which what is remembered fades
    """
    asked = slice(*of)
    doubt = upper_diagonal(belief.noise_spread, belief.mean.shape[0])[MODES:][asked]
    excess = (belief.mean[MODES:][asked] ** 2 - EVIDENCE_SIGMAS**2 * doubt) / p.disturbance_std[asked] ** 2
    seen: Number = before * exp(-elapsed / p.disturbance_time[0])
    for i in range(excess.shape[0]):
        seen = maximum(seen, excess[i])
    return clip(seen, 0.0, LARGEST_EVIDENCE)


def believed_spread(belief: Belief, alert: Belief, seen: Number, taught: Number = 0.0) -> Number:
    """Covariance of a belief's error: its noise, and what disturbances as strong as they are seen to be add.

    What they add is counted as in the alert filter: by heat that is seen in temperatures and heats, by what a
    camera has taught in the elements after them, and by the weaker evidence of the two between them.
    """
    added = alert.spread - alert.noise_spread
    own = stack(*[1.0] * STATES, *[0.0] * (belief.mean.shape[0] - STATES))
    both = minimum(seen, taught)
    share = both + (seen - both) * outer(own, own) + (taught - both) * outer(1.0 - own, 1.0 - own)
    return belief.noise_spread + upper(share) * added


def _names(prefix: str) -> tuple[str, ...]:
    return tuple(f"{prefix}{name}" for name in ("estimate", "spread", "noise_spread"))
