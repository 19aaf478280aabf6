"""Readings of thermometers, computed once in each sample time.

    T' = T - s (T - T_a)                        conduction along the stem
    z <- T' + (z - T') exp(-sample_time / lag)  first-order lag, exact for an input held meanwhile
    reading = round(z + offset + noise + fault)

Stem conduction and lag are the usual first-order models of contact thermometers.
"""

from warmlink.fmus import faults, noise
from warmlink.fmus.calls import as_c_function
from warmlink.fmus.component import Record, Values
from warmlink.fmus.component.arithmetic import Number, exp, floor, maximum, total, truth, where

CHANNELS = 8

_SHORTEST_LAG = 1e-9
"""s, in place of a lag of 0: the exponential vanishes for any sample time in use."""

FINEST_QUANTUM = 1e-6
"""K; finer than any thermometer, and coarse enough for numbers of quanta to be whole."""

_ZERO_CELSIUS = 273.15
"""K, from which instruments count their quanta."""


def derive(p: Record) -> Values:
    """Share of a temperature difference that is left after a sample time."""
    return {"kept": exp(-p.sample_time / maximum(p.lag, _SHORTEST_LAG))}


def begin(u: Record, p: Record) -> Values:
    """States at the start: in equilibrium with the input temperatures."""
    a, b = noise.starts(p.seed, range(CHANNELS))
    settled = attained(u, p)
    number, a, b = noise.normals(a, b)
    first = disturbed(settled, number, p, 0.0)
    return {
        "sensed": settled,
        "reading": faults.replaced(first, first, p.fault_kind, -p.fault_time),
        "generator_a": a,
        "generator_b": b,
    }


def update(x: Record, u: Record, p: Record, time: Number, step: Number) -> Values:
    """States after a sample: temperatures in K, and states of the random generators."""
    noisy = truth(total(p.noise) > 0)
    number, a, b = noise.normals(x.generator_a, x.generator_b, noisy)
    sensed, reading = _read(x.sensed, x.reading, number, u, p, time)
    return {"sensed": sensed, "reading": reading, "generator_a": a, "generator_b": b}


@as_c_function
def _read(
    sensed: Number, reading: Number, number: Number, u: Record, p: Record, time: Number
) -> tuple[Number, Number]:
    """Next values of what is sensed and read."""
    target = attained(u, p)
    sensed = target + (sensed - target) * p.kept
    value = disturbed(sensed, number, p, time)
    return sensed, faults.replaced(value, reading, p.fault_kind, time - p.fault_time)


def outputs(x: Record, u: Record, p: Record, time: Number) -> Values:
    """Readings in K; NaN where a channel dropped out."""
    return {"reading": x.reading}


def attained(u: Record, p: Record) -> Number:
    """Temperature in K that each sensor approaches, shape (8,)."""
    return u.temperature - p.stem_conduction * (u.temperature - u.ambient_temperature)


def disturbed(sensed: Number, number: Number, p: Record, time: Number) -> Number:
    """Reading in K of what is sensed, shape (8,), for standard normal numbers."""
    shift = faults.shift(p.fault_kind, p.fault_size, p.fault_rate, time - p.fault_time)
    return quantised(sensed + p.offset + p.noise * number + shift, p.quantum)


def quantised(value: Number, quantum: Number) -> Number:
    """Value in K rounded to whole quanta on the Celsius scale; as it is where the quantum is 0."""
    size = where(quantum > 0, quantum, 1.0)
    rounded = size * floor((value - _ZERO_CELSIUS) / size + 0.5) + _ZERO_CELSIUS
    return where(quantum > 0, rounded, value)
