"""The observer whose linear model was found from runs: its filter, its start, its refusals."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import linalg

from warmlink.controllers.design.identified import LinearModel, identified
from warmlink.controllers.design.linear_gains import LinearDesign, Worth
from warmlink.controllers.design.training import DrivenRun, Stage, excitation, training_run
from warmlink.controllers.interface import SENSED
from warmlink.controllers.linear_observer.component import COMPONENT
from warmlink.controllers.linear_observer.model import FEATURES, MODES, features
from warmlink.controllers.matrices import symmetric
from warmlink.controllers.start_values import shipped_design
from warmlink.fmus.component.instance import Instance
from warmlink.fmus.errors import InputError

Array = NDArray[np.float64]

ROOM, BASE, TIP = 295.15, SENSED.index("base_temperature"), SENSED.index("tip_temperature")
DUTY = {"speed": 3.0, "torque": 2.0, "ambient_temperature": ROOM}
AWAY = {name: math.nan for name in SENSED if not name.startswith(("base", "tip"))}


def begun(step: float = 1.0, **readings: float) -> Instance:
    law = Instance(COMPONENT)
    law.set(
        {"sample_time": step, **DUTY, **AWAY, "base_temperature": ROOM, "tip_temperature": ROOM, **readings}
    )
    law.initialize()
    return law


def state(law: Instance, name: str) -> Array:
    return np.asarray(getattr(COMPONENT.x.read(np.array(law.snapshot().states)), name), dtype=float)


def matrices() -> dict[str, Array]:
    found = shipped_design("linear_observer")
    flat = {name: np.array(found[name]) for name in ("dynamics", "gains", "sensor_rows", "noise")}
    return {
        "A": flat["dynamics"].reshape(MODES, MODES),
        "B": flat["gains"].reshape(MODES, FEATURES),
        "C": flat["sensor_rows"].reshape(len(SENSED), MODES),
        "W": symmetric(flat["noise"], MODES),
    }


@pytest.mark.parametrize("step", [1.0, 60.0])
def test_it_is_the_filter_of_filterpy(step: float) -> None:
    """R. R. Labbe's FilterPy on the same linear model: means and covariances to 1e-9, over two hours."""
    kalman = pytest.importorskip("filterpy.kalman", reason="filterpy is not installed: pip install filterpy")
    law, rows = begun(step), [BASE, TIP]
    m = matrices()
    reference = np.array(shipped_design("linear_observer")["sensor_reference"])
    A, C = m["A"], m["C"][rows]
    other = kalman.KalmanFilter(dim_x=MODES, dim_z=2, dim_u=MODES)
    other.F = linalg.expm(A * step)
    other.B = np.linalg.solve(A, other.F - np.eye(MODES))
    other.H, other.R, other.Q = C, 0.01 * np.eye(2), step * m["W"]
    other.x, other.P = state(law, "estimate")[:, None], symmetric(state(law, "spread"), MODES)
    random = np.random.default_rng(1)
    for k in range(120):
        shown = (m["C"] @ other.x)[:, 0] + reference - ROOM
        above = [float(shown[i]) if i in rows else 0.0 for i in range(len(SENSED))]
        driven = m["B"] @ np.array(features(3.0, 2.0, 0.0, above))
        other.predict(u=driven[:, None])
        readings = reference[rows] + C @ other.x[:, 0] + 0.1 * random.standard_normal(2)
        other.update(readings - reference[rows])
        law.set(dict(zip(("base_temperature", "tip_temperature"), readings.tolist(), strict=True)))
        law.step(k * step, step)
    size = np.abs(other.x).max()
    assert size > 1.0, "the machine warms up"
    np.testing.assert_allclose(state(law, "estimate"), other.x[:, 0], rtol=0, atol=1e-9 * size)
    spread = symmetric(state(law, "spread"), MODES)
    np.testing.assert_allclose(spread, other.P, rtol=0, atol=1e-9 * np.abs(other.P).max())


@pytest.mark.parametrize("step", [0.1, 1.0, 60.0, 600.0])
def test_a_sample_is_exact_however_long(step: float) -> None:
    p = COMPONENT.start_values()[0].copy()
    p[COMPONENT.p.index["sample_time"]] = step
    derived = COMPONENT.d.read(np.asarray(COMPONENT.settled(p), dtype=float))
    A = matrices()["A"]
    transition = linalg.expm(A * step)
    np.testing.assert_allclose(derived.carried.reshape(MODES, MODES), transition, atol=1e-11)
    reach = np.linalg.solve(A, transition - np.eye(MODES))
    np.testing.assert_allclose(derived.reach.reshape(MODES, MODES), reach, atol=1e-9 * step)


