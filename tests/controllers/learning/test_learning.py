"""Laws learnt from logs: what is recovered, what physics adds, what is held out, and what is refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.strange_machine import Machine, Room, training
from warmlink.controllers.design.plant import cell_plant
from warmlink.controllers.design.structure import nearest_shares
from warmlink.controllers.design.training import training_run
from warmlink.controllers.interface import SENSED
from warmlink.controllers.learning.learnt import LearntMap, learn
from warmlink.controllers.learning.line import Learner, doubt
from warmlink.controllers.learning.logs import Log, examples_of
from warmlink.controllers.learning.worth import correlations, learning_curve, worth
from warmlink.fmus.errors import InputError

Array = NDArray[np.float64]

TRUE = np.array([0.0, 0.0, 2e-6, 3e-6, 2.5e-6])
"""m/K."""


def made_up(hours: float = 5.0, seed: int = 0, noise: float = 0.1, probe: float = 0.3e-6) -> Log:
    """A log, a row a second, of a link that warms and cools; the growth is measured once a minute."""
    draw, time = np.random.default_rng(seed), np.arange(0.0, 3600 * hours)
    warm = -np.expm1(-time / 1500) * (1 + 0.3 * np.sin(time / 2000))
    late = -np.expm1(-time / 3000) * (1 + 0.3 * np.sin(time / 2000 - 0.7))
    soon = -np.expm1(-time / 700) * (1 + 0.3 * np.sin(time / 2000 + 0.6))
    rise = np.column_stack([24 * soon, 38 * soon**2, 20 * warm, 12 * late, 8 * late * warm])
    growth = 4e-6 + rise @ TRUE
    measured = np.where(time % 60 == 0, growth + draw.normal(0, probe, time.size), np.nan)
    return Log("made up", time, 295.15 + rise + draw.normal(0, noise, rise.shape), measured, {"time": time})


def line_of(found: LearntMap, temperature: Array) -> Array:
    return found.line.at(temperature[:, list(found.used)])


def test_the_line_is_recovered_with_its_intercept() -> None:
    log = made_up()
    found = learn([log])
    assert found.used == (2, 3, 4)
    assert found.line.coefficients == pytest.approx(TRUE[2:], abs=0.15e-6)
    values = found.values
    at_room = values["intercept"] + np.dot(values["coefficients"], np.zeros(5))  # type: ignore[operator, arg-type]
    assert at_room == pytest.approx(4e-6, abs=0.7e-6)
    assert found.held.rms < 0.5e-6
    assert found.noise == pytest.approx(0.1, rel=0.1)


def test_several_logs_teach_together_and_a_thermometer_may_be_absent() -> None:
    one, two = made_up(1.0, 1), made_up(2.0, 2)
    bare = replace(two, temperature=np.where(np.arange(5) == 3, np.nan, two.temperature))
    assert learn([one, two]).used == (2, 3, 4)
    assert learn([one, bare]).used == (2, 4)
    assert len(learn([one, two]).examples.growth) == 180


def test_gaps_of_readings_are_bridged() -> None:
    log = made_up(2.0)
    temperature = log.temperature.copy()
    temperature[1000:1200] = np.nan
    assert np.isfinite(examples_of([replace(log, temperature=temperature)]).temperature).all()


def test_growth_in_every_row_teaches_what_growth_once_a_minute_does() -> None:
    log, exact = made_up(3.0), made_up(3.0, probe=0.0, noise=0.0)
    growth = 4e-6 + (exact.temperature - 295.15) @ TRUE
    draw = np.random.default_rng(5)
    dense = replace(log, growth=growth + draw.normal(0, 0.3e-6, growth.size))
    assert learn([dense]).line.coefficients == pytest.approx(TRUE[2:], abs=0.15e-6)


def test_no_coefficient_is_below_nothing() -> None:
    """A thermometer that goes against the growth is left out: no warmth makes a link shorter."""
    log = made_up()
    temperature = log.temperature.copy()
    temperature[:, 0] = 600.0 - temperature[:, 2]
    found = learn([replace(log, temperature=temperature)], SENSED)
    assert (found.line.coefficients >= 0).all()
    assert found.values["sensor_std"][0] == 0.0  # type: ignore[index]


def test_what_a_log_does_not_tell_apart_physics_does() -> None:
    """All three rise as one: the shares are those of the link's length that each is the nearest to."""
    log = made_up(1.0)
    rise = np.linspace(0, 20, log.time.size)
    draw = np.random.default_rng(1)
    temperature = 295.15 + rise[:, None] + draw.normal(0, 0.1, log.temperature.shape)
    found = learn([replace(log, temperature=temperature, growth=8e-6 * rise)], SENSED[2:])
    assert found.line.coefficients == pytest.approx(8e-6 * np.array([0.25, 0.5, 0.25]), rel=0.15)
    assert nearest_shares([2, 4]) == pytest.approx([0.5, 0.5], abs=1e-3)
    assert nearest_shares([0, 3]) == pytest.approx([0.0, 1.0])


def test_a_model_says_more_than_shares() -> None:
    plant = cell_plant(link={"expansion_coefficient": 30e-6})
    model = training_run(plant)
    prior = Learner([2, 3, 4], model).prior
    assert prior.sum() == pytest.approx(30e-6 * 0.2916, rel=0.15)
    short = made_up(0.4)
    assert learn([short], None, model).used == (2, 3, 4)


