"""Signals that lie: a sample of what `python -m benchmarks.faults` runs."""

import math
import os
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.fault_kinds import Kind, kinds
from benchmarks.faults import ALLOWED, ALLOWED_READY, LAWS, bench_faults, rig, trial, truth_of
from benchmarks.law_trials import AS_MODELLED
from warmlink.controllers.interface import SENSED
from warmlink.controllers.observer.component import COMPONENT as OBSERVER
from warmlink.controllers.observer_drift.component import COMPONENT as DRIFT
from warmlink.controllers.regression.component import COMPONENT as REGRESSION
from warmlink.fmus.component import Component
from warmlink.fmus.component.instance import Instance, Snapshot
from warmlink.fmus.errors import InputError

KINDS = {kind.name: kind for kind in kinds()}

SOUND = Kind("none", "sound", lambda told, draw: told)

OUTVOTED = (
    *("both drifts", "both delayed", "both rise", "both gone", "both +"),
    *("base on winding", "base and tip swapped"),
)
"""How kinds begin in which most signals that could tell may be wrong to one side; the README lists them."""

LEAP = 3600
"""s into a run at which thermometers leap."""


@pytest.mark.parametrize(
    "name",
    [
        "torque one sample of 1000 while it runs",
        "torque one sample of 200 while it runs",
        "torque x 2 from the start",
        "torque x 3 from the start",
        "torque and speed missing while it runs",
        "speed x 9.5493 from the start",
        "ambient +40 K from the start",
        "ambient +20 K while it runs",
        "ambient in degC while it runs",
        "both +5 K from the start",
        "base -5 K from the start",
        "both delayed 30 min while it runs",
        "both drifts +5 K/h while it runs",
        "restart at 0.7 of the run after 1 s with nothing retained, thermometers gone",
    ],
)
def test_what_was_found_on_the_floor_costs_no_more_than_no_compensation(name: str) -> None:
    """Each cost up to 500 um once, or had `ready` said for an hour at 76 um."""
    found = trial("observer", KINDS[name], "windshield_wiper", 0, 31)
    assert found.worse_by <= ALLOWED
    if found.group in {"duty", "ambient", "restarts"}:
        assert found.ready_wrong <= ALLOWED_READY


def test_a_sample_of_all_kinds_in_any_duty_cycle() -> None:
    chosen = [str(name) for name in np.random.default_rng(20261122).permutation(list(KINDS))[:12]]
    runs = bench_faults(chosen, 1, 20261122, laws=["observer"])
    assert {run.kind for run in runs} == set(chosen)
    assert max(run.worse_by for run in runs) <= ALLOWED


def test_a_fresh_sample_of_kinds_in_any_duty_cycle() -> None:
    """Drawn anew in each session, models right and wrong; the seed repeats one, `WARMLINK_FAULTS_SEED`."""
    seed = int(os.environ.get("WARMLINK_FAULTS_SEED") or np.random.SeedSequence().generate_state(1)[0])
    print(f"WARMLINK_FAULTS_SEED={seed}")
    told = [name for name in KINDS if not name.startswith(OUTVOTED) and "thermometers gone" not in name]
    chosen = [str(name) for name in np.random.default_rng(seed).permutation(told)[:12]]
    runs = bench_faults(chosen, 1, seed, laws=["observer"])
    assert {run.kind for run in runs} == set(chosen)
    assert max(run.worse_by for run in runs) <= ALLOWED


def test_without_a_fault_nothing_is_doubted() -> None:
    found = trial("observer", SOUND, "windshield_wiper", 0, 1)
    assert found.worse_by <= 0.1 * ALLOWED
    assert found.ready_share > 0.99


@pytest.mark.parametrize(
    ("name", "duty", "plant"),
    [
        ("both drifts -5 K/h while it runs", "heavy_payload", 0),
        ("both drifts +5 K/h while it runs", "pick_and_place_fast", 0),
        ("both drifts +20 K/h while it runs", "still_with_pad", 0),
        ("base drifts +5 K/h while it runs", "moving_with_pad", 0),
        ("tip drifts +5 K/h while it runs", "heavy_payload", 0),
        ("both +2 K from the start", "stop_and_go", 776957),
        ("base +2 K from the start", "continuous", 448420),
        ("both +2 K from the start", "continuous", 239498),
        ("base on winding from the start", "windshield_wiper", 0),
        ("base +5 K from the start", "still_with_pad", 0),
        ("both +1 K from the start", "moving_with_pad", 0),
        ("both +2 K from the start", "still_with_pad", 0),
        ("both +20 K from the start", "moving_with_pad", 0),
        ("both stuck from the start", "still_with_pad", 0),
    ],
)
def test_what_thermometers_are_off_by_is_contradicted(name: str, duty: str, plant: int) -> None:
    """`ready` was said for 5 to 99 % of these runs while the error was beyond the tolerance.

    Or the error was 120 um larger than without correction: a pad's heat was taken for a cell left warm.
    """
    found = trial("observer", KINDS[name], duty, plant, 31)
    assert found.ready_wrong <= ALLOWED_READY
    assert found.worse_by <= ALLOWED


