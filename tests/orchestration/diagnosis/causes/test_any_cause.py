"""Every cause of the catalogue, in duty cycles and at strengths that nobody chose.

The seed is drawn anew for each session and printed; `WARMLINK_DIAGNOSIS_SEED` repeats one. What is asserted
holds for every draw, however weak the effect is. `python -m benchmarks.diagnosis` counts how often each cause
is named (its line "any cause, any duty").
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from benchmarks.hidden_effects import KNOWN, drawn_duty, over_a_decade, with_gaps
from warmlink.orchestration.diagnosis.causes.catalogue import catalogue
from warmlink.orchestration.diagnosis.data.experiment import Experiment, read_experiment
from warmlink.orchestration.diagnosis.fit.candidates import FreeNumber
from warmlink.orchestration.diagnosis.fit.problem import Problem
from warmlink.orchestration.diagnosis.fit.search import Search
from warmlink.orchestration.diagnosis.fit.verdict import Assessment, assess
from warmlink.orchestration.diagnosis.practice.effects import EFFECTS, effect_of
from warmlink.orchestration.diagnosis.practice.hide import Noise, hide, write_csv
from warmlink.orchestration.scenarios.duties.duty import Segment

SEED = int(os.environ.get("WARMLINK_DIAGNOSIS_SEED") or np.random.SeedSequence().generate_state(1)[0])
QUIET = Noise(temperature=1e-9, elongation=1e-15)
SAMPLED = 1
"""Causes that are hidden and looked for in each session: another one each time."""


@pytest.fixture(autouse=True)
def _told() -> None:
    print(f"WARMLINK_DIAGNOSIS_SEED={SEED}")


def experiment(folder: Path, columns: dict[str, np.ndarray]) -> Experiment:
    write_csv(columns, folder / "run.csv")
    return read_experiment(folder / "run.csv")


def readings(columns: dict[str, np.ndarray]) -> np.ndarray:
    """Measured columns in K, 10 um of elongation counting as 1 K, shape (rows, columns)."""
    return np.column_stack([v * (0.1 if "um" in h else 1.0) for h, v in list(columns.items())[5:]])


@dataclass(frozen=True)
class Unchanged:
    """A run with nothing hidden, and the model of it."""

    duty: tuple[Segment, ...]
    columns: dict[str, np.ndarray]
    problem: Problem

    def freed(self, effect: dict[str, float]) -> tuple[FreeNumber, float]:
        """What a cause frees, and the value at which it is the effect."""
        ((name, size),) = effect.items()
        ((freed,),) = (each.freed for each in self.problem.items if each.title == name)
        value = size * freed.start if effect_of(name).neutral == 1 else size
        assert freed.lower < value < freed.upper
        return freed, value

    def slope_error(self, effect: dict[str, float]) -> float:
        """Error of the derivative by which a search finds the effect, as a share of it."""
        freed, value = self.freed(effect)
        step = 1e-3 * (value - freed.start)
        z = [self.problem.values(0, [freed], [value + shift]) for shift in (-step, 0.0, step)]
        before, here, after = (self.problem.predict(0, each) for each in z)
        slope = here[1][:, :, list(freed.slots)].sum(axis=2)
        differences = (after[0] - before[0]) / (2 * step)
        scale = np.array([1e5 if "elongation" in v else 1.0 for v in self.problem.variables])
        wrong, whole = (float(np.linalg.norm(each * scale)) for each in (slope - differences, differences))
        return wrong / whole if whole else 0.0  # some duties wake nothing

    def modelled(self, effect: dict[str, float]) -> np.ndarray:
        """What the model predicts that an effect changes in the readings."""
        problem = self.problem
        freed, value = self.freed(effect)
        changed = problem.finest(0, problem.values(0, [freed], [value]))
        order = [problem.names[v] for v in problem.variables]
        change = changed - problem.finest(0, problem.neutral[0])
        return np.column_stack(
            [
                change[:, order.index(h.split()[0])] * (1e5 if "um" in h else 1.0)
                for h in list(self.columns)[5:]
            ]
        )


@pytest.fixture(scope="module")
def unchanged(tmp_path_factory: pytest.TempPathFactory) -> Unchanged:
    duty = drawn_duty(np.random.default_rng(SEED), 1800.0)
    columns = hide({}, duty, QUIET, interval=20.0, at_changes=True)
    return Unchanged(duty, columns, Problem(experiment(tmp_path_factory.mktemp("unchanged"), columns)))


def test_a_duty_of_uneven_stages_is_logged_as_it_was_driven(unchanged: Unchanged) -> None:
    """Each row that begins a stage has the demands of that stage, not of the one before."""
    begins = np.round(np.cumsum([0.0, *(stage.duration for stage in unchanged.duty[:-1])]), 6)
    rows = np.searchsorted(unchanged.columns["time [s]"], begins)
    ambient = unchanged.columns["ambient_temperature [degC]"][rows] + 273.15
    np.testing.assert_allclose(ambient, [stage.ambient_temperature for stage in unchanged.duty], rtol=1e-9)


def test_no_row_is_logged_after_the_end(unchanged: Unchanged) -> None:
    end = sum(stage.duration for stage in unchanged.duty)
    assert end - 20.0 < unchanged.columns["time [s]"][-1] <= end
    for whole in (40.0, 60.0):
        stages = (Segment(duration=whole, speed=1.0, torque=1.0),)
        assert whole - 20.0 < hide({}, stages, QUIET, interval=20.0)["time [s]"][-1] <= whole


@pytest.mark.parametrize("name", KNOWN)
def test_a_cause_does_in_the_model_what_it_does_in_truth(name: str, unchanged: Unchanged) -> None:
    """Its change of the readings, by another solver, to a fifteenth or a millikelvin."""
    effect = over_a_decade(name, np.random.default_rng([SEED, KNOWN.index(name)]))
    hidden = hide(effect, unchanged.duty, QUIET, interval=20.0, at_changes=True)
    true = readings(hidden) - readings(unchanged.columns)
    # A logger that is ahead reads at its end what comes after the run.
    time = unchanged.columns["time [s]"]
    within = time <= time[-1] + min(effect.get("clock_offset", 0.0), 0.0)
    left = np.sqrt(np.mean((unchanged.modelled(effect) - true)[within] ** 2))
    assert left < 1e-3 + np.sqrt(np.mean(true**2)) / 15, effect
    assert unchanged.slope_error(effect) < 0.1, effect


@pytest.mark.parametrize("name", KNOWN)
def test_a_cause_may_be_half_as_strong_again_as_usual_either_way(name: str, unchanged: Unchanged) -> None:
    effect, channel = EFFECTS[name], ":tip_temperature" if EFFECTS[name].per_channel else ""
    for sign in (1, -1) if effect.both_signs else (1,):
        unchanged.freed({name + channel: effect.neutral + 1.5 * sign * (effect.size - effect.neutral)})


def explained(found: Assessment, effect: dict[str, float]) -> None:
    """The truth explains the run, and the search came as far as the truth, but not much further."""
    search: Search = found.search
    (item,) = (each for each in search.items if each.title in effect)
    truth = search.fits.get(frozenset(effect)) or search.fitter.fit((item,))
    count = search.fitter.count
    assert truth.chi2 < count + 6 * np.sqrt(2 * count)
    if truth.admissible:
        assert -25 < search.score(found.best) - search.score(truth) < 1


@pytest.mark.slow
@pytest.mark.parametrize("number", range(SAMPLED))
def test_a_cause_that_nobody_chose_is_found(number: int, tmp_path: Path) -> None:
    """In a run with pads, ambient row by row, uneven rows, two columns and many cells missing."""
    random = np.random.default_rng([SEED, 100 + number])
    effect = over_a_decade(str(random.choice(KNOWN)), random)
    columns = hide(effect, drawn_duty(random, 5400.0), seed=int(random.integers(2**31)))
    found = assess(experiment(tmp_path, with_gaps(columns, effect, random)))
    print(effect, found.word, found.best.name)
    explained(found, effect)


def test_every_cause_can_be_hidden() -> None:
    assert len(KNOWN) >= 24
    assert {cause.name for cause in catalogue()} >= set(KNOWN)


@pytest.fixture(scope="module")
def nothing(tmp_path_factory: pytest.TempPathFactory) -> Assessment:
    """Rows stand at the changes of the duty: in others what leaps between two rows does is noise besides."""
    random = np.random.default_rng([SEED, 200])
    columns = hide({}, drawn_duty(random, 3600.0), seed=SEED, at_changes=True)
    return assess(experiment(tmp_path_factory.mktemp("nothing"), columns))


def test_chance_reaches_the_level_of_a_cause_in_seven_of_a_thousand_runs(nothing: Assessment) -> None:
    """Drawn from the whitened sensitivities to every candidate, as white noise would push each of them."""
    search = nothing.search
    gram = sum(search.null.point.gram)
    single = [item for item in search.items if len(item.freed) == 1]
    selected = np.array([np.isin(np.arange(len(gram)), item.freed[0].slots) for item in single]) * 1.0
    # What the drawn duty cycle does not wake, chance cannot push.
    woken = np.einsum("ij,jk,ik->i", selected, gram, selected) > 0
    single, selected = [item for item, felt in zip(single, woken, strict=True) if felt], selected[woken]
    dear = [search.penalty((item,)) for item in single]
    sided = [item.freed[0].lower == item.freed[0].start for item in single]
    covariance = selected @ gram @ selected.T
    size = np.sqrt(np.diag(covariance))
    values, vectors = np.linalg.eigh(covariance / np.outer(size, size))
    random = np.random.default_rng([SEED, 201])
    z = (vectors * np.sqrt(np.maximum(values, 0))) @ random.standard_normal((len(size), 20_000))
    gain = np.where(np.array(sided)[:, None] & (z < 0), 0.0, z**2)
    share = float(np.mean((gain > np.array(dear)[:, None]).any(axis=0)))
    assert 0.003 < share < 0.012
    first = search.items[0]
    further = [search.penalty((item, first)) - search.penalty((first,)) for item in single]
    share = float(np.mean((gain > np.array(further)[:, None]).any(axis=0)))
    assert 0.0005 < share < 0.006


def test_an_interval_is_as_wide_as_the_noise_makes_it(nothing: Assessment) -> None:
    """From the derivatives of the readings and the noise that was put in, 0.08 K and 0.4 um."""
    problem, search = nothing.problem, nothing.search
    _, by_slot = problem.predict(0, problem.neutral[0])
    sigma = np.array([0.4e-6 if "elongation" in v else 0.08 for v in problem.variables])
    rows = problem.data[0].fitted
    for name in ("joint_resistance", "heat_capacity", "camera_drift"):
        (item,) = (each for each in search.items if each.title == name)
        slope = by_slot[rows][:, :, list(item.freed[0].slots)].sum(axis=2) / sigma
        expected = 1 / np.sqrt(np.sum(slope**2) * problem.averaging.rows)
        deviation = float(np.sqrt(search.fitter.fit((item,)).covariance()[0, 0]))
        assert 0.8 < deviation / expected < 1.6, name
