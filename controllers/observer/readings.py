"""Thermometers beside what the duty explains: how far they lie above it, and how that lies along the link."""

from typing import NamedTuple

from warmlink.controllers import fail_safe
from warmlink.controllers.matrices import matrix
from warmlink.controllers.observer.model import BASE, SENSORS, WINDING, BelievedDuty
from warmlink.fmus.calls import as_c_function
from warmlink.fmus.component import Record
from warmlink.fmus.component.arithmetic import (
    Number,
    absolute,
    clip,
    finite,
    maximum,
    minimum,
    total,
    truth,
    where,
)

SMOOTHING = 10.0
"""s over which noise is taken out of the readings."""

FLATTEST = 0.94
"""Largest rise of an outer over that of an inner thermometer where heat comes from the shaft."""

FALL = 0.3
"""Least fall along a cell that was left warm, as a share of that which its model has after a long rest."""

REACH_TIME, LEAST_REACH, BURST_REACH = 600.0, 0.4, 0.15
"""Of an inner thermometer's rise, smoothed over so many s, an outer one shows this at least; of a pad's."""

FAR = 1e6
"""K, more than any reading is off."""

ALIKE = 0.3
"""Share by which thermometers that are off alike may differ."""

WINDING_SHARE = 0.5
"""Share by which the winding may be warmer or cooler, above a place in the link, than the duty explains."""


class Compared(NamedTuple):
    """Thermometers beside the duty, each of shape (5,).

    Attributes
    ----------
    seen : readings in K without most of their noise
    lagged : what they lie above what the duty explains, smoothed over `REACH_TIME`, in K
    rise : what the duty explains, in K above the surroundings
    excess : what they lie above that, in K; 0 for those that are missing
    there, trusted, called : 1 for those that are present, are trusted, are heard
    least : the least excess of those that are present, a number
    whole : 1 where every thermometer in use is present, else 0, a number
    """

    seen: Number
    lagged: Number
    rise: Number
    excess: Number
    there: Number
    trusted: Number
    called: Number
    least: Number
    whole: Number


class Shape(NamedTuple):
    """How what the duty does not explain lies along the thermometers, from the shaft outwards.

    Attributes
    ----------
    falls : 1 where it falls and reaches out, else 0
    alike : most in K that two neighbours show alike, while it is known how warm the cell is
    """

    falls: Number
    alike: Number


@as_c_function
def compared(
    x: Record,
    expected: Number,
    readings: Number,
    trust: fail_safe.Trust,
    duty: BelievedDuty,
    p: Record,
    step: Number,
) -> Compared:
    """Compare the readings, without most of their noise and without leaps, with what the duty explains."""
    share = step / (step + SMOOTHING)
    toward = clip(share * (readings - x.seen), -fail_safe.FASTEST * step, fail_safe.FASTEST * step)
    seen = where(finite(readings), x.seen + toward, x.seen)
    used = truth(p.sensor_std > 0)
    there = used * fail_safe.present(readings)
    trusted = there * (1.0 - trust.out)
    rise, excess = expected - duty.ambient_temperature, there * (seen - expected)
    lagged = x.lagged + step / (step + REACH_TIME) * (excess - x.lagged)

    # Thermometers left out are heard all the same where all are off alike, or none is left.
    largest, least = extremes(excess, there)
    noise = total(p.sensor_std) / maximum(total(used), 1.0)
    alike = truth(largest - least < ALIKE * maximum(largest, -least) + 3.0 * noise)
    called = where(alike + where(total(trusted) > 0, 0.0, 1.0) > 0, there, trusted)
    whole = truth(total(used) - total(there) < 0.5)
    return Compared(seen, lagged, rise, excess, there, trusted, called, least, whole)


INWARDS = (0, *range(2, SENSORS))
"""Thermometers from the shaft outwards, without the winding's, which has a heat source of its own."""


