"""How far duty and surroundings alone are off the growth of a machine, as a log of it shows.

An observer doubts thermometers as far as the duty contradicts them. On a machine that is as its model says
the duty knows the growth to a micrometre, and protects the law; on another one thermometers know better. To
scale the losses first, so that they fit the log, was tried: the duty then knows the log to some micrometres,
and other duty cycles no better than before.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from warmlink.controllers.learning.logs import Log
from warmlink.controllers.observer.component import COMPONENT as OBSERVER
from warmlink.controllers.observer.model import BelievedDuty, by_duty, elongation
from warmlink.controllers.start_values import Values, with_values
from warmlink.fmus.component import Record

Array = NDArray[np.float64]

SAMPLE = 10.0
"""s between two samples of the duty: growth is slower."""

TOLD = ("speed", "torque", "ambient_temperature")


def duty_std(logs: Sequence[Log], values: Values) -> float | None:
    """Rms in m of growth that was measured minus growth by duty and surroundings alone.

    Each log counts from a start in equilibrium with the surroundings. None if no log holds speed, torque and
    surroundings throughout.

    Parameters
    ----------
    values : parameter set of an observer
    """
    told = [log for log in logs if all(np.isfinite(log.others.get(name, np.nan)).all() for name in TOLD)]
    if not told:
        return None
    error = np.concatenate([log.growth[np.isfinite(log.growth)] for log in told]) - growth_by_duty(
        told, values
    )
    return float(np.sqrt(np.mean(error**2)))


def growth_by_duty(logs: Sequence[Log], values: Values) -> Array:
    """Growth in m by duty and surroundings alone, where logs have readings of it, one log after the other."""
    known = {each.name for each in OBSERVER.parameters if not each.name.startswith("disturbance")}
    given = {name: value for name, value in values.items() if name in known} | {"sample_time": SAMPLE}
    law = replace(OBSERVER, parameters=with_values(OBSERVER.parameters, given))
    p = law.d.read(np.asarray(law.settled(law.start_values()[0]), dtype=float))
    return np.concatenate([_growth(log, p) for log in logs])


def _growth(log: Log, p: Record) -> Array:
    times = np.arange(log.time[0], log.time[-1] + SAMPLE, SAMPLE)
    row = np.searchsorted(log.time, times + 1e-9, side="right") - 1
    told = np.column_stack([log.others[name][row] for name in TOLD])
    modes = p.uniform_profile * (told[0, 2] - p.linearisation_temperature)
    growth = [elongation(modes, p)]
    for each in told[:-1]:
        modes = by_duty(modes, BelievedDuty(*each), p)
        growth.append(elongation(modes, p))
    read = np.isfinite(log.growth)
    return np.interp(log.time[read], times, np.array(growth, dtype=float))
