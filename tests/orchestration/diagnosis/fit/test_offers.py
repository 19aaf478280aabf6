"""Which candidates each cause of the catalogue offers for a log, by what the log has."""

from __future__ import annotations

from collections.abc import Mapping

import pandas as pd
import pytest

import warmlink as wl
from warmlink.orchestration.diagnosis.data.measured import names_of
from warmlink.orchestration.diagnosis.diagnose import read
from warmlink.orchestration.diagnosis.fit.offers import freed_by

Offers = Mapping[str, Mapping[str, tuple[str, ...]]]


@pytest.fixture(scope="module")
def log() -> pd.DataFrame:
    return wl.hide(seed=1).iloc[::20]


def offers_for(log: pd.DataFrame) -> Offers:
    """What is freed, by candidate, by cause."""
    experiment = read([log])
    names = names_of(experiment.columns)
    return {cause.name: dict(freed_by(cause, experiment, names)) for cause in experiment.catalogue}


@pytest.fixture(scope="module")
def offered(log: pd.DataFrame) -> Offers:
    return offers_for(log)


def test_a_cause_in_the_plant_is_one_candidate_with_all_that_it_frees(offered: Offers) -> None:
    assert offered["radiation"] == {"radiation": ("link.emissivity",)}
    assert offered["ambient_offset"] == {"ambient_offset": ("motor.ambient_offset", "link.ambient_offset")}


def test_what_nothing_feeds_and_what_no_log_shows_is_not_offered(offered: Offers) -> None:
    assert offered["neighbour_heat"] == {}
    assert offered["communication_step"] == {}


def test_each_column_may_have_an_offset_and_only_thermometers_are_late(offered: Offers) -> None:
    thermometers = [f"{at}_temperature" for at in ("shaft", "winding", "base", "middle", "tip")]
    lags, offsets = offered["sensor_lag"], offered["sensor_offset"]
    assert list(lags) == [f"sensor_lag:{name}" for name in thermometers]
    assert list(offsets) == [f"sensor_offset:{name}" for name in (*thermometers, "elongation")]
    freed = [*lags.values(), *offsets.values()]
    assert len(set(freed)) == len(freed) == 11, "no two free the same"
    assert offsets["sensor_offset:elongation"] == ("camera.offset",)


def test_only_thermometers_on_the_link_can_sit_elsewhere(offered: Offers) -> None:
    places = [f"sensor_position:{at}_temperature" for at in ("base", "middle", "tip")]
    assert list(offered["sensor_position"]) == places


def test_the_only_camera_needs_no_channel_in_its_name(offered: Offers) -> None:
    assert offered["camera_drift"] == {"camera_drift": ("camera.drift_rate",)}


def test_temperatures_are_not_scaled_and_no_switch_and_no_surroundings_are_wrong_inputs(
    offered: Offers, log: pd.DataFrame
) -> None:
    logged = {name.partition(" ")[0] for name in log}
    assert {"speed", "torque", "pad_temperature", "ambient_temperature"} <= logged
    assert list(offered["input_scale"]) == ["input_scale:speed", "input_scale:torque"]
    assert list(offered["input_offset"]) == [
        f"input_offset:{name}" for name in ("speed", "torque", "pad_temperature")
    ]
    assert offered["input_scale"]["input_scale:torque"] == ("logged.scale:motor.torque",)


def test_what_was_not_logged_has_no_fault(log: pd.DataFrame) -> None:
    fewer = offers_for(log.drop(columns=["middle_temperature [degC]", "elongation [um]"]))
    assert "sensor_offset:middle_temperature" not in fewer["sensor_offset"]
    assert fewer["camera_drift"] == {}
    assert set(fewer["clock_offset"]) == {"clock_offset", "clock_offset:motor", "clock_offset:link"}
