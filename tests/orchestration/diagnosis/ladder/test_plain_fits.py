"""Plain fits against what made the numbers: a ridge in closed form, and ARX models of exact sequences."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from warmlink.orchestration.diagnosis.ladder.arx import arx
from warmlink.orchestration.diagnosis.ladder.least_squares import FEWEST, Linear, regressed
from warmlink.orchestration.diagnosis.ladder.signals import Signals


def test_a_ridge_without_a_share_finds_the_plane_and_its_constant() -> None:
    x = np.random.default_rng(1).normal(size=(40, 3)) * [1.0, 1e-6, 1e3] + [0.0, 5e-6, -2e4]
    true = np.array([[2.0, -1.0], [3e6, 4e5], [1e-3, 0.0]])
    weights, constant = regressed(x, x @ true + [7.0, -3.0], 0.0)
    np.testing.assert_allclose(weights, true, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(constant, [7.0, -3.0], rtol=1e-7)


@pytest.mark.parametrize("share", [1e-3, 0.5, 4.0])
def test_a_share_shrinks_the_weight_of_a_single_column_and_leaves_the_mean(share: float) -> None:
    x = np.random.default_rng(2).normal(3.0, 2.0, size=(50, 1))
    y = 5.0 * x + 11.0
    weights, constant = regressed(x, y, share)
    assert weights[0, 0] == pytest.approx(5.0 / (1.0 + share), rel=1e-9)
    assert float(np.mean(x @ weights + constant - y)) == pytest.approx(0.0, abs=1e-9)


def test_units_of_a_column_change_its_weight_alone_and_a_column_that_never_changes_has_none() -> None:
    draw = np.random.default_rng(3)
    x, y = draw.normal(size=(30, 2)), draw.normal(size=(30, 1))
    scale = np.array([1e3, 1e-4])
    weights, constant = regressed(x, y, 0.1)
    scaled, same = regressed(x * scale, y, 0.1)
    np.testing.assert_allclose(scaled, weights / scale[:, None], rtol=1e-9)
    np.testing.assert_allclose(same, constant, rtol=1e-9)
    still, _ = regressed(np.column_stack([x, np.full(30, 295.15)]), y, 0.1)
    np.testing.assert_allclose(still, np.vstack([weights, [[0.0]]]), rtol=1e-9)


AHEAD, PUSH, CONSTANT = np.array([[0.9, 0.05], [0.02, 0.8]]), np.array([0.3, 0.1]), np.array([29.0, 60.0])


def recorded(rows: int = 120) -> Signals:
    """Two channels that follow an input, step after step, as no machine does so exactly."""
    driven = np.repeat(np.random.default_rng(4).uniform(0.0, 10.0, rows // 6), 6)
    readings = np.tile([295.0, 295.0], (rows, 1))
    for k in range(rows - 1):
        readings[k + 1] = AHEAD @ readings[k] + PUSH * driven[k + 1] + CONSTANT
    return Signals(
        time=10.0 * np.arange(rows),
        readings=readings,
        start=readings[0],
        inputs=driven[:, None],
        relative=np.array([False]),
        products=driven[:, None] ** 2,
        fitted=np.arange(rows) < rows // 2,
        ambient=np.zeros(rows),
        names=("speed",),
        pairs=(("speed", "speed"),),
        channels=("a", "b"),
        room="",
    )


def exact(run: Signals) -> list[tuple[float, dict[int, Linear]]]:
    """Largest error on rows that were not fitted, and the form, of each that is tried."""
    found = []
    for form in arx([run]):
        fitted = form([run])
        error = np.abs(fitted.readings[0] - run.readings)[~run.fitted]
        found.append((float(np.max(error)), dict(fitted.linear)))
    return found


@pytest.mark.parametrize("rows", [120, 402])
def test_a_sequence_of_first_order_is_foretold_by_its_own_form(rows: int) -> None:
    """Coupled, of order 1, nearly without a ridge, in steps of the rows: the form that made the numbers."""
    error, linear = min(exact(recorded(rows)), key=lambda each: each[0])
    assert error < 1e-2
    assert linear[0].channels == linear[1].channels == (0, 1)
    np.testing.assert_allclose(linear[0].ahead[0], AHEAD, atol=1e-3)
    np.testing.assert_allclose(linear[0].driven["speed",], PUSH, rtol=1e-3)
    assert (linear[0].place, linear[1].place) == (0, 1)


def test_what_stays_as_it_is_does_so_in_a_step_that_ends_after_the_last_row() -> None:
    run, time = recorded(), np.append(10.0 * np.arange(10), 95.0)
    rest = np.linalg.solve(np.eye(2) - AHEAD, 5.0 * PUSH + CONSTANT)
    still = replace(
        run,
        time=time,
        readings=np.tile(rest, (time.size, 1)),
        start=rest,
        inputs=np.full((time.size, 1), 5.0),
        products=np.full((time.size, 1), 25.0),
        fitted=np.zeros(time.size, dtype=bool),
        ambient=np.zeros(time.size),
    )
    forms = list(arx([run, still]))
    error, said = min(
        (float(np.nanmax(np.abs(form([run]).readings[0] - run.readings))), k) for k, form in enumerate(forms)
    )
    assert error < 1e-2
    np.testing.assert_allclose(forms[said]([run, still]).readings[1], still.readings, atol=1e-2)


def test_what_has_too_few_readings_is_not_fitted() -> None:
    run = recorded()
    few = replace(run, fitted=np.arange(run.time.size) < FEWEST)
    for form in arx([few]):
        assert form([few]).linear == {}
        assert np.isnan(form([few]).readings[0]).all()
