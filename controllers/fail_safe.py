"""How every law protects itself: limits on the correction, and tests of the signals.

Limits: a correction stays within `correction_limit`, changes no faster than `correction_rate_limit`, and
raises `warning` from `warning_limit` on, as in the compensation interfaces of servo drives. The rate limit
also makes every start bumpless: a law begins with no correction, or with its last one, and moves from there.

Tests: a signal's innovation (reading minus prediction, in standard deviations) is standard normal and white
while the signal is sound. A reading is left out if its innovation is beyond `gate`, or if the mean innovation
of the last minutes is beyond `mean_gate`. A reading that repeats itself is left out too, because it brings
nothing new. A signal is used again when its innovations have been small for `return_time`.
Innovation tests: Y. Bar-Shalom, X. R. Li and T. Kirubarajan, *Estimation with Applications to Tracking and
Navigation*, Wiley 2001, section 5.4.
"""

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

from warmlink.controllers.interface import SENSED, law_outputs, length
from warmlink.fmus.calls import as_c_function, skip_if_zero
from warmlink.fmus.component import Parameter, Record, State, Values
from warmlink.fmus.component.arithmetic import (
    Number,
    absolute,
    clip,
    exp,
    finite,
    maximum,
    total,
    truth,
    where,
)

_RATE = "fastest change of the correction"
_WARNING = "correction from which on a warning is raised"

_limit = partial(length, positive=True, tunable=True)

LIMITS = (
    _limit("correction_limit", 5e-4, "largest correction to either side", nominal=1e-4),
    _limit("correction_rate_limit", 2e-6, _RATE, unit="m/s", display="um/s"),
    _limit("warning_limit", 2.5e-4, _WARNING, nominal=1e-4),
)

MEAN_SAMPLES, STUCK_SAMPLES, RETURN_SAMPLES = 12, 3, 6
"""Least number of samples in `mean_time`, `stuck_time` and `return_time`: a mean of fewer is mostly noise."""


def _gate(name: str, start: float, description: str) -> Parameter:
    return Parameter(name, "1", start, description, positive=True, tunable=True)


def _time(name: str, start: float, description: str, samples: int) -> Parameter:
    return Parameter(name, "s", start, f"{description}; {samples} samples at least", positive=True)


DOUBT = (
    _gate("gate", 5, "innovation, in standard deviations, beyond which a reading is left out"),
    _gate("mean_gate", 0.6, "mean innovation, in standard deviations, beyond which a signal is left out"),
    _time("mean_time", 120, "time over which the innovation's mean is taken", MEAN_SAMPLES),
    _time("stuck_time", 30, "time of equal readings after which a signal is left out", STUCK_SAMPLES),
    _time("return_time", 60, "time of small innovations after which a signal is used again", RETURN_SAMPLES),
)

SENSOR_STD = Parameter(
    "sensor_std",
    "K",
    0,
    "noise (1 sigma) of each sensor: shaft, winding, base, middle, tip; 0: sensor not used",
    size=len(SENSED),
    minimum=0,
    nominal=0.1,
)

FASTEST = 0.05
"""K/s, somewhat more than a pad's largest power does to the shaft: no temperature changes faster."""

FIRST_TIME = 10.0
"""s after a start in which one wrong reading may be all that a law goes by."""

RETURN_GATE = 3.0
"""Standard deviations within which innovations must stay before a signal is used again."""


def limited(previous: Number, wanted: Number, p: Record, step: Number) -> Number:
    """Correction in m that the limits allow, `step` seconds after the previous one."""
    target = clip(wanted, -p.correction_limit, p.correction_limit)
    reach = p.correction_rate_limit * step
    return previous + clip(target - previous, -reach, reach)


def warning(correction: Number, wanted: Number, p: Record) -> Number:
    """1 where the correction is near its limit, or is held back by a limit, else 0."""
    held_back = absolute(wanted - correction) > p.tolerance
    return where(held_back, 1.0, truth(absolute(correction) >= p.warning_limit))


