"""How an observer takes in its thermometers: one reading after the other, each judged before it is used."""

from __future__ import annotations

from typing import NamedTuple

from warmlink.controllers import fail_safe
from warmlink.controllers.kalman import Sight, sighted, taught
from warmlink.controllers.matrices import dot
from warmlink.controllers.observer.filters import Filters
from warmlink.controllers.observer.model import MODES, SENSORS, sensor_row
from warmlink.fmus.calls import idle_at_zero, kept_whole
from warmlink.fmus.component import Record
from warmlink.fmus.component.arithmetic import Number, maximum, stack, truth, where


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
        memory = Memory(trust.mean[i], trust.calm_for[i], trust.out[i])
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


class Memory(NamedTuple):
    """What `fail_safe.Trust` remembers of one sensor's innovations."""

    mean: Number
    calm_for: Number
    out: Number


@idle_at_zero
def _taken(
    before: tuple[Filters, Memory],
    reading: Reading,
    news: Number,
    seen: Number,
    gates: fail_safe.Gates,
    step: Number,
    used: Number,
) -> tuple[Filters, Memory]:
    """Both filters and the sensor's memory after the alert filter has judged a reading.

    Parameters
    ----------
    news : 1 if the reading is present and new, else 0
    used : 1 where the sensor is in use, else 0
    """
    filters, memory = before
    sights = [sighted(each, reading.row) for each in filters]
    mean, sight = filters.alert.mean, sights[0]
    memory, variance, use = _judged(memory, mean, sight, reading, used * news, seen, gates, step)
    return Filters(
        *(
            taught(each, reading.row, sight, _innovation(reading, each.mean), variance, use)
            for each, sight in zip(filters, sights, strict=True)
        )
    ), memory


@kept_whole
def _judged(
    memory: Memory,
    mean: Number,
    sight: Sight,
    reading: Reading,
    news: Number,
    seen: Number,
    gates: fail_safe.Gates,
    step: Number,
) -> tuple[Memory, Number, Number]:
    """What is remembered of a sensor, the variance of its noise in K2, and 1 where its reading is used."""
    variance = where(reading.std > 0, reading.std**2, 1.0)
    expected, by_noise = (dot(reading.row, each[:MODES]) for each in sight)
    widest = maximum(expected, 0.0) + variance
    sure = maximum(by_noise + seen * (expected - by_noise), 0.0) + variance
    trust = fail_safe.Trust(0.0, 0.0, *memory)
    verdict = fail_safe.judged(trust, news, _innovation(reading, mean), widest, sure, gates, step)
    return Memory(verdict.mean, verdict.calm_for, verdict.out), variance, verdict.use


def _innovation(reading: Reading, mean: Number) -> Number:
    return reading.value - dot(reading.row, mean[:MODES])
