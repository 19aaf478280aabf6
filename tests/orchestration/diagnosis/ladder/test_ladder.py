"""Plain fits find what they are made for, held-out rows judge them, and the best model is delivered."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from warmlink.orchestration.diagnosis.fit.wandering import STILL
from warmlink.orchestration.diagnosis.ladder.baselines import Baseline, baselines
from warmlink.orchestration.diagnosis.ladder.delivered import Delivery
from warmlink.orchestration.diagnosis.ladder.judged import JudgedModels, chosen
from warmlink.orchestration.diagnosis.ladder.rungs import Ladder, Rung
from warmlink.orchestration.diagnosis.ladder.signals import Signals


def made(seed: int = 0, uneven: bool = False, later: float = 0.7) -> Signals:
    """A lump that 40 W heat now and then, a second one behind it, and a growth that follows both."""
    chance = np.random.default_rng(seed)
    time = np.cumsum(chance.uniform(5, 55, 400)) if uneven else 30.0 * np.arange(1, 401)
    power = 40.0 * (chance.uniform(size=400) < 0.5)
    power = np.repeat(power[::25], 25)[:400]
    states, rows = np.array([3.0, 1.0]), []
    before = 0.0
    for now, heat in zip(time, power, strict=True):
        for _ in range(10):
            first, second = states
            rate = np.array([heat / 400 - first / 500 - (first - second) / 900, (first - second) / 1500])
            states = states + (now - before) / 10 * rate
        before = now
        rows.append([*(295.15 + states), 2e-6 * states[0] + 5e-6 * states[1]])
    readings = np.array(rows) + chance.normal(size=(400, 3)) * [0.02, 0.02, 2e-8]
    room = np.full(400, 295.15)
    return Signals(
        time,
        readings,
        np.array([298.15, 296.15, 1.1e-5]),
        power[:, None],
        np.zeros(1, dtype=bool),
        np.zeros((400, 0)),
        time < later * time[-1],
        room,
        ("motor.current",),
        (),
        ("shaft", "tip", "growth"),
        "motor.ambient_temperature",
    )


def found(run: Signals, name: str, temperatures: tuple[bool, ...] = (True, True, False)) -> Baseline:
    return next(each for each in baselines([run], temperatures) if each.name == name)


def rms(run: Signals, of: Baseline) -> list[float]:
    error = (run.readings - of.readings[0])[~run.fitted]
    return np.sqrt(np.mean(error**2, axis=0)).tolist()


@pytest.mark.parametrize("uneven", [False, True])
def test_arx_goes_by_its_own_readings_and_finds_two_lumps(uneven: bool) -> None:
    run = made(uneven=uneven)
    first, second, growth = rms(run, found(run, "ARX"))
    assert first < 0.5
    assert second < 0.2
    assert growth < 1.5e-6


def test_a_lag_finds_one_lump_and_says_less_of_two() -> None:
    run = made()
    alone = np.zeros((400, 1))
    for i, (now, before) in enumerate(zip(run.time, np.append(0.0, run.time), strict=False)):
        last = alone[i - 1] if i else 3.0
        keep = np.exp(-(now - before) / 1200)
        alone[i] = keep * last + (1 - keep) * 0.1 * run.inputs[i]
    one = replace(run, readings=295.15 + alone, start=np.array([298.15]))
    assert rms(one, found(one, "first-order lag", (True,)))[0] < 0.15
    assert rms(run, found(run, "first-order lag"))[0] > 0.2


def test_a_ridge_on_thermometers_tells_the_growth() -> None:
    run = made()
    ridge = found(run, "ridge")
    assert ridge.question == "virtual measurement"
    assert rms(run, ridge)[2] < 0.3e-6


@pytest.mark.parametrize(("per_kelvin", "goes_by_it"), [(5e-8, False), (1e-6, True)])
def test_a_ridge_goes_by_a_temperature_among_inputs_only_where_that_is_clearly_better(
    per_kelvin: float, goes_by_it: bool
) -> None:
    run = made()
    hall = 1.0 * np.sin(run.time / 900)
    readings = run.readings + np.outer(per_kelvin * hall, [0, 0, 1])
    readings[:, 2] += 2e-8 * np.random.default_rng(1).normal(size=400)
    told = replace(
        run,
        readings=readings,
        inputs=np.column_stack([run.inputs[:, 0], 295.15 + hall]),
        relative=np.array([False, True]),
        names=("motor.current", "link.hall_temperature"),
    )
    fit = found(told, "ridge").linear[2]
    assert (("link.hall_temperature",) in fit.direct) is goes_by_it


def test_a_ridge_on_thermometers_does_not_go_by_what_makes_heat() -> None:
    """Growth that jumps with the power in the log, as by load: in another duty cycle load and power part."""
    run = made()
    readings = run.readings + np.outer(1e-8 * run.inputs[:, 0], [0, 0, 1])
    fit = found(replace(run, readings=readings), "ridge").linear[2]
    assert set(fit.direct) == {("shaft",), ("tip",)}


def test_held_out_rows_change_no_plain_fit() -> None:
    run = made()
    spoiled = run.readings.copy()
    spoiled[~run.fitted] += 50.0
    for one, other in zip(
        baselines([run], (True, True, False)),
        baselines([replace(run, readings=spoiled)], (True, True, False)),
        strict=True,
    ):
        # A virtual measurement reads the other thermometers, which are spoiled here.
        kept = np.ones(400, dtype=bool) if one.question == "simulation" else run.fitted
        assert one.readings[0][kept] == pytest.approx(other.readings[0][kept])


def test_a_channel_that_was_hardly_read_has_no_plain_fit() -> None:
    run = made()
    few = run.readings.copy()
    few[5:, 1] = np.nan
    arx = found(replace(run, readings=few), "ARX")
    assert np.isnan(arx.readings[0][:, 1]).all()
    assert np.isfinite(arx.readings[0][:, 0]).all()


def ladder(run: Signals, **errors: float) -> Ladder:
    """Rungs whose errors are noise of given sizes, in K for the temperatures."""
    rungs = []
    for k, (name, size) in enumerate(errors.items()):
        noise = np.random.default_rng(k).normal(size=run.readings.shape) * size * [1, 1, 1e-6]
        rungs.append(Rung(name, "simulation", (run.readings + noise,), k, is_model=True))
    return Ladder((run,), ("shaft", "tip", "growth"), tuple(rungs))


def test_the_best_on_held_out_rows_is_chosen_and_of_equals_the_simplest() -> None:
    run = made()
    clear = ladder(run, uncorrected=2.0, causes=1.0, calibrated=0.5)
    assert clear.simplest_of_the_best(clear.rungs).name == "calibrated"
    alike = ladder(run, uncorrected=2.0, causes=0.502, calibrated=0.5)
    assert alike.simplest_of_the_best(alike.rungs).name == "causes"
    worse = ladder(run, uncorrected=1.0, causes=1.4, calibrated=1.2)
    assert worse.simplest_of_the_best(worse.rungs).name == "uncorrected"


def test_errors_are_told_in_the_channels_own_units() -> None:
    run = made()
    clear = ladder(run, uncorrected=2.0)
    assert clear.rms(clear.rungs[0]) == pytest.approx({"shaft": 2.0, "tip": 2.0, "growth": 2e-6}, rel=0.15)
    assert clear.score(clear.rungs[0]) == pytest.approx(1.0)


def test_a_model_that_is_right_in_one_channel_by_luck_is_not_the_measure() -> None:
    run = made()
    noise = np.random.default_rng(0).normal(size=run.readings.shape)
    lucky = Rung("uncorrected", "simulation", (run.readings + noise * [9.0, 0.02, 9e-6],), is_model=True)
    better = Rung("calibrated", "simulation", (run.readings + noise * [0.5, 0.04, 0.5e-6],), 5, is_model=True)
    both = Ladder((run,), ("shaft", "tip", "growth"), (lucky, better))
    assert both.simplest_of_the_best(both.rungs).name == "calibrated"


def test_nothing_held_out_judges_nothing() -> None:
    run = replace(made(), fitted=np.ones(400, dtype=bool))
    assert not ladder(run, uncorrected=1.0).is_judged


def test_a_run_that_nothing_drives_has_plain_fits_too() -> None:
    run = replace(made(), inputs=np.zeros((400, 0)), relative=np.zeros(0, dtype=bool), names=())
    assert {each.name for each in baselines([run], (True, True, False))} == {
        "first-order lag",
        "ARX",
        "ridge",
    }


def test_no_model_that_foretells_the_growth_worse_is_chosen() -> None:
    run = made()
    noise = np.random.default_rng(0).normal(size=run.readings.shape)
    first = Rung("uncorrected", "simulation", (run.readings + noise * [9.0, 9.0, 1e-6],), is_model=True)
    other = Rung("calibrated", "simulation", (run.readings + noise * [0.5, 0.5, 2e-6],), 5, is_model=True)
    both = Ladder((run,), ("shaft", "tip", "growth"), (first, other), growth=2)
    assert chosen(both, "unknown", declared=False) == "uncorrected"
    assert chosen(replace(both, growth=None), "unknown", declared=False) == "calibrated"
    assert chosen(replace(both, accuracy={2: 5e-6}), "unknown", declared=False) == "calibrated"


def test_nearest_causes_are_delivered_only_by_whole_held_out_runs() -> None:
    run = made()
    noise = np.random.default_rng(0).normal(size=run.readings.shape)
    names = {"uncorrected": 9.0, "nearest causes": 0.5}
    rungs = tuple(
        Rung(name, "simulation", (run.readings + noise * size * [1, 1, 1e-6],) * 2, is_model=True)
        for name, size in names.items()
    )
    end = Ladder((run, run), ("shaft", "tip", "growth"), rungs)
    assert chosen(end, "unknown", declared=False) == "uncorrected"
    whole = replace(run, fitted=np.ones(400, dtype=bool)), replace(run, fitted=np.zeros(400, dtype=bool))
    assert chosen(replace(end, runs=whole), "unknown", declared=False) == "nearest causes"


def with_equation(left: float, told_apart: bool = True) -> Delivery:
    """A delivery of an uncorrected model that is off by 1, and of an equation that leaves a share of that."""
    run = made()
    off = np.ones_like(run.readings) * np.linspace(0.5, 1.5, len(run.readings))[:, None]
    first = Rung("uncorrected", "simulation", (run.readings + off,), is_model=True)
    nothing: Any = None
    others = JudgedModels(nothing, STILL, {}, "unknown", declared=False)
    others.__dict__.update(_plainest=Ladder((run,), ("a", "b", "c"), (first,)), _is_off=False, _learnt=None)
    freed = SimpleNamespace(freed=("term1.a", "term1.b"))
    equation: Any = SimpleNamespace(readings=(run.readings + left * off,), fit=freed)
    return Delivery(others, (equation,), told_apart)


def test_an_equation_is_a_rung_and_delivered_where_it_predicts_best() -> None:
    delivery = with_equation(0.1)
    assert [(each.name, each.numbers) for each in delivery.ladder.rungs] == [
        ("uncorrected", 0),
        ("with equation", 2),
    ]
    assert delivery.name == delivery.model == "with equation"
    assert delivery.adopted is delivery.equations[0]
    assert delivery.remainder is None


def test_an_equation_that_predicts_worse_is_a_rung_alone() -> None:
    delivery = with_equation(1.5)
    assert delivery.ladder.named("with equation").is_model
    assert delivery.name == delivery.model == "uncorrected"


def test_of_two_that_predict_alike_causes_come_first_if_they_explain_the_run_too() -> None:
    assert with_equation(1.0).name == "with equation"
    assert with_equation(1.0, told_apart=False).name == "uncorrected"
    assert with_equation(0.1, told_apart=False).name == "with equation"
