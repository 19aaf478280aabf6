"""Two filters side by side: one alert to unknown heat, one quiet, and which of them leads.

The alert filter expects unknown heat of the designed size all the time. It therefore follows a heating pad
within minutes and distinguishes it from a failing sensor, but lets through more of the thermometers' noise.
The quiet filter expects only the share `quiet_share` of that heat, and its innovations are white while
there is none. It uses a reading whenever the alert filter does, and the law reports its estimate. While
unknown heat is certain, and for as long as it is remembered, the alert filter leads: the quiet one
continues from it. Both take in the thermometers one reading after the other, each judged before it is used.
"""

from typing import NamedTuple

from warmlink.controllers import fail_safe
from warmlink.controllers.kalman import (
    Belief,
    CrossCovariance,
    Gain,
    covariance_along,
    cross_covariance,
    either,
    gain_of,
    updated,
)
from warmlink.controllers.matrices import dot, outer, packed_size, upper, upper_diagonal
from warmlink.controllers.observer.model import HEATS, MODES, SENSORS, STATES, sensor_row
from warmlink.fmus.calls import as_c_function, skip_if_zero, vectorised_pair
from warmlink.fmus.component import Record, State
from warmlink.fmus.component.arithmetic import (
    Number,
    beside,
    clip,
    maximum,
    minimum,
    side,
    stack,
    total,
    truth,
    where,
)

EVIDENCE_SIGMAS = 3.0
"""Standard deviations of its noise beyond which an estimated disturbance counts as detected."""

CERTAIN_SIGMAS = 5.0
"""Standard deviations beyond which unknown heat is certain.

Among the thousands of estimates in a shift, chance exceeds three every hour, but five in hardly any shift.
"""

LARGEST_EVIDENCE = 4.0
"""Bound on the squared ratio of disturbances seen to disturbances designed for."""

_NAMES = ("estimate", "spread", "noise_spread")
"""States that hold both filters."""


class Filters(Belief):
    """The two beliefs side by side: of every number first the alert filter's, then the quiet one's."""

    @property
    def alert(self) -> Belief:
        """The alert filter's belief."""
        return Belief(*(side(0, each) for each in self))

    @property
    def quiet(self) -> Belief:
        """The quiet filter's belief."""
        return Belief(*(side(1, each) for each in self))


def together(alert: Belief, quiet: Belief) -> Filters:
    """Two beliefs side by side."""
    return Filters(*(beside(*each) for each in zip(alert, quiet, strict=True)))


def filter_states(size: int) -> tuple[State, ...]:
    """States that hold both beliefs, each of `size` elements."""
    sizes = Belief(mean=size, spread=packed_size(size), noise_spread=packed_size(size))
    return tuple(
        State(name, "1", size=2 * count, slow=name != "noise_spread")
        for name, count in zip(_NAMES, sizes, strict=True)
    )


def filters_of(x: Record) -> Filters:
    """Both beliefs as they lie in a law's states."""
    return Filters(*(getattr(x, name) for name in _NAMES))


def filters_named(filters: Filters) -> dict[str, Number]:
    """Both beliefs under the names of a law's states."""
    return dict(zip(_NAMES, filters, strict=True))


