"""What an observer did not foresee of its sensors' readings, and whether that is white."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from warmlink.controllers.interface import SENSED
from warmlink.controllers.kalman import corrected, variance_along
from warmlink.controllers.observer import law, model
from warmlink.controllers.observer.component import COMPONENT as OBSERVER
from warmlink.controllers.observer.filters import filters_of
from warmlink.orchestration.studies.rollout import DEMANDS, RECORDED, Array, Cell, Record

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


def innovations(record: Record, demands: Array) -> dict[str, Array]:
    """Innovations of `observer` by sensor, from the law's recorded states, in standard deviations.

    They are those of the estimate that the law reports, its quiet filter's.

    Parameters
    ----------
    record : of a cell made with `law_states`, by the law with its default parameters
    demands : what the cell was run through, shape (n, 6)

    Raises
    ------
    ValueError
        The reconstruction is not what the law itself came to.
    """
    p = OBSERVER.d.read(np.array([s.start for s in OBSERVER.scalars()][: OBSERVER.p.size], dtype=float))
    states = record.values[:, len(RECORDED) :]
    used = [i for i, std in enumerate(np.asarray(p.sensor_std)) if std > 0]
    found: dict[int, list[float]] = {sensor: [] for sensor in used}
    sensed = record.values[:, [RECORDED.index(f"sensed_{name}") for name in SENSED]]
    for k in range(SETTLED, record.time.size):
        values = dict(zip(DEMANDS[:3], demands[k], strict=False))
        u = OBSERVER.u.read(np.array([values.get(name, 0.0) for name in OBSERVER.u.names]))
        now = OBSERVER.x.read(states[k])
        before = OBSERVER.x.read(states[k - 1])
        belief = law.predict(filters_of(before, model.STATES), u, p, Cell.step).quiet
        for sensor, series in found.items():
            variance = float(p.sensor_std[sensor]) ** 2
            row = np.concatenate([model.sensor_row(sensor, p), np.zeros(model.HEATS)])
            innovation = sensed[k, sensor] - model.temperature(sensor, belief.mean[: model.MODES], p)
            series.append(innovation / (variance_along(belief.noise_spread, row) + variance) ** 0.5)
            belief = corrected(belief, row, innovation, variance, 1.0 - now.trust_out[sensor])
        alert, quiet = (each.mean for each in filters_of(now, model.STATES))
        led_by_alert = np.array_equal(alert, quiet)
        if not led_by_alert and not np.allclose(belief.mean, quiet, rtol=1e-9, atol=1e-12):
            raise ValueError(f"step {k}: the innovations do not lead to the state that the law recorded")
    return {SENSED[sensor]: np.array(series) for sensor, series in found.items()}
