"""The laws none, analytic and lag: their closed forms, their fallbacks, and how honest they are."""

import math
from collections.abc import Mapping, Sequence

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.special import erfc

from warmlink.controllers import interface
from warmlink.controllers.analytic import law as analytic_law
from warmlink.controllers.analytic.component import COMPONENT as ANALYTIC
from warmlink.controllers.lag import fit
from warmlink.controllers.lag import law as lag_law
from warmlink.controllers.lag.component import COMPONENT as LAG
from warmlink.controllers.none.component import COMPONENT as NONE
from warmlink.fmus.component import Component
from warmlink.fmus.component.instance import Instance
from warmlink.fmus.component.reference import Phase, Trajectory, integrate
from warmlink.fmus.errors import InputError
from warmlink.fmus.motor_heat_source.component import COMPONENT as MOTOR
from warmlink.fmus.plant import demand, plant

COLD = 295.15
FREE = {"correction_rate_limit": 1.0, "largest_leap": 50.0}
"""No limits, for readings that step as no thermometer's do."""
ALPHA, DIFFUSIVITY, SPAN = 23.6e-6, 167 / (2713 * 892), 0.2916


def running(component: Component, values: Mapping[str, float]) -> Instance:
    instance = Instance(component)
    instance.set(values)
    instance.initialize()
    return instance


@pytest.mark.parametrize("component", [NONE, ANALYTIC, LAG], ids=lambda c: c.name)
def test_they_stand_in_for_one_another(component: Component) -> None:
    assert component.inputs == interface.INPUTS
    assert component.outputs == interface.OUTPUTS


def test_none_corrects_nothing_and_knows_it() -> None:
    instance = running(NONE, {"speed": 3.0, "base_temperature": 320.0})
    instance.step(0.0, 1.0)
    assert instance.outputs().tolist() == [0.0, 0.0, 5e-5, 0.0, 0.0, 0.0]
    assert running(NONE, {"elongation_std": 2e-6}).get("ready") == 1.0


# analytic -------------------------------------------------------------------------------------------------


def test_the_printed_form_shrinks_as_the_paper_does_not_say() -> None:
    def printed(time: float) -> float:
        return analytic_law.printed(14.0, math.sqrt(DIFFUSIVITY * time), SPAN, ALPHA) * 1e6

    assert printed(900.0) == pytest.approx(86.9, abs=0.05)
    assert printed(3600.0) == pytest.approx(57.0, abs=0.05)


@settings(max_examples=30)
@given(time=st.floats(1.0, 1e5), rise=st.floats(-40, 40))
def test_the_corrected_form_is_the_integral_over_the_link(time: float, rise: float) -> None:
    depth = math.sqrt(DIFFUSIVITY * time)
    found = analytic_law.corrected(rise, depth, SPAN, ALPHA)
    integral, _ = quad(lambda x: erfc(x / (2 * depth)), 0, SPAN, epsabs=1e-13, points=[min(SPAN / 2, depth)])
    assert found == pytest.approx(ALPHA * rise * integral, rel=1e-9, abs=1e-18)


@pytest.mark.parametrize("form", [0, 1])
@pytest.mark.parametrize("source", ["base", "shaft"])
def test_the_law_follows_its_form_from_when_heating_began(form: int, source: str) -> None:
    values = {**FREE, "form": form, "temperature_source": ["base", "shaft"].index(source)}
    instance = running(ANALYTIC, values)
    other = "shaft" if source == "base" else "base"
    for k in range(20):
        instance.step(float(k), 1.0)
    assert instance.get("correction") == 0.0, "no heat, no correction"
    instance.set({f"{source}_temperature": COLD + 10.0, f"{other}_temperature": COLD + 33.0})
    for k in range(300):
        instance.step(20.0 + k, 1.0)
    depth = math.sqrt(DIFFUSIVITY * 300)
    expected = (analytic_law.printed, analytic_law.corrected)[form](10.0, depth, SPAN, ALPHA)
    assert instance.get("correction") == pytest.approx(expected, rel=1e-12)
    assert instance.get("predicted_elongation") == instance.get("correction")