def allowed_for(designed: Number, share: Number) -> Number:
    """Process-noise variances per step, where a share of profile errors and heats is expected.

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


def led(filters: Filters, seen: Number, begun_again: Number, p: Record) -> Filters:
    """The filters after it is decided which of them leads.

    Parameters
    ----------
    seen : evidence of disturbances, squared and relative to those designed for, what is remembered included
    begun_again : 1 where the alert filter has just begun again from the duty, else 0
    """
    return _followed(filters, p, alert_leads(filters, seen, begun_again, p))


@as_c_function
def alert_leads(filters: Filters, seen: Number, begun_again: Number, p: Record) -> Number:
    """1 where the alert filter leads, else 0; the arguments as for `led`."""
    alert = filters.alert
    heats = alert.mean[MODES:STATES]
    noise = upper_diagonal(alert.noise_spread, alert.mean.shape[0])[MODES:STATES]
    certain = total(truth(heats**2 > CERTAIN_SIGMAS**2 * noise))
    by_noise = noise / p.disturbance_std[:HEATS] ** 2
    least = (CERTAIN_SIGMAS**2 - EVIDENCE_SIGMAS**2) * maximum(by_noise[0], by_noise[1])
    remembered = truth(seen > least)
    return truth(certain + remembered + begun_again > 0)


@skip_if_zero
def _followed(filters: Filters, p: Record, leads: Number) -> Filters:
    """The filters, the quiet one's belief following from the alert one's where that one leads."""
    alert = filters.alert
    return together(alert, either(leads, quieted(alert, p), filters.quiet))


@as_c_function
def evidence(before: Number, filters: Filters, of: tuple[int, int], p: Record, fades: Number) -> Number:
    """How strong the alert filter sees disturbances to be: squared, relative to those designed for.

    An estimate within three standard deviations of what noise alone makes of it is none; a larger one is
    remembered while it fades.

    Parameters
    ----------
    before : the evidence so far
    of : first of the disturbances, and the one after the last
    fades : 1 where what is remembered fades in this sample, else 0
    """
    asked, belief = slice(*of), filters.alert
    doubt = upper_diagonal(belief.noise_spread, belief.mean.shape[0])[MODES:][asked]
    excess = (belief.mean[MODES:][asked] ** 2 - EVIDENCE_SIGMAS**2 * doubt) / p.disturbance_std[asked] ** 2
    seen: Number = before * where(fades > 0, p.fade[0], 1.0)
    for i in range(excess.shape[0]):
        seen = maximum(seen, excess[i])
    return clip(seen, 0.0, LARGEST_EVIDENCE)


def believed_variance(
    belief: Belief, alert: Belief, row: Number, seen: Number, taught: Number = 0.0
) -> Number:
    """Variance along a row of a belief's error: its noise, and what disturbances as they are seen to be add.

    What they add is counted as in the alert filter: by heat that is seen in temperatures and heats, by what a
    camera has taught in the elements after them, and by the weaker evidence of the two between them.
    """
    own = stack(row[:STATES], *[0.0] * (row.shape[0] - STATES))
    other = stack(*[0.0] * STATES, row[STATES:])

    def unknown(a: Number, b: Number) -> Number:
        return covariance_along(alert.spread, a, b) - covariance_along(alert.noise_spread, a, b)

    added = seen * unknown(own, own)
    if row.shape[0] > STATES:
        added = added + taught * unknown(other, other) + 2.0 * minimum(seen, taught) * unknown(own, other)
    return maximum(covariance_along(belief.noise_spread, row, row) + added, 0.0)


def sense(
    filters: Filters,
    trust: fail_safe.Trust,
    readings: Number,
    news: Number,
    seen: Number,
    p: Record,
    step: Number,
) -> tuple[Filters, fail_safe.Trust]:
    """Beliefs and trust after the readings, taken one after the other; the alert filter judges them."""
    gates = fail_safe.gates_of(p, step)
    memories = []
    for i in range(SENSORS):
        reading = Reading(sensor_row(i, p), readings[i] - p.linearisation_temperature, p.sensor_std[i])
        memory = fail_safe.Memory(trust.mean[i], trust.calm_for[i], trust.out[i])
        used = truth(p.sensor_std[i] > 0)
        filters, memory = _taken((filters, memory), reading, news[i], seen, gates, step, used)
        memories.append(memory)
    mean, calm_for, out = (stack(*each) for each in zip(*memories, strict=True))
    return filters, trust._replace(mean=mean, calm_for=calm_for, out=out)


class Reading(NamedTuple):
    """A thermometer's reading.

    Attributes
    ----------
    row : derivative of the temperature by the modes, shape (7,)
    value : in K above the temperature of linearisation
    std : standard deviation of its noise in K; 0 where the sensor is not in use
    """

    row: Number
    value: Number
    std: Number


@skip_if_zero
def _taken(
    before: tuple[Filters, fail_safe.Memory],
    reading: Reading,
    news: Number,
    seen: Number,
    gates: fail_safe.Gates,
    step: Number,
    used: Number,
) -> tuple[Filters, fail_safe.Memory]:
    """Both filters and the sensor's memory after the alert filter has accepted or rejected a reading.

    Parameters
    ----------
    news : 1 if the reading is present and new, else 0
    used : 1 where the sensor is in use, else 0
    """
    filters, memory = before
    across = _both_across(filters, reading.row)
    memory, gain, variance = _gated(memory, filters.mean, across, reading, news, seen, gates, step, used)
    return Filters(*_both_updated(filters, across, gain, reading.row, variance)), memory


_both_across, _both_updated = vectorised_pair(cross_covariance, 1), vectorised_pair(updated, 3)
"""Cross covariances of both filters with a measurement, and both filters after it."""


@as_c_function
def _gated(
    memory: fail_safe.Memory,
    mean: Number,
    across: CrossCovariance,
    reading: Reading,
    news: Number,
    seen: Number,
    gates: fail_safe.Gates,
    step: Number,
    used: Number,
) -> tuple[fail_safe.Memory, Gain, Number]:
    """What is remembered of a sensor, the gain of its reading in both filters, and its variance in K2."""
    variance = where(reading.std > 0, reading.std**2, 1.0)
    alert, quiet = (CrossCovariance(*(side(k, each) for each in across)) for k in range(2))
    expected, by_noise = (dot(reading.row, each[:MODES]) for each in alert)
    widest = maximum(expected, 0.0) + variance
    sure = maximum(by_noise + seen * (expected - by_noise), 0.0) + variance
    innovations = [reading.value - dot(reading.row, side(k, mean)[:MODES]) for k in range(2)]
    use, after = fail_safe.gate_reading(memory, used * news, innovations[0], widest, sure, gates, step)
    both = zip((alert, quiet), innovations, strict=True)
    gains = [gain_of(reading.row, each, innovation, variance, use) for each, innovation in both]
    memory = fail_safe.Memory(*(where(used > 0, *each) for each in zip(after, memory, strict=True)))
    return memory, Gain(*(beside(*each) for each in zip(*gains, strict=True))), variance