def reported(x: Record, std: Number, p: Record, distrusted: Number = 0.0) -> dict[str, Number]:
    """Outputs of a law with the states `elongation` and `correction`, by name.

    Where a limit holds the correction back, the difference of the two states is a known error and counts in
    full.

    Parameters
    ----------
    x, p : states and parameters
    std : standard deviation in m of the error of `elongation`
    distrusted : 1 where a signal is left out as not credible, so that the law is not ready; else 0
    """
    correction_std = (std**2 + (x.elongation - x.correction) ** 2) ** 0.5
    raised = warning(x.correction, x.elongation, p)
    said = law_outputs(x.correction, correction_std, p, x.elongation, distrusted, raised)
    return said | {"ready": said["ready"] * (1.0 - distrusted)}


class Trust(NamedTuple):
    """Memory of the signals that is needed to judge them: vectors with one element for each signal.

    Attributes
    ----------
    last : last reading, in the signal's unit
    same_for : time in s that the reading has been repeating itself
    mean : mean of the recent innovations, in standard deviations
    calm_for : time in s that the innovations have been small
    out : 1 where the signal is left out, else 0
    """

    last: Number
    same_for: Number
    mean: Number
    calm_for: Number
    out: Number


def trust_states(unit: str, signals: int) -> tuple[State, ...]:
    """States that hold the memory of this many signals."""
    units = Trust(last=unit, same_for="s", mean="1", calm_for="s", out="1")
    return tuple(
        State(f"trust_{name}", of, size=signals, accepts_nan=name == "last")
        for name, of in units._asdict().items()
    )


def trust_of(x: Record) -> Trust:
    """Read the memory from a law's states."""
    return Trust(*(getattr(x, f"trust_{name}") for name in Trust._fields))


def trust_named(trust: Trust) -> dict[str, Number]:
    """Name each part of the memory as the law's states are named."""
    return {f"trust_{name}": value for name, value in trust._asdict().items()}


class Gates(NamedTuple):
    """Bounds of the innovation tests, as the parameters of the same names describe them.

    Attributes
    ----------
    share : of a new innovation in the mean
    """

    gate: Number
    mean_gate: Number
    share: Number
    return_time: Number


def gates_of(p: Record, step: Number) -> Gates:
    """Bounds of the innovation tests from a law's parameters, over the least number of samples."""
    share = 1.0 - exp(-step / maximum(p.mean_time, MEAN_SAMPLES * p.sample_time))
    return_time = maximum(p.return_time, RETURN_SAMPLES * p.sample_time)
    return Gates(p.gate, p.mean_gate, share, return_time)


def at_start(readings: Number) -> Trust:
    """Memory at the start: every signal is trusted."""
    none = readings * 0.0
    zero = where(finite(readings), none, 0.0)
    return Trust(readings, zero, zero, zero, zero)


def present(readings: Number) -> Number:
    """1 for each reading that is a number, 0 for NaN."""
    return truth(finite(readings))


def fresh(trust: Trust, readings: Number, p: Record, step: Number) -> tuple[Number, Trust]:
    """Tell which readings are present and new (1) and which not (0), and update the memory of repetitions."""
    news, last, same_for = _compared(readings, trust.last, trust.same_for, p, step)
    return news, trust._replace(last=last, same_for=same_for)


@as_c_function
def _compared(
    readings: Number, last: Number, same_for: Number, p: Record, step: Number
) -> tuple[Number, Number, Number]:
    there = present(readings)
    same_for = where(readings == last, same_for + step, 0.0)
    stuck_time = maximum(p.stuck_time, STUCK_SAMPLES * p.sample_time)
    moving = where(same_for >= stuck_time, 0.0, 1.0)
    return there * moving, where(there > 0, readings, last), same_for


@as_c_function
def distrusted(trust: Trust, readings: Number, p: Record) -> Number:
    """1 where a sensor that the law goes by is missing, or left out as not credible, else 0."""
    doubtful = trust.out + 1.0 - present(readings)
    return truth(total(where(p.sensor_std > 0, doubtful, 0.0)) > 0)


