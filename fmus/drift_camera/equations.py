"""A laser spot's centroid on a camera chip, measured in single pictures.

    measured = scale (elongation - correction) + drift_rate t + offset + pixel_size (noise) + fault

After P. Poonyapak, M. J. D. Hayes and J. M. J. McDill, "Temperature-Induced Deformation in a Mechanical
System", sections II and III: a picture each 30 s while the link moves and each 120 s while it is still.
"""

from types import SimpleNamespace

from warmlink.fmus import faults, noise
from warmlink.fmus.component import Record, Values
from warmlink.fmus.component.arithmetic import Number, absolute, stack, where

_GENERATOR = 1000
"""Channel of the random generator, away from those of the thermometers."""

_EARLY = 1e-6
"""Share of a sample time by which rounding may put a sample too early."""


def begin(u: Record, p: Record) -> Values:
    """States at the start, where the first picture is taken."""
    nothing = dict.fromkeys(("seen", "lost", "unread", "measured_drift", "drift_valid"), 0.0)
    empty = SimpleNamespace(generator=stack(*noise.starts(p.seed, (_GENERATOR,))), age_count=-1.0, **nothing)
    return _looked(empty, u, p, 0.0, p.sample_time, 0.0, 1.0)


def update(x: Record, u: Record, p: Record, time: Number, step: Number) -> Values:
    """States after a sample: a picture is taken when it is due, and read when its delay is over."""
    count = x.count + 1
    interval = where(absolute(u.speed) > p.still_speed, p.moving_interval, p.still_interval)
    taken = where((count + _EARLY) * step >= interval, 1.0, 0.0)
    return _looked(x, u, p, time, step, where(taken > 0, 0.0, count), taken)


def outputs(x: Record, u: Record, p: Record, time: Number) -> Values:
    """Drift in m, whether it is good, and its age in s."""
    return {
        "measured_drift": x.measured_drift,
        "drift_valid": x.drift_valid,
        "age": x.age_count * p.sample_time,
    }


def picture(u: Record, p: Record, number: Number, time: Number) -> Number:
    """Drift in m that a picture shows, for a standard normal number."""
    shift = faults.shift(p.fault_kind, p.fault_size, p.fault_rate, time - p.fault_time)
    drift = p.scale * (u.elongation - u.correction) + p.drift_rate * time + p.offset
    return drift + p.pixel_size * p.centroid_noise * number + shift


def _looked(
    x: Record, u: Record, p: Record, time: Number, step: Number, count: Number, taken: Number
) -> Values:
    """States once a picture was taken or not, `count` samples after the last one taken."""
    number, *drawn = noise.normals(x.generator[0], x.generator[1], taken)
    halves = noise.advanced(*drawn)
    shown = picture(u, p, number, time)
    # A stuck picture repeats the last; before any picture there is none to repeat.
    last = where(x.age_count < 0, shown, x.seen)
    shown = faults.replaced(shown, last, p.fault_kind, time - p.fault_time)
    missed = where(noise.uniform(*halves) < p.dropout_probability, 1.0, 0.0)

    seen = where(taken > 0, shown, x.seen)
    lost = where(taken > 0, missed, x.lost)
    unread = where(taken > 0, 1.0, x.unread)
    read = where((count + _EARLY) * step >= p.delay, unread, 0.0)
    good = read * (1.0 - lost)
    return {
        "generator": where(taken > 0, stack(*halves), x.generator),
        "count": count,
        "seen": seen,
        "lost": lost,
        "unread": unread - read,
        "measured_drift": where(good > 0, seen, x.measured_drift),
        "drift_valid": where(read > 0, 1.0 - lost, x.drift_valid),
        "age_count": where(good > 0, count, x.age_count + 1.0),
    }
