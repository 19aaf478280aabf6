"""What a sensor would have read at the start: heating may begin with the first row, or not at all."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tests.orchestration.diagnosis.fit.two_lumps import BOUNDS, OUT, SHAFT, experiment
from warmlink.orchestration.diagnosis.answer.profile import calibration
from warmlink.orchestration.diagnosis.data.experiment import calibrating
from warmlink.orchestration.diagnosis.data.start import at_start
from warmlink.orchestration.diagnosis.diagnose import diagnose_experiment, read

NOISE, ROOM = 0.05, 295.15

COURSES = {
    "at rest": lambda t: 0 * t,
    "a slow rise": lambda t: 0.003 * t,
    "heated at once": lambda t: 10 * -np.expm1(-t / 30),
    "heated after half a minute": lambda t: np.where(t > 32, 10 * -np.expm1(-(t - 32) / 30), 0.0),
}


@pytest.mark.parametrize("interval", [1.0, 5.0, 20.0, 60.0])
@pytest.mark.parametrize("name", COURSES)
def test_the_start_is_found_to_within_a_few_times_the_noise(name: str, interval: float) -> None:
    """The mean of the first minute lay 5.7 K too high where heating began at once, and its line 1.2 K."""
    time = np.arange(0.0, 3600.0, interval)
    random = np.random.default_rng(int(interval))
    found = [
        at_start(time, ROOM + COURSES[name](time) + random.normal(0, NOISE, time.size)) for _ in range(20)
    ]
    errors = np.array(found) - ROOM
    assert np.sqrt(np.mean(errors**2)) < 3 * NOISE


def test_a_spike_after_the_first_rows_and_empty_cells_change_nothing_much() -> None:
    time = np.arange(0.0, 600.0, 5.0)
    values = ROOM + np.random.default_rng(1).normal(0, NOISE, time.size)
    values[[6, 8]] = ROOM + 34, np.nan
    assert at_start(time, values) == pytest.approx(ROOM, abs=2 * NOISE)


def test_no_reading_in_the_first_minute_says_nothing() -> None:
    time = np.arange(0.0, 600.0, 5.0)
    assert at_start(time, np.where(time > 60, ROOM, np.nan)) is None


def test_nothing_but_zeros_starts_at_zero() -> None:
    assert at_start(np.arange(0.0, 100.0, 10.0), np.zeros(10)) == 0.0


def test_a_run_that_begins_while_heating_is_fitted_where_only_the_shaft_is_read(tmp_path: Path) -> None:
    """A winding of 400 J/K behind 1 W/K is 47 K above the shaft as the log begins, which no reading tells."""
    time = np.arange(-900.0, 2400.0, 1.0)
    power = np.where((time < 300) | (time > 1500), 60.0, 0.0)
    winding, shaft, body = 0.0, 0.0, []
    for heat in power:
        body.append(shaft)
        between = winding - shaft
        winding += (heat - between) / 400
        shaft += (between - OUT * shaft) / SHAFT
    logged = (time >= 0) & (time % 5 == 0)
    read_out = 22 + np.array(body)[logged] + np.random.default_rng(3).normal(0, NOISE, logged.sum())
    columns = {"time [s]": time[logged], "current [A]": np.sqrt(power[logged]), "ambient [degC]": 22.0}
    known = '"motor.winding_heat_capacity" = "400 J/K"\n"motor.winding_conductance" = "1 W/K"'
    bounds = {name: BOUNDS[name] for name in ("motor.shaft_heat_capacity", "motor.housing_conductance")}
    path = experiment(tmp_path, pd.DataFrame({**columns, "body [degC]": read_out}), bounds, known)
    text = path.read_text().replace('"wind" = "motor.winding_temperature"\n', "")
    path.write_text(text.replace('"nominal"', '"measured"'))
    found = diagnose_experiment(calibrating(read([path])))
    assert found.verdict == "adequate"
    numbers = {each.name: each.value for each in calibration(found)}
    assert numbers["motor.shaft_heat_capacity"] == pytest.approx(SHAFT, rel=0.01)
    assert numbers["motor.housing_conductance"] == pytest.approx(OUT, rel=0.01)
