"""An estimate with its covariance, into which the thermometers' readings are taken one after the other.

Each reading is judged by its innovation before it is used (`fail_safe.py`). The observers carry two such
estimates side by side, each with two covariances: `observer/filters.py`.
"""

from collections.abc import Callable
from typing import NamedTuple

from warmlink.controllers import fail_safe
from warmlink.controllers.interface import SENSED
from warmlink.controllers.kalman import CrossCovariance, gain_of
from warmlink.controllers.matrices import dot, outer, symmetric, upper
from warmlink.fmus.calls import as_c_function, skip_if_zero
from warmlink.fmus.component import Record
from warmlink.fmus.component.arithmetic import Number, maximum, stack, truth, where


class Estimate(NamedTuple):
    """Means, shape (n,), and their errors' covariance, packed: the rows of its upper triangle."""

    mean: Number
    spread: Number


def sense(
    belief: Estimate,
    trust: fail_safe.Trust,
    row: Callable[[int], Number],
    values: Number,
    news: Number,
    p: Record,
    step: Number,
) -> tuple[Estimate, fail_safe.Trust]:
    """Estimate and trust after the readings, taken one after the other.

    Parameters
    ----------
    row : derivative of a sensor's temperature by the means, shape (n,), by the sensor's place in `SENSED`
    values : readings in K, from where the means count, shape (len(SENSED),)
    news : 1 for each reading that is present and new, else 0
    p : parameters of the law, of which `sensor_std` and the gates count
    step : time in s since the last readings
    """
    gates = fail_safe.gates_of(p, step)
    memories = []
    for i in range(len(SENSED)):
        used = truth(p.sensor_std[i] > 0)
        memory = fail_safe.Memory(trust.mean[i], trust.calm_for[i], trust.out[i])
        reading = row(i), values[i], p.sensor_std[i], news[i]
        belief, memory = _taken((belief, memory), *reading, gates, step, used)
        memories.append(memory)
    mean, calm, out = (stack(*each) for each in zip(*memories, strict=True))
    return belief, trust._replace(mean=mean, calm_for=calm, out=out)


@skip_if_zero
@as_c_function
def _taken(
    before: tuple[Estimate, fail_safe.Memory],
    row: Number,
    value: Number,
    std: Number,
    news: Number,
    gates: fail_safe.Gates,
    step: Number,
    used: Number,
) -> tuple[Estimate, fail_safe.Memory]:
    """Estimate, and memory of a sensor's innovations, after its reading."""
    estimate, memory = before
    noise = where(std > 0, std**2, 1.0)
    innovation = value - dot(row, estimate.mean)
    across = symmetric(estimate.spread, row.shape[0]) @ row
    variance = maximum(dot(row, across), 0.0) + noise
    use, after = fail_safe.gate_reading(memory, used * news, innovation, variance, variance, gates, step)
    gain = gain_of(row, CrossCovariance(across, across), innovation, noise, use)
    mean = estimate.mean + across * gain.times
    spread = estimate.spread - upper(outer(across * gain.share, across))
    return Estimate(mean, spread), fail_safe.Memory(after.mean, after.calm_for, used * after.out)