@as_c_function
def cools(sensors: Compared, p: Record) -> Number:
    """1 where readings look like a cell that heat in the shaft has left warm, else 0.

    The longest rest leaves the slowest mode. From the innermost to the outermost thermometer readings must
    fall at least `FALL` times as much as that does, as a shift of all of them does not, and they must reach
    out, as that of one alone does not. Of what the duty explains a sixth may be wrong.
    """
    slowest = matrix(p.sensor_rows, SENSORS)[:, 0]
    fits: Number = 1.0
    inside, most, before, last, first_kept, kept = 0.0, 0.0, 0.0, 0.0, 1.0, 1.0
    for i in INWARDS:
        excess, called = sensors.excess[i], sensors.called[i]
        odd = maximum(truth(excess > most + 3.0 * p.sensor_std[i]), truth(excess < BURST_REACH * before))
        fits = where(called * inside * odd > 0, 0.0, fits)
        first = called * (1.0 - inside)
        most = where(first > 0, excess - absolute(sensors.rise[i]) / 6.0, most)
        first_kept = where(first > 0, slowest[i], first_kept)
        before = where(called > 0, excess, before)
        last, kept = (
            where(called * inside > 0, now, was) for now, was in ((excess, last), (slowest[i], kept))
        )
        inside = maximum(inside, called)
    return where(last > (1.0 - FALL * (1.0 - kept / first_kept)) * most, where(last > 0, 0.0, fits), fits)


@as_c_function
def shape_of(sensors: Compared, known: Number, early: Number, heated: Number, p: Record) -> Shape:
    """Heat that no input tells of falls from the shaft outwards and reaches out.

    A shift of all thermometers, or of the surroundings, does not fall; that of one alone does not reach out.

    Parameters
    ----------
    known : 1 once it is known how warm the cell is
    early : 1 where heat has had no time to reach out: a reading as the winding's may be the winding's
    heated : 1 while heat flows that no model's error explains, as a pad's: less of it need have reached out
    """
    excess = sensors.excess
    reach = LEAST_REACH - heated * (LEAST_REACH - BURST_REACH)
    falls: Number = 1.0
    alike, inner, earlier, noise, inside, further = 0.0, 0.0, 0.0, 0.0, 0.0, 1.0
    for i in INWARDS:
        called = sensors.called[i]
        slack = 0.25 * (p.sensor_std[i] + noise)
        flattest = minimum(p.flattest_rise[i] / further, FLATTEST)
        # It must have reached the next one, or may still be there.
        flat = truth(excess[i] > flattest * maximum(inner, earlier) + slack)
        steep = truth(excess[i] < reach * maximum(earlier, 0.0) - 4.0 * slack)
        falls = where(called * inside * maximum(flat, steep) > 0, 0.0, falls)
        side = where(excess[i] > 0, 1.0, -1.0)
        here, further_in = side * excess[i], side * inner
        same = where(here > FLATTEST * maximum(further_in, side * earlier), minimum(here, further_in), 0.0)
        alike = maximum(alike, called * inside * same)
        inner = where(called > 0, excess[i], inner)
        earlier = where(called > 0, sensors.lagged[i], earlier)
        noise = where(called > 0, p.sensor_std[i], noise)
        further = where(called > 0, p.flattest_rise[i], further)
        inside = maximum(inside, called)
    gap = sensors.rise[WINDING] - sensors.rise[BASE]
    as_winding = truth(absolute(excess[BASE] - gap) < WINDING_SHARE * gap)
    return Shape(falls * (1.0 - early * as_winding), known * alike)


def extremes(values: Number, there: Number) -> tuple[Number, Number]:
    """Largest and least of the values that are there; 0 where none is."""
    largest: Number = -FAR
    least: Number = FAR
    for i in range(SENSORS):
        largest = maximum(largest, where(there[i] > 0, values[i], -FAR))
        least = minimum(least, where(there[i] > 0, values[i], FAR))
    some = total(there) > 0
    return where(some, largest, 0.0), where(some, least, 0.0)
