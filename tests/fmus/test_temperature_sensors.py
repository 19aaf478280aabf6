"""TemperatureSensors: exactness of the lag, what each imperfection does, and each fault."""

import math
from collections.abc import Mapping

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from warmlink.fmus.component.instance import Instance
from warmlink.fmus.errors import InputError
from warmlink.fmus.temperature_sensors.component import CHANNELS, COMPONENT

COLD = 295.15
TRUE = {f"temperature[{i}]": 300.0 + i for i in range(1, CHANNELS + 1)}


def sensors(values: Mapping[str, float]) -> Instance:
    instance = Instance(COMPONENT)
    instance.set(TRUE)
    instance.set(values)
    instance.initialize()
    return instance


def every_channel(name: str, value: float) -> dict[str, float]:
    return {f"{name}[{i}]": value for i in range(1, CHANNELS + 1)}


def series(instance: Instance, count: int, channel: int = 1) -> np.ndarray:
    found = [instance.get(f"reading[{channel}]")]
    for k in range(count):
        instance.step(float(k), 1.0)
        found.append(instance.get(f"reading[{channel}]"))
    return np.array(found)


def test_as_declared_they_read_the_truth() -> None:
    instance = sensors({})
    assert instance.outputs().tolist() == list(TRUE.values())
    instance.set({"temperature[4]": 321.0})
    assert instance.get("reading[4]") == 304.0, "readings change at samples alone"
    instance.step(0.0, 1.0)
    assert instance.get("reading[4]") == 321.0


@settings(deadline=None, max_examples=20)
@given(lag=st.floats(0.1, 1e4), period=st.floats(0.2, 20), size=st.floats(-50, 50))
def test_a_step_is_followed_exactly(lag: float, period: float, size: float) -> None:
    instance = sensors({"lag[2]": lag, "sample_time": period})
    instance.set({"temperature[2]": 302.0 + size})
    for k in range(1, 8):
        instance.step((k - 1) * period, period)
        expected = 302.0 + size * -math.expm1(-k * period / lag)
        assert instance.get("reading[2]") == pytest.approx(expected, rel=1e-13)


def test_the_lag_is_settled_at_the_start() -> None:
    assert series(sensors(every_channel("lag", 60.0)), 5).tolist() == [301.0] * 6


def test_offset_stem_and_quantum() -> None:
    instance = sensors(
        {
            "offset[1]": 0.7,
            "stem_conduction[2]": 0.1,
            "ambient_temperature": 292.0,
            "quantum[3]": 0.5,
            "quantum[4]": 0.1,
            "temperature[4]": 273.15 + 31.449,
        }
    )
    assert instance.get("reading[1]") == pytest.approx(301.7)
    assert instance.get("reading[2]") == pytest.approx(302.0 - 0.1 * 10.0)
    assert instance.get("reading[3]") == pytest.approx(273.15 + 30.0), "29.85 degC rounds to 30.0"
    assert instance.get("reading[4]") == pytest.approx(273.15 + 31.4)


@pytest.mark.parametrize("quantum", [5e-324, 1e-9])
def test_a_quantum_that_would_overflow_is_refused(quantum: float) -> None:
    with pytest.raises(InputError, match=r"quantum\[2\].*too fine; give 0 for none or at least 1e-06 K"):
        sensors({"quantum[2]": quantum})


def test_noise_is_normal_white_and_each_channels_own() -> None:
    sigmas = 0.05 * np.arange(1, CHANNELS + 1)
    instance = sensors({f"noise[{i + 1}]": s for i, s in enumerate(sigmas)} | {"seed": 11})
    rows = []
    for k in range(3000):
        instance.step(float(k), 1.0)
        rows.append(instance.outputs().copy())
    error = (np.array(rows) - list(TRUE.values())) / sigmas
    for channel in error.T:
        assert stats.kstest(channel, "norm").pvalue > 1e-3
        assert abs(np.corrcoef(channel[1:], channel[:-1])[0, 1]) < 4 / math.sqrt(3000)
    assert np.abs(np.corrcoef(error.T) - np.eye(CHANNELS)).max() < 4 / math.sqrt(3000)


def test_a_seed_repeats_its_noise() -> None:
    noisy = every_channel("noise", 0.1)
    first = series(sensors({**noisy, "seed": 4}), 20)
    assert np.array_equal(first, series(sensors({**noisy, "seed": 4}), 20))
    assert not np.any(first == series(sensors({**noisy, "seed": 5}), 20))


# faults ---------------------------------------------------------------------------------------------------


def faulty(kind: int, **more: float) -> Instance:
    return sensors({"fault_kind[1]": kind, "fault_time[1]": 5.0, **more})


def ramped(instance: Instance) -> np.ndarray:
    """Readings while the temperature rises 1 K a sample, and channel 2 with them."""
    found = []
    for k in range(10):
        instance.set({"temperature[1]": 301.0 + k + 1, "temperature[2]": 301.0 + k + 1})
        instance.step(float(k), 1.0)
        found.append([instance.get("reading[1]"), instance.get("reading[2]")])
    return np.array(found)


def test_a_stuck_sensor_repeats_its_last_good_reading() -> None:
    first, second = ramped(faulty(1)).T
    assert first.tolist() == [302.0, 303.0, 304.0, 305.0] + [305.0] * 6
    assert second.tolist() == [302.0 + k for k in range(10)]


def test_a_jump_is_added_from_its_time_on() -> None:
    first, second = ramped(faulty(2, **{"fault_size[1]": -3.0})).T
    assert (first - second).tolist() == [0.0] * 4 + [-3.0] * 6


def test_a_drift_grows_from_its_time_on() -> None:
    first, second = ramped(faulty(3, **{"fault_rate[1]": 0.25})).T
    assert (first - second).tolist() == [0.0] * 4 + [0.25 * k for k in range(6)]


def test_a_dropout_reads_nan_and_leaves_the_others_alone() -> None:
    first, second = ramped(faulty(4)).T
    assert np.isnan(first).tolist() == [False] * 4 + [True] * 6
    assert np.all(np.isfinite(second))


def test_a_fault_at_the_start_is_there_from_the_start() -> None:
    instance = sensors({"fault_kind[1]": 4, "fault_kind[2]": 2, "fault_size[2]": 9.0})
    assert math.isnan(instance.get("reading[1]"))
    assert instance.get("reading[2]") == 311.0