@as_c_function
def in_use(trust: Trust, news: Number, p: Record) -> Number:
    """1 where a sensor in use brings news, else 0: nothing would show an unknown heat come or go."""
    return truth(total(where(p.sensor_std > 0, news * (1.0 - trust.out), 0.0)) > 0)


@as_c_function
def begins_again(waited: Number, last: Number, readings: Number, p: Record, step: Number) -> Number:
    """1 where a law has only begun, and a reading leaps or comes for the first time; else 0.

    Either the reading was wrong by which it began, or this one is. The law then begins again from this one,
    and once more from the next if that leaps back.

    Parameters
    ----------
    waited : time in s since the start for which there were readings
    last : last readings
    """
    largest = 2.0**0.5 * p.gate * p.sensor_std + FASTEST * step
    leapt = where(absolute(readings - last) > largest, 1.0, 0.0)
    new = maximum(leapt, present(readings) * (1.0 - present(last)))
    return truth(total(truth(p.sensor_std > 0) * new) > 0) * truth(waited < FIRST_TIME)


@as_c_function
def waited_on(waited: Number, readings: Number, p: Record, step: Number) -> Number:
    """Time in s since the start for which there were readings, or none is asked for."""
    used = truth(p.sensor_std > 0)
    some = truth(total(used * present(readings)) > 0)
    return waited + where(total(used) > 0, some, 1.0) * step


def begun_again(
    begin: Callable[[Record, Record], Values], later: Values, u: Record, p: Record, again: Number
) -> dict[str, Number]:
    """States after a sample: those of a start, by a law's `begin`, where `again` is 1."""
    names = tuple(sorted(later))
    states = _begun_again(tuple(later[name] for name in names), begin, names, u, p, again)
    return dict(zip(names, states, strict=True))


@skip_if_zero
def _begun_again(
    before: tuple[Number, ...],
    begin: Callable[[Record, Record], Values],
    names: tuple[str, ...],
    u: Record,
    p: Record,
    again: Number,
) -> tuple[Number, ...]:
    fresh = begin(u, p)
    return tuple(where(again > 0, fresh[name], was) for name, was in zip(names, before, strict=True))


class Memory(NamedTuple):
    """What `Trust` remembers of one signal's innovations."""

    mean: Number
    calm_for: Number
    out: Number


def gate_reading(
    memory: Memory,
    news: Number,
    innovation: Number,
    variance: Number,
    sure_variance: Number,
    gates: Gates,
    step: Number,
) -> tuple[Number, Memory]:
    """Judge one reading by its innovation: 1 to use it, else 0, and the signal's memory after it.

    Parameters
    ----------
    memory : of this signal
    news : 1 if the reading is present and new, else 0
    innovation : reading minus prediction
    variance : largest variance of a sound signal's innovation, with unknown heat acting
    sure_variance : variance of the innovation with only the error that the law reports; a signal that was
        left out must keep within it to be used again
    gates : bounds of the tests
    step : time in s since the last reading
    """
    size = innovation / variance**0.5
    bounded = clip(size, -gates.gate, gates.gate)
    mean = where(news > 0, memory.mean + gates.share * (bounded - memory.mean), memory.mean)
    near = absolute(innovation) < RETURN_GATE * sure_variance**0.5
    there = present(innovation)
    jumped = where(absolute(size) > gates.gate, there, 0.0)
    # A reading that repeats itself off the prediction is a fault; near it, it is a steady state.
    stuck = there * (1.0 - news) * where(near, 0.0, 1.0)
    biased = truth(absolute(mean) > gates.mean_gate)

    small = where(near, news, 0.0)
    settled = where(absolute(mean) < 0.5 * gates.mean_gate, small, 0.0)
    calm_for = where(settled > 0, memory.calm_for + step, 0.0)
    back = truth(calm_for >= gates.return_time)
    out = where(memory.out > 0, 1.0 - back, maximum(maximum(jumped, stuck), biased))
    return news * (1.0 - out), Memory(mean, calm_for, out)
