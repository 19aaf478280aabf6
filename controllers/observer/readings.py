"""How an observer takes in its thermometers: one reading after the other, each judged before it is used."""

from __future__ import annotations

from warmlink.controllers import fail_safe
from warmlink.controllers.kalman import Belief, corrected, variance_along
from warmlink.controllers.matrices import dot
from warmlink.controllers.observer.filters import Filters, believed_spread
from warmlink.controllers.observer.model import MODES, SENSORS, sensor_row
from warmlink.fmus.calls import kept_whole
from warmlink.fmus.component import Record
from warmlink.fmus.component.arithmetic import Number, stack, where


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
    gates = fail_safe.gates_of(p)
    means, calm, out = [], [], []
    for i in range(SENSORS):
        row = stack(sensor_row(i, p), *[0.0] * (filters.alert.mean.shape[0] - MODES))
        signal = fail_safe.Trust(*(each[i] for each in trust))
        relative = readings[i] - p.linearisation_temperature
        variance, verdict = judge(
            filters.alert, signal, row, relative, p.sensor_std[i], news[i], seen, gates, step
        )
        filters = Filters(*(take(belief, row, relative, variance, verdict.use) for belief in filters))
        means.append(verdict.mean)
        calm.append(verdict.calm_for)
        out.append(verdict.out)
    return filters, trust._replace(mean=stack(*means), calm_for=stack(*calm), out=stack(*out))


@kept_whole
def judge(
    alert: Belief,
    trust: fail_safe.Trust,
    row: Number,
    reading: Number,
    std: Number,
    news: Number,
    seen: Number,
    gates: fail_safe.Gates,
    step: Number,
) -> tuple[Number, fail_safe.Judgement]:
    """The variance of a reading's noise in K2, and the verdict on it.

    Parameters
    ----------
    alert : belief of the alert filter
    trust : memory of this sensor
    row : derivative of the reading by the state, shape (n,)
    reading : in K above the temperature of linearisation
    std : standard deviation of its noise in K; 0 where the sensor is not in use
    news : 1 if the reading is present and new, else 0
    """
    used = where(std > 0, 1.0, 0.0)
    variance = where(used > 0, std**2, 1.0)
    widest = variance_along(alert.spread, row) + variance
    sure = variance_along(believed_spread(alert, alert, seen), row) + variance
    innovation = reading - dot(row, alert.mean)
    verdict = fail_safe.judged(trust, used * news, innovation, widest, sure, gates, step)
    return variance, verdict._replace(out=used * verdict.out)


@kept_whole
def take(belief: Belief, row: Number, reading: Number, variance: Number, use: Number) -> Belief:
    """Belief after a reading in K above the temperature of linearisation."""
    return corrected(belief, row, reading - dot(row, belief.mean), variance, use)