def test_without_thermometers_it_goes_on_by_the_duty_and_is_less_sure() -> None:
    blind, seeing = (begun() for _ in range(2))
    blind.set({"base_temperature": math.nan, "tip_temperature": math.nan})
    for k in range(400):
        warm = ROOM + 0.004 * k + 0.01 * (k % 3)
        seeing.set({"base_temperature": warm, "tip_temperature": warm})
        for law in (blind, seeing):
            law.step(float(k), 1.0)
    assert blind.get("correction") > 1e-6
    assert blind.get("correction_std") > seeing.get("correction_std")
    assert blind.get("distrusted")
    assert not blind.get("ready")


def test_a_machine_that_was_left_warm_is_taken_as_warm_as_it_reads() -> None:
    """And a cold one as cold: the noise of its first readings moves nothing."""
    run = training_run()
    warm = int(run.elongation.argmax())
    law = begun(base_temperature=run.temperature[warm, BASE], tip_temperature=run.temperature[warm, TIP])
    assert law.get("predicted_elongation") == pytest.approx(run.elongation[warm], rel=0.1)
    cold = begun(base_temperature=ROOM + 0.2, tip_temperature=ROOM - 0.2)
    assert abs(cold.get("predicted_elongation")) < 1e-6


def test_a_reading_that_leaps_is_left_out() -> None:
    law = begun()
    for k in range(60):
        law.set({"base_temperature": ROOM + 0.01 * (k % 2), "tip_temperature": ROOM + 0.01 * (k % 3)})
        law.step(float(k), 1.0)
    before = law.get("predicted_elongation")
    law.set({"tip_temperature": ROOM + 20.0})
    law.step(60.0, 1.0)
    assert law.get("distrusted")
    assert law.get("predicted_elongation") == pytest.approx(before, abs=1e-7)


@pytest.mark.parametrize("name", ["noise", "start_spread"])
def test_what_is_no_covariance_is_refused(name: str) -> None:
    law = Instance(COMPONENT)
    law.set({f"{name}[1]": -1.0})
    with pytest.raises(InputError, match=f"{name}: no covariance of the modes.*--law linear_observer"):
        law.initialize()


def lumps(seed: int) -> DrivenRun:
    """Two lumps of metal, the first heated by 4 |speed| and cooled by motion; growth by the second, too."""
    step, rows = 10.0, []
    z = np.zeros(2)
    stages = excitation(seed, 5.0, 2.0, 4 * 3600.0)
    for stage in stages:
        for _ in range(round(stage.duration / step)):
            rows.append((*z + ROOM, stage.speed, stage.torque, stage.ambient_temperature))
            out = (1.0 + 0.1 * stage.speed) * (z + ROOM - stage.ambient_temperature)
            heat = np.array([4.0 * stage.speed - 2.0 * (z[0] - z[1]), 2.0 * (z[0] - z[1])]) - out
            z = z + step * heat / np.array([900.0, 3000.0])
    table = np.array(rows)
    temperature = np.full((len(table), len(SENSED)), ROOM)
    temperature[:, [BASE, TIP]] = table[:, :2]
    growth = (table[:, :2] - ROOM) @ np.array([2e-6, 5e-6])
    return DrivenRun(temperature, growth, step, table[:, 2:])


def found() -> LinearModel:
    return identified([lumps(0), lumps(1)], lumps(2), [BASE, TIP])


def test_a_model_is_found_of_what_nobody_wrote_down() -> None:
    """Its growth by the duty alone, in a run that it was not made from, is right to a hundredth."""
    model, unseen = found(), lumps(7)
    off = model.outputs(unseen)[:, -1] + model.start[-1] - unseen.elongation
    assert np.abs(off).max() < 0.01 * np.abs(unseen.elongation).max()
    assert np.linalg.eigvals(model.A).real.max() < 0
    assert np.all(np.diff(model.hankel) <= 0)


def test_an_excitation_is_long_enough_and_within_what_was_asked() -> None:
    stages = excitation(3, 5.0, 2.0, 7200.0)
    assert stages[0] == Stage(720.0, 0.0, 0.0)
    assert sum(each.duration for each in stages) >= 7200.0
    assert max(each.speed for each in stages) <= 5.0
    assert {round(each.duration % 10.0) for each in stages} == {0}


def test_it_says_where_thermometers_do_not_show_the_growth() -> None:
    parameters: dict[str, float | list[float]] = {"rated_speed": 7.0, "rated_torque": 3.0}
    good, bad = (
        LinearDesign(parameters, found(), Worth(share, 0.2, line, 9e-6)).told()
        for share, line in ((0.97, 0.9), (0.4, 0.5))
    )
    assert not any("wire a thermometer" in each for each in good)
    assert "a line does better here: take law='regression'" in bad
    assert bad[-1].startswith("duty and thermometers do not show all of the growth")
