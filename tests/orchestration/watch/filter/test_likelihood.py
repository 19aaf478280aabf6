"""The likelihood of a filter's pass is that of one large normal distribution."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from warmlink.orchestration.watch.filter.likelihood import filtered, likeliest
from warmlink.orchestration.watch.filter.noise import ShadowNoise
from warmlink.orchestration.watch.filter.shadow import LinearTick

PLANT, WANDERS, OUTPUTS = 2, 1, 2
N = PLANT + WANDERS + 1 + OUTPUTS
NOISE = ShadowNoise(
    *(np.array([0.2, 0.3]), np.array([0.1, 0.05]), np.array([0.4]), np.array([2.0]), np.array([0.2, 0.1])),
    np.array([[0.5, 0.0], [2.0, 1.0]]),
    np.ones(3),
)


def passed(count: int, missing: bool = False, anew: int = 0) -> list[LinearTick]:
    """Ticks of a filter that has corrected nothing."""
    draw = np.random.default_rng(5)
    ticks = []
    for k in range(count):
        onward = np.eye(N)
        onward[:PLANT, :PLANT] = [[0.9, 0.05], [0.1, 0.8]]
        onward[:PLANT, PLANT:] = 0.1 * draw.normal(size=(PLANT, N - PLANT))
        error = draw.normal(0.0, 0.3, OUTPUTS)
        if missing and k % 3 == 1:
            error[0] = np.nan
        seen = draw.normal(size=(OUTPUTS, N))
        empty = np.zeros((N, 0)), np.zeros((OUTPUTS, 0))
        counts, lasting = np.array([4.0, 1.0]), 60.0 * (1 + k % 2)
        driven = np.zeros(0), np.array([k % 3, k % 2], dtype=float)
        ticks.append(
            LinearTick(error, seen, onward, *empty, counts, lasting, np.zeros(N), k in (0, anew), *driven)
        )
    return ticks


def all_at_once(ticks: list[LinearTick], noise: ShadowNoise) -> float:
    """Twice the log-likelihood of all errors together, without its constant, by their joint covariance."""
    size = len(ticks) * N
    states, way = np.zeros((size, size)), np.eye(N)
    P = noise.at_start(PLANT)
    onwards = []
    for tick in ticks:
        way = tick.onward.copy()
        way[np.arange(PLANT, N), np.arange(PLANT, N)] = noise.kept(tick.lasting)
        onwards.append(way)
    for k, tick in enumerate(ticks):
        here = slice(k * N, (k + 1) * N)
        states[here, here] = P
        ahead = P
        for j in range(k + 1, len(ticks)):
            ahead = onwards[j - 1] @ ahead
            there = slice(j * N, (j + 1) * N)
            states[there, here], states[here, there] = ahead, ahead.T
        P = onwards[k] @ P @ onwards[k].T + np.diag(noise.process(PLANT, tick.lasting, tick.stirred))
    H = np.zeros((len(ticks) * OUTPUTS, size))
    for k, tick in enumerate(ticks):
        H[k * OUTPUTS : (k + 1) * OUTPUTS, k * N : (k + 1) * N] = tick.seen
    read = np.concatenate([noise.variances(tick.counts) for tick in ticks])
    error = np.concatenate([tick.error for tick in ticks])
    there = np.isfinite(error)
    S = (H @ states @ H.T + np.diag(read))[np.ix_(there, there)]
    return float(-np.linalg.slogdet(S)[1] - error[there] @ np.linalg.solve(S, error[there]))


@pytest.mark.parametrize("missing", [False, True])
def test_it_is_that_of_all_readings_together(missing: bool) -> None:
    more = {"misfit": np.array([0.7, 0.6]), "stirred": np.array([[0.0, 1.0], [0.5, 0.0]])}
    other = replace(NOISE, misfit_memory=600.0, **more)
    found = filtered(ticks := passed(9, missing), [NOISE, other]).likelihood
    assert found == pytest.approx([all_at_once(ticks, NOISE), all_at_once(ticks, other)], rel=1e-9)


def test_a_beginning_anew_makes_two_logs_of_one() -> None:
    ticks = passed(8, anew=5)
    parts = [all_at_once(ticks[:5], NOISE), all_at_once(ticks[5:], NOISE)]
    assert filtered(ticks, [NOISE]).likelihood[0] == pytest.approx(sum(parts), rel=1e-9)


def test_the_likeliest_noise_is_likelier_and_no_smaller_than_it_may_be() -> None:
    ticks, least = passed(12), np.array([0.15, 0.02])
    found = likeliest(ticks, NOISE, [600.0], [2.0, 1.3], least)
    before, after = filtered(ticks, [NOISE, found]).likelihood
    assert after > before
    assert np.all(found.misfit >= least)
    assert np.array_equal(found.white, NOISE.white)


def made_up(noise: ShadowNoise, count: int) -> list[LinearTick]:
    """Ticks of a machine whose states wander as the noise says, with unusual work now and then."""
    draw, ticks = np.random.default_rng(1), list[LinearTick]()
    state = np.linalg.cholesky(noise.at_start(PLANT)) @ draw.normal(size=N)
    for k, each in enumerate(passed(count)):
        stirred = np.array([float(k % 20 < 4)])
        onward = each.onward.copy()
        onward[np.arange(PLANT, N), np.arange(PLANT, N)] = noise.kept(each.lasting)
        error = each.seen @ state + np.sqrt(noise.variances(each.counts)) * draw.normal(size=OUTPUTS)
        ticks.append(each._replace(error=error, onward=onward, stirred=stirred))
        added = np.sqrt(noise.process(PLANT, each.lasting, stirred))
        state = onward @ state + added * draw.normal(size=N)
    return ticks


def test_a_model_that_errs_where_work_is_unusual_is_trusted_less_there_alone() -> None:
    still, stirred = (replace(NOISE, stirred=np.array([[0.0], [each]])) for each in (0.3, 8.0))
    begun = replace(NOISE, stirred=np.array([[0.0], [1.5]]))
    found = [
        likeliest(made_up(each, 200), begun, [], [3.0, 1.5], np.zeros(OUTPUTS), ("stirred",))
        for each in (still, stirred)
    ]
    assert found[0].stirred[1, 0] < 1.0
    assert 4.0 < found[1].stirred[1, 0] < 16.0
    assert np.array_equal(found[1].misfit, NOISE.misfit)
    usual, unusual = (found[1].process(PLANT, 60.0, np.array([each])) for each in (0.0, 1.0))
    assert np.array_equal(usual, NOISE.process(PLANT, 60.0, np.zeros(2)))
    assert np.all(unusual[-OUTPUTS:] > 10 * usual[-OUTPUTS:])