@pytest.mark.parametrize(
    ("name", "duty", "plant", "seed"),
    [
        ("base drifts +1 K/h while it runs", "continuous", 634161, 967747546),
        ("base drifts +5 K/h while it runs", "random_jobs", 634161, 282006232),
        ("base drifts -5 K/h while it runs", "heavy_payload", 762362, 146941892),
        ("tip drifts +1 K/h while it runs", "rising_hall_temperature", 0, 748432741),
    ],
)
def test_one_thermometer_that_drifts_alone_is_contradicted(
    name: str, duty: str, plant: int, seed: int
) -> None:
    """`ready` was wrong in 24 to 37 % of these runs, where a wrong model explained the growth."""
    assert trial("observer", KINDS[name], duty, plant, seed).ready_wrong <= 0.02


@pytest.mark.parametrize(
    ("name", "duty", "plant", "seed"),
    [
        ("both -1 K while it runs", "stop_and_go", 35673, 345796596),
        ("both -1 K while it runs", "light_payload", 1028389, 116937022),
        ("both +1 K while it runs", "light_payload", 166346, 729106728),
        ("both -2 K while it runs", "still_with_pad", 986019, 741185731),
        ("base -2 K while it runs", "emergency_stop", 804618, 987145470),
    ],
)
def test_thermometers_that_leapt_are_not_believed_because_a_wrong_model_meets_them(
    name: str, duty: str, plant: int, seed: int
) -> None:
    """`ready` was wrong in 31 to 65 % of these runs: left out at first, they agreed with the duty later."""
    assert trial("observer", KINDS[name], duty, plant, seed).ready_wrong <= ALLOWED_READY


@pytest.mark.parametrize("who", [("base",), ("base", "tip")])
def test_a_leap_there_and_back_is_no_offset(who: tuple[str, ...]) -> None:
    told = replace(truth_of("windshield_wiper", 31), parameters=AS_MODELLED)
    for each in who:
        told = told.changed(f"{each}_temperature", 345.0, slice(LEAP, LEAP + 5))
    ready = rig("observer").run(told).ready
    assert not ready[LEAP : LEAP + 60].any()
    assert ready[LEAP + 120 :].mean() > 0.95


@pytest.mark.parametrize("plant", [0, 31])
def test_what_thermometers_warmed_by_while_they_read_nothing_is_no_offset(plant: int) -> None:
    """Ten minutes of -200 degC, and `ready` never came back: what the link warmed by counted as an offset."""
    told = replace(truth_of("windshield_wiper", plant), parameters=AS_MODELLED)
    for each in ("base", "tip"):
        told = told.changed(f"{each}_temperature", 73.15, slice(1200, 1800))
    found = rig("observer").run(told)
    assert found.ready[1800:].mean() > 0.3
    assert found.ready_wrong() == 0.0


@pytest.mark.parametrize(
    ("name", "duty", "plant"),
    [
        ("camera +5 um from the start", "rising_hall_temperature", 389636),
        ("camera -5 um from the start", "heavy_payload", 163031),
        ("camera +5 um while it runs", "stop_and_go", 711500),
    ],
)
def test_a_camera_that_was_left_out_is_not_believed_because_the_growth_is_uncertain(
    name: str, duty: str, plant: int
) -> None:
    """`ready` was wrong in up to 45 % of these runs: doubt about the expansion let the camera in again."""
    assert trial("observer_drift", KINDS[name], duty, plant, 31).ready_wrong <= ALLOWED_READY


@pytest.mark.parametrize("name", ["base +5 K from the start", "both -10 K from the start"])
def test_before_the_first_picture_nothing_is_learnt_from_a_camera(name: str) -> None:
    """The correction went 2 um further than without a camera, as if one had borne it out."""
    found = {law: trial(law, KINDS[name], "rising_hall_temperature", 0, 31) for law in LAWS}
    assert found["observer_drift"].worse_by <= found["observer"].worse_by + 0.1e-6


@pytest.mark.parametrize(
    ("name", "duty", "plant", "seed"),
    [
        ("both drifts +20 K/h while it runs", "stop_and_go", 776956, 24085669),
        ("both drifts +20 K/h while it runs", "still_with_pad", 776956, 24085669),
        ("both delayed 60 min while it runs", "overnight_stop_and_warm_restart", 947278, 29365651),
        ("ambient +20 K from the start", "still_with_pad", 776956, 24085664),
    ],
)
def test_a_camera_bounds_what_duty_and_thermometers_leave_open(
    name: str, duty: str, plant: int, seed: int
) -> None:
    """The error was 35 to 65 um larger than without correction, while a sound camera showed it."""
    assert trial("observer_drift", KINDS[name], duty, plant, seed).worse_by <= ALLOWED