def test_the_error_near_and_far_is_that_of_predictions() -> None:
    """Far from what was learnt it is larger, and no less than the blocks allow to know."""
    found = learn([made_up()])
    assert found.near == pytest.approx(found.held.rms, rel=0.5)
    assert doubt(found.held) == (found.near, found.far)
    assert found.far >= found.near**2 / found.held.blocks * (1 - 1e-9)
    centre, away = found.line.mean, found.line.mean + np.array([10.0, -10.0, 0.0])
    assert found.line.lever(away[None])[0] > 100 * found.line.lever(centre[None])[0] + 10


def test_each_set_of_thermometers_has_its_error() -> None:
    found = learn([made_up()])
    every = worth(found.examples, range(5))
    assert len(every) == 2**5 - 1
    assert every[2, 3, 4] < 1.3 * min(every.values())
    assert every[(4,)] > 3 * every[2, 3, 4]


def test_of_many_thermometers_sets_grow_by_the_best(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("warmlink.controllers.learning.worth.ALL_SUBSETS", 3)
    found = learn([made_up(2.0)])
    every = worth(found.examples, range(5))
    assert len(every) == 5 + 4 + 3 + 2 + 1


def test_a_longer_log_is_worth_more_until_it_is_not() -> None:
    curve = learning_curve(learn([made_up(6.0)]))
    assert list(curve) == [20, 30, 45, 60, 90, 120, 180]
    assert curve[180.0] < curve[20.0]
    assert curve[180.0] < 1e-6


def test_what_the_rest_goes_with_is_said() -> None:
    log = made_up()
    swing = np.sin(log.time / 700)
    log = replace(log, growth=log.growth + 2e-6 * swing, others={"swing": swing, "other": np.cos(log.time)})
    found = correlations(learn([log]), [log])
    assert next(iter(found)) == "swing"
    assert found["swing"] > 0.8
    assert abs(found["other"]) < 0.3


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"growth": np.full(18000, np.nan)}, "the growth was not measured; add a column 'elongation"),
        ({"temperature": np.full((18000, 5), np.nan)}, "no temperature was measured; add a column 'base_"),
        ({"growth": np.where(np.arange(18000) < 300, 1e-6, np.nan)}, "10 readings of the growth"),
    ],
)
def test_a_log_that_cannot_teach_is_refused(change: dict[str, Array], said: str) -> None:
    with pytest.raises(InputError, match=said):
        learn([replace(made_up(), **change)])


def test_a_thermometer_that_was_not_measured_is_refused() -> None:
    log = made_up()
    bare = replace(log, temperature=np.where(np.arange(5) == 3, np.nan, log.temperature))
    with pytest.raises(InputError, match="middle_temperature was not measured; add its column, or leave it"):
        learn([bare], ["base_temperature", "middle_temperature"])


def test_a_noise_that_is_none_is_refused() -> None:
    with pytest.raises(InputError, match="give a value above 0 K"):
        learn([made_up()], sensor_std=0.0)


def test_a_machine_of_other_structure_is_learnt() -> None:
    """Bending, play, gearbox, brake: what a log of 5 h leaves is less than a micrometre."""
    log = Machine(4).run(training(), 4, Room()).log()
    temperature = np.column_stack([log[f"{name} [degC]"] + 273.15 for name in SENSED])
    growth = 1e-6 * log["elongation [um]"].to_numpy()
    found = learn([Log("strange", log["time [s]"].to_numpy(), temperature, growth)])
    error = 1e-6 * log["growth [um]"].to_numpy() - line_of(found, temperature)
    slow = np.convolve(error, np.ones(60) / 60, "valid")
    assert np.sqrt(np.mean(slow**2)) < 0.6e-6


def test_a_thermometer_that_died_is_not_learnt_from() -> None:
    """Its last reading stood for all later ones, and took half of the weight of a thermometer that worked."""
    log = made_up()
    dead = replace(log, temperature=log.temperature.copy())
    dead.temperature[600:, SENSED.index("tip_temperature")] = np.nan
    assert SENSED.index("tip_temperature") not in learn([dead]).used
    with pytest.raises(InputError, match=r"tip_temperature was read at 4 % of the growth's readings"):
        learn([dead], ["base_temperature", "tip_temperature"])


def test_what_a_thermometer_missed_for_a_while_costs_no_more_than_that() -> None:
    log = made_up()
    absent = replace(log, temperature=log.temperature.copy())
    absent.temperature[3000:4200, SENSED.index("tip_temperature")] = np.nan
    found = learn([absent])
    assert found.used == (2, 3, 4)
    assert found.examples.growth.size == 284, "of 20 min the first and last two are bridged"
    assert found.line.coefficients == pytest.approx(TRUE[2:], abs=0.2e-6)


def test_a_slow_log_knows_its_temperatures_between_the_rows() -> None:
    log = made_up(hours=20.0)
    slow = replace(log, temperature=np.full_like(log.temperature, np.nan))
    slow.temperature[::600] = log.temperature[::600]
    assert learn([slow]).examples.growth.size == 20 * 60


def test_a_growth_that_never_changes_teaches_nothing() -> None:
    log = made_up(1.0)
    stuck = replace(log, growth=np.full(log.time.size, 3e-6))
    with pytest.raises(InputError, match="made up: the growth is 3 um in every row, as by an instrument"):
        learn([stuck])


def test_a_thermometer_named_twice_is_one() -> None:
    assert learn([made_up(2.0)], ["base_temperature", "base_temperature"]).used == (2,)
