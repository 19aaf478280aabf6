"""The observers as laws: both arithmetics, state, starts, and the outputs' meaning."""

import json
import math
from collections.abc import Mapping
from dataclasses import asdict

import casadi as ca
import numpy as np
import pytest

from warmlink.controllers import interface
from warmlink.controllers.export.core import designed
from warmlink.controllers.observer.component import COMPONENT as OBSERVER
from warmlink.controllers.observer.filters import filters_of
from warmlink.controllers.observer_drift.component import COMPONENT as DRIFT
from warmlink.controllers.regression.component import COMPONENT as REGRESSION
from warmlink.controllers.replay import ReplayedOutputs, replay
from warmlink.fmus.component import Component
from warmlink.fmus.component.instance import Instance, Snapshot

LAWS = [OBSERVER, DRIFT, REGRESSION]
COLD = 295.15


def running(component: Component, values: Mapping[str, float]) -> Instance:
    instance = Instance(component)
    instance.set(values)
    instance.initialize()
    return instance


def inputs(k: int, draw: np.random.Generator) -> dict[str, float]:
    """What a cell that warms might send, with a sensor missing now and then and a camera."""
    rise = 10 * (1 - math.exp(-k / 300)) + 0.1 * draw.normal(size=5)
    values = dict(zip(interface.SENSED, COLD + rise, strict=True))
    if k % 7 == 3:
        values["base_temperature"] = math.nan
    return {
        **values,
        "speed": 3.0 * (k % 50 < 40),
        "torque": 2.0,
        "measured_drift": 1e-7 * (k // 30),
        "drift_valid": 1.0,
    }


@pytest.mark.parametrize("component", LAWS, ids=lambda c: c.name)
def test_they_stand_in_for_one_another(component: Component) -> None:
    assert component.inputs == interface.INPUTS
    assert component.outputs[: len(interface.OUTPUTS)] == interface.OUTPUTS


@pytest.mark.parametrize("component", LAWS, ids=lambda c: c.name)
def test_expressions_give_what_floats_give(component: Component) -> None:
    layouts = (component.x, component.u, component.d)
    x, u, p = (ca.SX.sym(n, layout.size) for n, layout in zip("xup", layouts, strict=True))
    start = ca.Function("start", [u, p], [component.states_at_start(u, p)])
    update = ca.Function("update", [x, u, p], [component.updated(x, u, p, 0.0, 1.0)])
    observe = ca.Function("observe", [x, u, p], [component.outputs_of(x, u, p, 0.0)])
    draw = np.random.default_rng(1)
    flat_p, flat_u = component.start_values()
    flat_p = component.settled(flat_p)
    state = component.states_at_start(flat_u, flat_p)
    assert start(flat_u, flat_p).full().ravel() == pytest.approx(state, rel=1e-12, abs=1e-15)
    for k in range(60):
        for name, value in inputs(k, draw).items():
            flat_u[component.u.index[name]] = value
        symbolic = update(state, flat_u, flat_p).full().ravel()
        state = component.updated(state, flat_u, flat_p, 0.0, 1.0)
        assert symbolic == pytest.approx(state, rel=1e-9, abs=1e-13)
        assert observe(state, flat_u, flat_p).full().ravel() == pytest.approx(
            component.outputs_of(state, flat_u, flat_p, 0.0), rel=1e-9, abs=1e-13
        )


@pytest.mark.parametrize("component", LAWS, ids=lambda c: c.name)
def test_a_restored_law_goes_on_bit_for_bit(component: Component) -> None:
    instance, draw = running(component, {}), np.random.default_rng(2)
    sent = [inputs(k, draw) for k in range(60)]
    for k in range(30):
        instance.set(sent[k])
        instance.step(float(k), 1.0)
    kept = json.loads(json.dumps(asdict(instance.snapshot())))

    def rest(each: Instance) -> list[list[float]]:
        found = []
        for k in range(30, 60):
            each.set(sent[k])
            each.step(float(k), 1.0)
            found.append(each.outputs().tolist())
        return found

    first = rest(instance)
    other = Instance(component)
    other.restore(Snapshot(**kept))
    assert rest(other) == first
    instance.restore(Snapshot(**kept))
    assert rest(instance) == first


@pytest.mark.parametrize("component", [OBSERVER, DRIFT], ids=lambda c: c.name)
@pytest.mark.parametrize("used", [(), (0,), (2,), (2, 4), (0, 1, 2, 3, 4)], ids=str)
def test_any_subset_of_sensors_will_do(component: Component, used: tuple[int, ...]) -> None:
    values = {f"sensor_std[{i + 1}]": 0.1 if i in used else 0.0 for i in range(5)}
    unused = {name: math.nan for i, name in enumerate(interface.SENSED) if i not in used}
    instance = running(component, {**values, **unused})
    said = []
    for k in range(12):
        instance.step(float(k), 1.0)
        said.append(instance.get("ready"))
    assert instance.get("distrusted") == 0.0, "a sensor that the law does not use is no matter"
    assert abs(instance.get("correction")) < 1e-7
    # Nobody knows at once how warm the cell is; thermometers tell within 10 s, and without any it is hours.
    assert said == [0.0] * 9 + [1.0] * 3 if used else not any(said)


def test_every_sensor_gone_leaves_the_duty() -> None:
    duty = {"speed": 3.43, "torque": 2.5, "sample_time": 10.0}
    alone = running(OBSERVER, {**duty, **{f"sensor_std[{i}]": 0.0 for i in range(1, 6)}})
    blind = running(OBSERVER, {**duty, **dict.fromkeys(interface.SENSED, math.nan)})
    for each in (alone, blind):
        each.step(0.0, 1800.0)
    assert blind.get("distrusted") == 1.0
    assert blind.get("correction") == pytest.approx(alone.get("correction"), rel=1e-9)
    assert blind.get("correction") > 30e-6


def test_a_warm_start_is_recognised_and_bumpless() -> None:
    """A cell left warm: the estimate begins near what the readings say, the correction goes there slowly."""
    warm = dict(zip(interface.SENSED, COLD + np.array([20.0, 21.0, 15.0, 11.0, 10.0]), strict=True))
    instance = running(OBSERVER, warm)
    # Between the growth of a link at the tip's and at the base's temperature throughout.
    predicted = instance.get("predicted_elongation")
    assert 10 * 6.88e-6 < predicted < 15 * 6.88e-6
    assert instance.get("correction") == 0.0
    assert (instance.get("ready"), instance.get("warning")) == (0.0, 1.0)
    last = 0.0
    for k in range(60):
        instance.step(float(k), 1.0)
        assert abs(instance.get("correction") - last) <= 2e-6 * (1 + 1e-9)
        last = instance.get("correction")
    assert last == pytest.approx(instance.get("predicted_elongation"), abs=1e-12)
    assert instance.get("warning") == 0.0


def test_what_a_limit_holds_back_counts_in_the_uncertainty() -> None:
    instance = running(OBSERVER, {"base_temperature": COLD + 15, "tip_temperature": COLD + 10})
    assert instance.get("correction_std") >= instance.get("predicted_elongation")


def test_doubt_about_the_expansion_is_added_where_given() -> None:
    warm = {"base_temperature": COLD + 15, "tip_temperature": COLD + 10, "correction_rate_limit": 1.0}
    sure, unsure = running(OBSERVER, warm), running(OBSERVER, {**warm, "relative_std": 0.02})
    for each in (sure, unsure):
        each.step(0.0, 10.0)
    added = unsure.get("correction_std") ** 2 - sure.get("correction_std") ** 2
    assert added == pytest.approx((0.02 * unsure.get("predicted_elongation")) ** 2, rel=1e-6)


def felt(rise: np.ndarray, steps: int, draw: np.random.Generator) -> np.ndarray:
    """Readings of a cell in K, with their noise, shape (steps, 5)."""
    return COLD + rise + 0.1 * draw.normal(size=(steps, 5))


def under_a_pad(steps: int, heard: int | None = None) -> np.ndarray:
    """Readings at rest while the cell warms as under a pad, in samples of 10 s; so many are heard."""
    warmed = 1 - np.exp(-np.arange(steps)[:, None] / 200)
    readings = felt(np.array([8.0, 9.0, 6.0, 4.0, 3.5]) * warmed, steps, np.random.default_rng(3))
    readings[heard if heard is not None else steps :] = math.nan
    return readings


def said_of(
    component: Component, readings: np.ndarray, measured: np.ndarray | None = None, **values: float
) -> ReplayedOutputs:
    """What a law says after each sample, from a cold start; a camera sees what is left of the measured."""
    start = component.start_values()[1]
    rows = np.tile(start, (len(readings) + 1, 1))
    rows[1:, [component.u.index[name] for name in interface.SENSED]] = readings
    seen = None if measured is None else np.concatenate([[math.nan], measured])
    found = replay(designed(component, values), rows, seen)
    return ReplayedOutputs(*(each[1:] for each in vars(found).values()))


def test_the_doubt_stays_while_nothing_could_show_that_a_heat_has_gone() -> None:
    """All thermometers gone with a pad on: the law is no surer of itself hours later."""
    said = said_of(OBSERVER, under_a_pad(1100, heard=200), sample_time=10.0)
    at_once, later = said.correction_std[209], said.correction_std[1099]
    assert at_once > 0.1e-6
    assert later > at_once
    assert said.ready[1099] == 0.0


@pytest.mark.parametrize("sample_time", [10.0, 60.0, 300.0])
def test_sound_sensors_are_trusted_at_any_sample_time(sample_time: float) -> None:
    readings = felt(np.zeros(5), 250, np.random.default_rng(4))
    assert np.mean(said_of(OBSERVER, readings, sample_time=sample_time).distrusted) < 0.02


# the camera -----------------------------------------------------------------------------------------------


def with_camera(drift: float, valid: float = 1.0, seconds: int = 400, **values: float) -> Instance:
    """A cold cell at rest whose camera says, each 30 s, that the tool point is off by a constant amount.

    Sensors have their noise, and the camera's reading a nanometre to and fro: a reading that repeats itself
    would be no news.
    """
    instance = running(DRIFT, {"sample_time": 10.0, **values})
    draw = np.random.default_rng(6)
    for k in range(seconds // 10):
        instance.set(dict(zip(interface.SENSED, COLD + 0.1 * draw.normal(size=5), strict=True)))
        if k % 3 == 0 and k:
            remaining = drift - instance.get("correction") + 1e-9 * (k % 2)
            instance.set({"measured_drift": remaining, "drift_valid": valid})
        instance.step(10.0 * k, 10.0)
    return instance


def test_a_constant_error_that_only_the_camera_sees_vanishes() -> None:
    """Within what the thermometers' noise leaves; without the camera it stays."""
    taught, alone = with_camera(2e-6, seconds=3000), with_camera(2e-6, valid=0.0, seconds=3000)
    assert taught.get("correction") - 2e-6 == pytest.approx(0.0, abs=0.1e-6)
    assert alone.get("correction") == pytest.approx(0.0, abs=0.3e-6)
    states = DRIFT.x.read(np.array(taught.snapshot().states))
    offset = filters_of(states).quiet.mean[-1]
    assert offset + alone.get("correction") == pytest.approx(2e-6, abs=0.06e-6)


def test_a_camera_that_is_not_valid_teaches_nothing() -> None:
    blind, absent = with_camera(2e-6, valid=0.0), with_camera(0.0, valid=0.0)
    assert blind.get("correction") == absent.get("correction")


def test_the_camera_may_add_no_more_than_its_authority() -> None:
    instance = with_camera(50e-6, seconds=3000, gate=1e9)
    assert instance.get("correction") == pytest.approx(3e-6, abs=0.3e-6)
    assert instance.get("distrusted") == 1.0


def test_a_camera_that_leaps_is_left_out() -> None:
    instance = with_camera(50e-6, seconds=900)
    assert abs(instance.get("correction")) < 1e-6
    assert instance.get("distrusted") == 1.0


@pytest.mark.parametrize("drift", [2e-6, 3e-6, -2e-6])
def test_the_camera_does_not_move_the_temperatures(drift: float) -> None:
    taught, alone = with_camera(drift, seconds=300), with_camera(drift, valid=0.0, seconds=300)
    filters = [filters_of(DRIFT.x.read(np.array(each.snapshot().states))) for each in (taught, alone)]
    pairs = [(each.alert, each.quiet) for each in filters]
    for one, other in zip(*pairs, strict=True):
        assert np.array_equal(one.mean[:-2], other.mean[:-2])
        assert not np.array_equal(one.mean[-2:], other.mean[-2:])


def test_without_a_camera_the_law_is_the_observer() -> None:
    """With heat that no input tells of, too: doubt about it is none about the expansion."""
    with_its_states, plain = running(DRIFT, {"sample_time": 10.0}), running(OBSERVER, {"sample_time": 10.0})
    for each in (with_its_states, plain):
        for k, readings in enumerate(under_a_pad(120)):
            each.set(dict(zip(interface.SENSED, readings, strict=True)))
            each.step(10.0 * k, 10.0)
    assert plain.get("correction_std") > 0.05e-6
    for name in ("correction", "predicted_elongation", "correction_std", "ready", "distrusted"):
        assert with_its_states.get(name) == pytest.approx(plain.get(name), rel=1e-9, abs=1e-15)


def test_what_a_lying_camera_taught_does_not_wind_up() -> None:
    """It drifts off beyond what is believed of it, is mended, and is soon followed again."""
    k = np.arange(840)
    lie = np.where(k < 600, np.minimum(10e-6 / 3600 * 10 * k, 5.5e-6), 0.0)
    measured = np.where(k % 3 == 0, lie + 1e-9 * (k % 2), math.nan)
    readings = felt(np.zeros(5), 840, np.random.default_rng(5))
    said = said_of(DRIFT, readings, measured, sample_time=10.0).correction
    assert max(said) == pytest.approx(3e-6, abs=0.3e-6)
    assert abs(said[-1]) < 0.3e-6