@pytest.mark.parametrize(
    ("name", "duty", "plant", "seed"),
    [
        ("ambient +10 K from the start", "moving_with_pad", 744255, 990925149),
        ("base +5 K from the start", "overnight_stop_and_warm_restart", 459385, 14240959),
        ("ambient +20 K from the start", "still_with_pad", 0, 28),
        ("ambient +20 K from the start", "still_with_pad", 776956, 24085664),
        ("both +10 K from the start", "stop_and_go", 814934, 848940003),
    ],
)
def test_until_warmth_is_known_no_signal_outvotes_another(
    name: str, duty: str, plant: int, seed: int
) -> None:
    """The surroundings contradicted the tip, it was left out, and the base alone told 5 to 39 um more.

    Or the growth could exceed what a duty told that was a third too large, by three fifths.
    """
    assert trial("observer", KINDS[name], duty, plant, seed).worse_by <= ALLOWED


def test_a_common_drift_is_flatter_than_heat_from_the_shaft() -> None:
    """A wrong model's share fell outwards far enough for the sum to pass as heat: 20 um worse."""
    found = trial("observer", KINDS["both drifts +20 K/h while it runs"], "pick_and_place_fast", 31, 994)
    assert found.worse_by <= ALLOWED


@pytest.mark.parametrize("duty", ["still_with_pad", "moving_with_pad"])
def test_a_link_that_conducts_less_than_it_should_leaves_a_pad_what_it_is(duty: str) -> None:
    """The heat reached the tip too late for what the model expects: 50 um of 60 remained for ten minutes."""
    found = rig("observer").run(truth_of(duty, 7018))
    assert np.abs(found.error).max() < 0.06 * np.abs(found.elongation).max()


def test_a_growth_that_the_expansion_makes_uncertain_is_not_ready() -> None:
    """A coefficient that is off by 3 % makes 7 um of 230, and no thermometer shows it."""
    assert trial("observer", SOUND, "heavy_payload", 947278, 1).ready_wrong == 0.0


@pytest.mark.parametrize(
    ("duty", "plant", "least"),
    [
        ("heavy_payload", 0, 0.99),
        ("rising_hall_temperature", 0, 0.99),
        ("still_with_pad", 0, 0.99),
        ("moving_with_pad", 31, 0.95),
        ("pick_and_place_fast", 31, 0.85),
        ("continuous", 32, 0.95),
        ("windshield_wiper", 32, 0.95),
    ],
)
def test_sound_thermometers_leave_it_ready_on_a_machine_as_modelled(
    duty: str, plant: int, least: float
) -> None:
    """A pad, a hall that warms up, models that are wrong: none of them is taken for an offset for long."""
    found = rig("observer").run(replace(truth_of(duty, plant), parameters=AS_MODELLED))
    assert (found.ready > 0).mean() > least
    assert found.ready_wrong(ALLOWED) <= ALLOWED_READY


@pytest.mark.parametrize(
    ("component", "wrong", "said"),
    [
        (REGRESSION, {"moments[15]": 0.0}, "moments: no positive definite matrix"),
        (REGRESSION, {"moments[1]": -1.0}, "moments: no positive definite matrix"),
        (OBSERVER, {"warm_spread[8]": -1.0}, "warm_spread: no covariance"),
        (DRIFT, {"warm_spread[2]": 1e3}, "warm_spread: no covariance"),
        (OBSERVER, {"convection[1]": 1.0}, "convection: errors of the modes grow"),
    ],
)
def test_a_parameter_set_that_is_none_is_refused(
    component: Component, wrong: dict[str, float], said: str
) -> None:
    """The regression's estimate once grew to NaN with such moments, and every status was OK."""
    instance = Instance(component)
    instance.set(wrong)
    with pytest.raises(InputError, match=said):
        instance.initialize()


@pytest.mark.parametrize("component", [OBSERVER, DRIFT, REGRESSION], ids=lambda c: c.name)
def test_a_wild_estimate_holds_the_correction_warns_and_recovers(component: Component) -> None:
    instance, draw = Instance(component), np.random.default_rng(8)
    instance.set({"sample_time": 10.0})
    instance.initialize()

    def step(k: int) -> None:
        instance.set({name: 297.0 + 0.1 * draw.normal() for name in SENSED})
        instance.step(10.0 * k, 10.0)

    for k in range(30):
        step(k)
    correction = instance.get("correction")
    kept = instance.snapshot()
    states = list(kept.states)
    growth = "estimate[5]" if component is REGRESSION else "estimate[1]"
    states[component.x.index[growth]] = 1e9
    instance.restore(Snapshot(**{**vars(kept), "states": states}))
    step(30)
    assert instance.get("correction") == pytest.approx(correction, abs=1e-9)
    assert (instance.get("warning"), instance.get("distrusted"), instance.get("ready")) == (1.0, 1.0, 0.0)
    for k in range(31, 60):
        step(k)
        assert abs(instance.get("correction")) < 3e-5
    assert math.isfinite(instance.get("predicted_elongation"))
    assert instance.get("warning") == 0.0
