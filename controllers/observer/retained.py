"""What an observer gives its host to keep, so that after a restart it goes on where it was.

    retained = (check, correction, known, modes by the filter, modes by the duty, what was learnt of offsets,
                what a camera taught)
    check    = 1 + sum of w_i retained_i

The time that passed counts: motor and link have cooled towards the surroundings meanwhile. What does not add
up to its check, or was never kept, is not used: the law starts unsure.
"""

from typing import NamedTuple

from warmlink.controllers.fail_safe import FASTEST
from warmlink.controllers.kalman import Belief
from warmlink.controllers.matrices import blocks, diagonal, outer, symmetric, upper
from warmlink.controllers.observer import offset, witnesses
from warmlink.controllers.observer.model import (
    HEATS,
    MODES,
    SENSORS,
    STATES,
    BelievedDuty,
    decay_and_reach,
    temperature,
)
from warmlink.controllers.observer.readings import SMOOTHING
from warmlink.fmus.component import Output, Parameter, Record
from warmlink.fmus.component.arithmetic import (
    Number,
    absolute,
    clip,
    finite,
    maximum,
    minimum,
    stack,
    total,
    truth,
    where,
)

_HEAD = 3
"""Check, correction and known."""

LENGTH = 1e-6
"""m in which correction and offset are kept, so that all numbers are of one size."""

ROUNDING = 1e-9
"""Share of itself by which a check may be off: text with ten digits keeps it."""


class Recalled(NamedTuple):
    """What is recalled at a start.

    Attributes
    ----------
    valid : 1 where anything is, else 0
    correction : in m
    known : 1 where it was known how warm the cell is
    modes, duty_modes : by the filter and by the duty alone, cooled for the time that passed
    offsets : what `offset.kept` gave
    passed : time in s since then
    taught : what a camera added, the elements of the filter's state after the unknown heats
    """

    valid: Number
    correction: Number
    known: Number
    modes: Number
    duty_modes: Number
    offsets: Number
    passed: Number
    taught: Number


def size(states: int) -> int:
    """Numbers that an observer with so many elements of state keeps."""
    return _HEAD + 2 * MODES + offset.KEPT + states - STATES


def parameters(states: int) -> tuple[Parameter, ...]:
    """What the host gives back."""
    kept = "what `retained` held before a restart, where the host kept it"
    passed = "time since then; below 0: nothing was kept"
    return (
        Parameter("recalled", "1", 0, kept, size=size(states)),
        Parameter("recalled_for", "s", -1, passed, minimum=-1, nominal=100),
    )


def outputs(states: int) -> tuple[Output, ...]:
    """What the host is to keep."""
    description = "what the host may keep, to give it back as `recalled` after a restart"
    return (Output("retained", "1", description, size=size(states)),)


def kept(x: Record, estimate: Number) -> Number:
    """What the host is to keep, for a filter's estimate."""
    known = truth(x.known_for >= witnesses.KNOWN_TIME)
    known = where(x.agreed_for >= witnesses.AGREEMENT_TIME, known, 0.0)
    taught = [estimate[STATES:]] if estimate.shape[0] > STATES else []
    held = stack(x.correction / LENGTH, known, estimate[:MODES], x.duty_modes, offset.kept(x), *taught)
    return stack(_check(held), held)


def recalled(duty: BelievedDuty, p: Record) -> Recalled:
    """What is recalled at a start, as of now."""
    given = p.recalled[1:]
    fits = absolute(p.recalled[0] - _check(given)) <= ROUNDING * (1.0 + total(absolute(given)))
    valid = where(p.recalled_for >= 0, truth(fits), 0.0)
    # Memory that was never written may read as NaN, of which 0 times is still NaN.
    held = where(valid > 0, given, stack(*[0.0] * given.shape[0]))
    cold = p.uniform_profile * (duty.ambient_temperature - p.linearisation_temperature)
    passed = clip(where(p.recalled_for >= 0, p.recalled_for, 0.0), 0.0, 1e6)
    left, _ = decay_and_reach(p, passed)
    modes, duty_modes = (
        cold + valid * left * (held[first : first + MODES] - cold) for first in (2, 2 + MODES)
    )
    correction = clip(LENGTH * held[0], -p.correction_limit, p.correction_limit)
    rest = held[2 + 2 * MODES :]
    offsets, taught = rest[: offset.KEPT], rest[offset.KEPT :]
    return Recalled(valid, correction, held[1], modes, duty_modes, offsets, passed, taught)


def first_belief(recalled: Recalled, duty: BelievedDuty, readings: Number, p: Record, size: int) -> Belief:
    """Belief before any reading.

    Its mean is what is recalled, or the ambient temperature everywhere. Its uncertainty follows from the
    first readings: the largest distance of a reading from that, less twice its noise, both squared, is how
    warm the cell may be, with the temperature profiles that heat in the motor leaves behind. Where all is
    recalled, unknown heat (`disturbance_std`) may have flowed into the shaft since.
    """
    start = where(p.initial_temperature > 0, p.initial_temperature, duty.ambient_temperature)
    cold = p.uniform_profile * (start - p.linearisation_temperature)
    modes = where(recalled.valid > 0, recalled.modes, cold)
    warmth: Number = 0.0
    for i in range(SENSORS):
        apart = readings[i] - temperature(i, modes, p)
        beyond = maximum(apart**2 - (2.0 * p.sensor_std[i]) ** 2, 0.0) ** 0.5
        warmth = maximum(warmth, where(p.sensor_std[i] > 0, where(finite(beyond), beyond, 0.0), 0.0))
    warmth = _warmest(recalled, warmth, p)
    uniform = outer(p.uniform_profile, p.uniform_profile) * p.initial_std**2
    profile = diagonal(p.profile_std**2)
    warm = symmetric(p.warm_spread, MODES) * warmth**2
    heated = (
        recalled.valid * decay_and_reach(p, recalled.passed)[1] * p.shaft_heat_gain * p.disturbance_std[0]
    )
    possible = uniform + warm + outer(heated, heated)
    rest = stack(*[0.0] * (size - MODES))
    doubt = diagonal(p.disturbance_std**2 * p.disturbance_start)
    none = outer(p.uniform_profile, rest) * 0.0
    taught = [recalled.taught] if size > STATES else []
    mean = stack(modes, *[0.0] * HEATS, *taught)
    return Belief(
        mean,
        upper(blocks(possible + profile, none, doubt)),
        upper(blocks(possible, none, 0.0 * doubt)),
    )


def _warmest(recalled: Recalled, warmth: Number, p: Record) -> Number:
    """Warmth in K that first readings may reveal: where all is recalled, what can have come meanwhile."""
    reach = FASTEST * (recalled.passed + SMOOTHING)
    return where(recalled.valid > 0, minimum(warmth, reach), warmth)


def _check(held: Number) -> Number:
    weights = [1.0 + 0.618034 * (i % 7) + 0.1 * i for i in range(held.shape[0])]
    return 1.0 + total(stack(*weights) * held)
