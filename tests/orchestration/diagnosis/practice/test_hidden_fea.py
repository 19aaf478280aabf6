"""Runs that hide effects by 3-D finite elements: alike with the other solver's, and read by the diagnosis."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("skfem", reason="scikit-fem is not installed: pip install 'warmlink[fea]'")

from warmlink.fmus.errors import InputError
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.cli import main
from warmlink.orchestration.diagnosis.data.experiment import read_experiment
from warmlink.orchestration.diagnosis.fit.verdict import Assessment, assess
from warmlink.orchestration.diagnosis.practice import hidden, hidden_fea
from warmlink.orchestration.diagnosis.practice.effects import EFFECTS, effect_of
from warmlink.orchestration.diagnosis.practice.hidden import Course, Truth
from warmlink.orchestration.diagnosis.practice.hidden_fea import carried, hide_with_fea
from warmlink.orchestration.diagnosis.practice.hide import INFORMATIVE, write_csv
from warmlink.orchestration.scenarios.duties.duty import Segment, length

TEMPERATURES = ("shaft", "winding", "base", "middle", "tip")
DUTY = list(INFORMATIVE)
SHORT = [replace(segment, duration=segment.duration / 6) for segment in DUTY]


def far_apart(a: Course, b: Course) -> tuple[float, float]:
    """Largest difference in temperature, K, and in elongation, % of its largest."""
    kelvin = max(float(np.abs(getattr(a, name) - getattr(b, name)).max()) for name in TEMPERATURES)
    growth = np.abs(a.elongation - b.elongation).max() / np.abs(b.elongation).max()
    return kelvin, 100 * float(growth)


def rows(duty: list[Segment]) -> Array:
    return np.arange(0.0, length(duty) + 5.0, 10.0)


def truth_with(name: str, duty: list[Segment]) -> Truth:
    effect = EFFECTS[name]
    assert effect.on_truth is not None
    return effect.on_truth(Truth(), effect.size, length(duty))


def test_both_solvers_agree_as_link_and_finite_elements_do() -> None:
    """To the 0.01 K and 0.05 % of `agreement`, a tenth of the noise of a made-up run."""
    found = hidden_fea.simulate(Truth(), DUTY, rows(DUTY))
    kelvin, percent = far_apart(found, hidden.simulate(Truth(), DUTY, rows(DUTY)))
    assert kelvin < 0.01
    assert percent < 0.05


@pytest.fixture(scope="module")
def without() -> Course:
    """A run in which nothing is hidden."""
    return hidden.simulate(Truth(), SHORT, rows(SHORT))


@pytest.mark.parametrize("name", [n for n, e in EFFECTS.items() if e.on_truth and carried(n)])
def test_every_effect_that_is_carried_does_what_it_does_on_the_grid(name: str, without: Course) -> None:
    """On a coarse mesh with long steps: what is left is a small part of what the effect does."""
    truth = truth_with(name, SHORT)
    grid = hidden.simulate(truth, SHORT, rows(SHORT))
    found = hidden_fea.simulate(truth, SHORT, rows(SHORT), 1, 10.0)
    (kelvin, percent), done = far_apart(found, grid), far_apart(without, grid)
    assert percent < 0.05 * done[1]
    # Of expansion no temperature knows.
    assert name == "expansion_coefficient" or kelvin < 0.05 * done[0]


def test_the_coupling_of_link_and_motor_is_of_order_2() -> None:
    duty = [Segment(600, 3.43, 2.5), Segment(300, 0.0, 4.0)]
    times = np.arange(0.0, 901.0, 100.0)
    fine = hidden_fea.simulate(Truth(), duty, times, 1, 1.25)
    errors = [far_apart(hidden_fea.simulate(Truth(), duty, times, 1, step), fine)[0] for step in (20.0, 10.0)]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.3)


def assessed(folder: Path, effects: dict[str, float], seed: int) -> Assessment:
    path = folder / "run.csv"
    write_csv(hide_with_fea(effects, interval=30.0, seed=seed), path)
    return assess(read_experiment(path))


def test_nothing_hidden_is_adequate(tmp_path: Path) -> None:
    """The finite elements' width and thickness are not mistaken for an effect."""
    assert assessed(tmp_path, {}, seed=31).word == "adequate"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("names", "seed"),
    [
        (("conductivity",), 33),
        (("still_air_convection", "sensor_lag:tip_temperature"), 34),
    ],
)
def test_what_is_hidden_is_found(tmp_path: Path, names: tuple[str, ...], seed: int) -> None:
    found = assessed(tmp_path, {name: effect_of(name).size for name in names}, seed)
    assert found.word in ("named", "ambiguous")
    assert set(names) in [set(fit.key) for fit in (found.best, *found.rivals)]
    # Where nothing is 1 the start is the nominal value.
    sizes = [
        value / (freed.start or 1.0) for value, freed in zip(found.best.theta, found.best.freed, strict=True)
    ]
    assert sorted(sizes) == pytest.approx(sorted(effect_of(name).size for name in names), rel=0.15)


def test_an_effect_without_a_term_is_refused_with_what_is_possible() -> None:
    without = {name for name in EFFECTS if not carried(name)}
    assert without == {
        "mixed_convection",
        "free_convection",
        "conductivity_temperature_dependence",
        "hub_heat_capacity",
        "tip_heat_capacity",
        "tip_heat_loss",
        "radiant_heating",
        "bracket",
        "start_temperature",
    }
    for name in without:
        with pytest.raises(InputError, match=f"no term for '{name}'; they can hide radiation, ") as refusal:
            hide_with_fea({name: 1.0})
        assert "\n" not in str(refusal.value)
    with pytest.raises(InputError, match="'nonsense' is not known"):
        hide_with_fea({"nonsense": 1.0})


def warmlink(*arguments: str) -> int:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("sys.argv", ["warmlink", *arguments])
        with pytest.raises(SystemExit) as stop:
            main()
    return int(stop.value.code or 0)


def test_the_command_writes_the_same_columns_by_either_solver(tmp_path: Path) -> None:
    import pandas as pd

    tables = {}
    for solver in ("grid", "fea"):
        path = tmp_path / f"{solver}.csv"
        assert warmlink("hide", "joint_resistance", "--with", solver, "--seed", "4", "--out", str(path)) == 0
        tables[solver] = pd.read_csv(path)
    assert list(tables["fea"]) == list(tables["grid"])
    difference = (tables["fea"] - tables["grid"]).abs().max()
    # The same seed gives the same noise, so that the solvers' difference is left.
    assert difference.drop("elongation [um]").max() < 0.01
    assert 0 < difference["elongation [um]"] < 0.05


@pytest.mark.parametrize("arguments", [("tip_heat_loss", "--with", "fea"), ("radiation", "--with", "glue")])
def test_the_command_refuses_without_leaving_a_file(tmp_path: Path, arguments: tuple[str, ...]) -> None:
    assert warmlink("hide", *arguments, "--out", str(tmp_path / "run.csv")) == 2
    assert list(tmp_path.iterdir()) == []
