"""Leanings are combined so that what the model is off by anyway counts for little."""

from __future__ import annotations

import numpy as np
import pytest

from warmlink.orchestration.watch.combining import leanings, scatter_of

TICKS = 6000


def rows_of(seed: int, misfit: float, fault: float = 0.0) -> list[np.ndarray]:
    """Innovations of two readings, and two hypotheses: one moves both, the other the first alone.

    A misfit that lasts some hours moves the first as well.
    """
    draw = np.random.default_rng(seed)
    white = draw.standard_normal((TICKS, 2))
    white[:, 0] += misfit * np.repeat(draw.standard_normal(TICKS // 60), 60)
    ways = np.array([[1.0, 1.0], [1.0, 0.0]])
    return [np.column_stack([each + fault * ways[:, 0], ways]) for each in white]


def told(rows: list[np.ndarray], combined: np.ndarray) -> np.ndarray:
    """Sums of combined leanings over hours, in standard deviations of what they are in sound ones."""
    lean = np.array([leanings(each, combined)[0] for each in rows])
    return lean.reshape(-1, 60, lean.shape[1]).sum(axis=1)


def clearness(combined: np.ndarray) -> np.ndarray:
    """By how many of its standard deviations a sum over an hour moves by the first hypothesis."""
    sound, faulty = told(rows_of(2, 0.5), combined), told(rows_of(2, 0.5, 0.2), combined)
    return np.abs((faulty - sound).mean(axis=0)) / sound.std(axis=0)


def test_where_the_model_errs_anyway_counts_for_little() -> None:
    watched = np.array([True, True])
    alone, together = np.eye(2), scatter_of(rows_of(1, 0.5)).combined(watched)
    assert clearness(together)[0] > 2 * clearness(alone)[0]
    assert abs(together[1, 0]) > 0.5 * abs(together[0, 0])


def test_white_innovations_leave_each_hypothesis_to_its_own_leaning() -> None:
    scatter = scatter_of(rows_of(1, 0.0))
    combined = scatter.combined(np.array([True, False]))
    assert combined.shape == (2, 1)
    assert abs(combined[1, 0]) < 0.3 * abs(combined[0, 0])
    assert np.linalg.eigvalsh(scatter.excess).min() >= -1e-9


def test_a_weight_is_the_square_that_white_innovations_have() -> None:
    rows = rows_of(3, 0.0)
    lean, weight = (np.array(each) for each in zip(*(leanings(e, np.eye(2)) for e in rows), strict=True))
    assert np.mean(lean**2, axis=0) / weight[0] == pytest.approx([1.0, 1.0], rel=0.1)