def test_heating_begins_anew_after_the_link_has_cooled() -> None:
    instance = running(ANALYTIC, FREE)
    warm, cold = {"base_temperature": COLD + 10.0}, {"base_temperature": COLD + 0.3}
    corrections = []
    for k, values in enumerate([warm] * 50 + [cold] * 5 + [warm] * 50):
        instance.set(values)
        instance.step(float(k), 1.0)
        corrections.append(instance.get("correction"))
    assert corrections[50:55] == [0.0] * 5
    assert corrections[55:] == corrections[:50]


def test_nan_holds_the_last_good_reading_and_is_told() -> None:
    instance = running(ANALYTIC, FREE)
    twin = running(ANALYTIC, FREE)
    for each in (instance, twin):
        each.set({"base_temperature": COLD + 10.0})
        each.step(0.0, 1.0)
    instance.set({"base_temperature": math.nan})
    for k in range(1, 5):
        instance.step(float(k), 1.0)
        twin.step(float(k), 1.0)
        assert instance.get("distrusted") == 1.0
        assert instance.get("correction") == twin.get("correction")
    instance.set({"base_temperature": COLD + 10.0, "tip_temperature": math.nan})
    instance.step(5.0, 1.0)
    assert instance.get("distrusted") == 0.0, "a sensor that the law does not use is no matter"


def test_nan_from_the_start_goes_by_the_surroundings() -> None:
    instance = running(ANALYTIC, {"base_temperature": math.nan, "ambient_temperature": 300.0})
    instance.step(0.0, 1.0)
    assert instance.get("distrusted") == 1.0
    assert instance.get("correction") == 0.0
    instance.set({"base_temperature": 310.0})
    for k in range(1, 61):
        instance.step(float(k), 1.0)
    depth = math.sqrt(DIFFUSIVITY * 60)
    expected = analytic_law.corrected(10.0, depth, SPAN, ALPHA)
    assert instance.get("correction") == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("by", [3.0, 5.0, -5.0])
def test_a_step_of_the_base_is_doubted_for_a_while_and_not_for_ever(by: float) -> None:
    """Beyond `largest_leap` it was left out for good, and the law said ready."""
    instance = running(ANALYTIC, {"base_temperature": COLD})
    for k in range(30):
        instance.step(float(k), 1.0)
    instance.set({"base_temperature": COLD + by})
    instance.step(30.0, 1.0)
    assert (instance.get("distrusted"), instance.get("ready")) == (1.0, 0.0)
    wait = (abs(by) - 2.0) / 0.05
    for k in range(31, 34 + round(wait)):
        instance.step(float(k), 1.0)
    assert instance.get("distrusted") == 0.0
    assert math.copysign(1.0, by) * instance.get("predicted_elongation") > 0


def test_a_link_that_was_left_warm_is_not_ready_until_its_cold_temperature_is_stated() -> None:
    """The first reading counted as the cold link's: 90 um off, and ready all the time."""
    given = {"base_temperature": COLD + 20.0, "ambient_temperature": COLD}
    assert running(ANALYTIC, given).get("ready") == 0.0
    assert running(ANALYTIC, {**given, "base_temperature": COLD + 1.0}).get("ready") == 1.0
    assert running(ANALYTIC, {**given, "ambient_temperature": COLD + 20.0}).get("ready") == 1.0


@pytest.mark.parametrize(("leaps_at", "believed"), [(9, True), (10, False)])
def test_a_leap_is_believed_for_ten_seconds_of_readings(leaps_at: int, believed: bool) -> None:
    """The first reading, at the start, may be the wrong one; one that leaps later is."""
    instance = running(ANALYTIC, {"base_temperature": COLD - 25.0, "ambient_temperature": COLD})
    for k in range(leaps_at):
        instance.step(float(k), 1.0)
    instance.set({"base_temperature": COLD})
    instance.step(float(leaps_at), 1.0)
    assert instance.get("distrusted") == (0.0 if believed else 1.0)


