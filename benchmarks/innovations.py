"""What an observer did not foresee of its sensors' readings, and whether that is white."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.rollout import RECORDED, Array, Record, by_rows, compiled
from warmlink.controllers.interface import SENSED
from warmlink.controllers.kalman import cross_covariance, gain_of, updated, variance_along
from warmlink.controllers.observer import model, prediction
from warmlink.controllers.observer.component import COMPONENT as OBSERVER
from warmlink.controllers.observer.filters import filters_of
from warmlink.controllers.observer.model import BelievedDuty
from warmlink.fmus.component import Component

LAGS = 20
SETTLED = 300
"""Step from which on innovations are looked at: before, the gain is still that of a cold start."""


@dataclass(frozen=True)
class Whiteness:
    """Ljung and Box's test (Biometrika 65, 1978) over 20 lags, and the correlation of neighbours.

    Attributes
    ----------
    p : probability of as large a statistic from white noise
    neighbours : autocorrelation at lag 1
    std, mean : of the innovations, in their stated standard deviations
    """

    p: float
    neighbours: float
    std: float
    mean: float


def whiteness(series: NDArray[np.float64]) -> Whiteness:
    """Whiteness of a series of innovations, shape (n,), in their stated standard deviations."""
    from scipy import stats

    count = series.size
    centred = series - series.mean()
    r = np.array([centred[k:] @ centred[: count - k] for k in range(1, LAGS + 1)]) / (centred @ centred)
    statistic = count * (count + 2) * np.sum(r**2 / (count - np.arange(1, LAGS + 1)))
    p = float(stats.chi2.sf(statistic, LAGS))
    return Whiteness(p, float(r[0]), float(series.std()), float(series.mean()))


def innovations(record: Record) -> dict[str, Array]:
    """Innovations of `observer` by sensor, from the law's recorded states, in standard deviations.

    They are those of the estimate that the law reports, its quiet filter's.

    Parameters
    ----------
    record : of a cell made with `law_states`, by the law with its default parameters

    Raises
    ------
    ValueError
        The reconstruction is not what the law itself came to.
    """
    states = record.values[:, len(RECORDED) :]
    sensed = record.values[SETTLED:, [list(RECORDED).index(f"sensed_{name}") for name in SENSED]]
    series, mean = by_rows(_look(), states[SETTLED - 1 : -1], sensed, states[SETTLED:])
    _, quiet = _estimates(record, OBSERVER)
    foreseen = np.isclose(mean, quiet[SETTLED:], rtol=1e-9, atol=1e-12).all(axis=1)
    if not (foreseen | led_by_alert(record)[SETTLED:]).all():
        raise ValueError("the innovations do not lead to the states that the law recorded")
    return {SENSED[sensor]: each for sensor, each in zip(_used(), series.T, strict=True)}


def led_by_alert(record: Record, observer: Component = OBSERVER) -> NDArray[np.bool_]:
    """Whether the alert filter led at each communication point: where it does, both estimates are one.

    Parameters
    ----------
    record : of a cell made with `law_states`
    observer : the law
    """
    alert, quiet = _estimates(record, observer)
    return np.asarray((alert == quiet).all(axis=1))


def _estimates(record: Record, observer: Component) -> tuple[Array, Array]:
    """Modes and unknown heats by the alert and by the quiet filter, each of shape (n + 1, 9)."""
    states = record.values[:, len(RECORDED) :]
    first = observer.x.index["estimate[1]"]
    both = states[:, first : first + 2 * model.STATES]
    return both[:, ::2], both[:, 1::2]


@cache
def _look() -> Any:
    """Innovations of the sensors in use and the estimate after them, of a law's states before and now."""
    import casadi as ca

    p = _parameters()
    before, now = (ca.SX.sym(name, OBSERVER.x.size) for name in ("before", "now"))
    sensed = ca.SX.sym("sensed", len(SENSED))
    after = OBSERVER.x.read(now)
    duty = BelievedDuty(after.believed_speed, after.believed_torque, after.believed_ambient)
    belief = prediction.predict(filters_of(OBSERVER.x.read(before)), duty, p).quiet
    series = []
    for sensor in _used():
        variance = float(p.sensor_std[sensor]) ** 2
        row = np.concatenate([model.sensor_row(sensor, p), np.zeros(model.HEATS)])
        innovation = sensed[sensor] - model.temperature(sensor, belief.mean[: model.MODES], p)
        series.append(innovation / (variance_along(belief.noise_spread, row) + variance) ** 0.5)
        across = cross_covariance(belief, row)
        gain = gain_of(row, across, innovation, variance, 1.0 - after.trust_out[sensor])
        belief = updated(belief, across, gain, row, variance)
    looked = [ca.densify(each) for each in (ca.vertcat(*series), belief.mean)]
    (look,) = compiled([ca.Function("look", [before, sensed, now], looked)])
    return look


def _parameters() -> Any:
    return OBSERVER.d.read(OBSERVER.settled(OBSERVER.start_values()[0]))


def _used() -> list[int]:
    return [i for i, std in enumerate(np.asarray(_parameters().sensor_std)) if std > 0]