# lag ------------------------------------------------------------------------------------------------------


def test_the_losses_are_those_of_the_motor() -> None:
    """At 20 degC winding and 22 degC shaft, where the motor's coefficients have no effect."""
    p = np.array([Instance(MOTOR).get(name) for name in MOTOR.p.names])
    u = np.array([{"speed": -3.1, "torque": 2.2}.get(name, COLD) for name in MOTOR.u.names])
    for name in ("current", "pad_mode", "pad_power", "added_shaft_heat", "added_winding_heat"):
        u[MOTOR.u.index[name]] = 0.0
    rates = MOTOR.rates_of(np.array([293.15, 295.15, 0.0]), u, p, 0.0)
    # Housing and joint are without effect at room temperature; what passes from shaft to winding cancels.
    made = 200 * rates[0] + 1500 * rates[1]
    values = {name: Instance(LAG).get(name) for name in LAG.p.names}
    duty = LAG.u.read(np.array([{"speed": -3.1, "torque": 2.2}.get(name, 0.0) for name in LAG.u.names]))
    record = LAG.d.read(np.array(list(values.values())))
    assert lag_law.loss(duty, record) == pytest.approx(made, rel=1e-12)


def test_constant_losses_give_an_exponential_at_any_sample_time() -> None:
    loss = 2.0 * (2.5 / 1.2) ** 2 + 0.15 * 3.43**2 + (1.5 + 0.6 * 3.43) * 3.43
    for period in (0.5, 1.0, 30.0):
        instance = running(LAG, {"speed": 3.43, "torque": 2.5, "sample_time": period})
        for k in range(1, 41):
            instance.step((k - 1) * period, period)
            expected = 4.21e-6 * loss * -math.expm1(-k * period / 2440)
            assert instance.get("correction") == pytest.approx(expected, rel=1e-12)


def test_a_fit_finds_what_made_the_data() -> None:
    rng = np.random.default_rng(2)
    time = np.arange(0.0, 7200.0, 10.0)
    loss = np.repeat(rng.uniform(0, 30, 24), 30)
    found = fit.first_order(time, loss, fit.response(time, loss, 3.3e-6, 1234.0))
    assert found.gain == pytest.approx(3.3e-6, rel=1e-4)
    assert found.time_constant == pytest.approx(1234.0, rel=1e-4)
    with pytest.raises(InputError, match="fit the lag law to a run in which the motor works"):
        fit.first_order(time, 0 * loss, loss)
    with pytest.raises(InputError, match="fit the lag law to a run in which the motor works"):
        fit.first_order(time, np.where(time < time[-1], 0.0, 5.0), loss)  # too late to warm anything
    with pytest.raises(InputError, match="growth is not finite; leave such rows out"):
        fit.first_order(time, loss, np.where(time < time[3], np.nan, 1e-6))


# the nominal cell -----------------------------------------------------------------------------------------

RECORD = ("link.elongation", "link.base_temperature", "motor.shaft_temperature")
EVERY = 10.0

_draws = np.random.default_rng(0)
DUTIES: dict[str, list[Phase]] = {
    "full": [demand(7200, 3.43, 2.5)],
    "half": [demand(7200, 1.7, 2.5)],
    "breaks": [demand(3600, 3.43, 2.5), demand(1800, 0, 0), demand(3600, 3.43, 2.5), demand(1800, 0, 0)],
    "heavy": [demand(7200, 2.0, 4.0)],
    "random": [demand(900, _draws.uniform(0, 3.5), _draws.uniform(0, 3)) for _ in range(8)],
}


@pytest.fixture(scope="module")
def runs() -> dict[str, Trajectory]:
    return {
        name: integrate(plant(), phases, RECORD, every=EVERY, tolerance=1e-7)
        for name, phases in DUTIES.items()
    }


def duty_series(phases: Sequence[Phase], count: int) -> np.ndarray:
    """Speed and torque at each recorded point, shape (count, 2)."""
    rows = [
        (phase.inputs["motor.speed"], phase.inputs["motor.torque"])
        for phase in phases
        for _ in range(round(phase.duration / EVERY))
    ]
    return np.array([*rows, rows[-1]])[:count]


def errors(
    name: str, run: Trajectory, law: Component, values: Mapping[str, float]
) -> tuple[np.ndarray, np.ndarray]:
    """Elongation minus correction, and the standard deviation stated, at each recorded point."""
    instance = Instance(law)
    instance.set({**values, "sample_time": EVERY})
    true = run.values["link.elongation"]
    found = []
    for k, (speed, torque) in enumerate(duty_series(DUTIES[name], len(true))):
        if k:
            # The demand of the step that ends here, the temperatures found at its end.
            instance.step((k - 1) * EVERY, EVERY)
            found.append((instance.get("correction"), instance.get("correction_std")))
        instance.set(
            {
                "speed": speed,
                "torque": torque,
                "base_temperature": run.values["link.base_temperature"][k],
                "shaft_temperature": run.values["motor.shaft_temperature"][k],
            }
        )
        if k == 0:
            instance.initialize()
            found.append((instance.get("correction"), instance.get("correction_std")))
    correction, std = np.array(found).T
    return true - correction, std


def test_the_lags_parameters_are_the_fit_to_the_nominal_cell(runs: dict[str, Trajectory]) -> None:
    run = runs["full"]
    loss = 2.0 * (2.5 / 1.2) ** 2 + 0.15 * 3.43**2 + (1.5 + 0.6 * 3.43) * 3.43
    found = fit.first_order(run.time, np.full(len(run.time), loss), run.values["link.elongation"])
    declared = Instance(LAG)
    assert declared.get("gain") == pytest.approx(found.gain, rel=2e-3)
    assert declared.get("time_constant") == pytest.approx(found.time_constant, rel=2e-3)
    assert found.residual_rms == pytest.approx(2.67e-6, abs=0.02e-6)


def test_what_the_readmes_say_the_laws_leave(runs: dict[str, Trajectory]) -> None:
    run = runs["full"]
    assert run.values["link.elongation"].max() == pytest.approx(88e-6, abs=0.5e-6)
    assert np.abs(errors("full", run, LAG, {})[0]).max() == pytest.approx(7e-6, abs=0.3e-6)
    assert np.abs(errors("full", run, ANALYTIC, {})[0]).max() == pytest.approx(29e-6, abs=0.5e-6)


@pytest.mark.parametrize("name", DUTIES)
@pytest.mark.parametrize(
    ("law", "values"),
    [(ANALYTIC, {}), (ANALYTIC, {"temperature_source": 1, "relative_error": 0.3}), (LAG, {})],
    ids=["base", "shaft", "lag"],
)
def test_two_standard_deviations_cover_nine_tenths(
    runs: dict[str, Trajectory], name: str, law: Component, values: Mapping[str, float]
) -> None:
    error, std = errors(name, runs[name], law, values)
    assert np.mean(np.abs(error) <= 2 * std) >= 0.9


def test_ready_is_said_where_two_standard_deviations_fit_the_tolerance() -> None:
    instance = running(LAG, {"speed": 3.43, "torque": 2.5})
    said = []
    for k in range(600):
        instance.step(float(k), 1.0)
        said.append((instance.get("ready"), 2 * instance.get("correction_std") <= 5e-6))
    assert said[0] == (1.0, True)
    assert said[-1] == (0.0, False)
    assert all(bool(ready) == fits for ready, fits in said)
