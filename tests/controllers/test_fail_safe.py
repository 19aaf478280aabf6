"""Limits and doubt, by themselves."""

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from warmlink.controllers import fail_safe

P: Any = SimpleNamespace(
    correction_limit=1e-4,
    correction_rate_limit=2e-6,
    warning_limit=5e-5,
    tolerance=5e-6,
    stuck_time=30.0,
    sample_time=1.0,
)
GATES = fail_safe.Gates(gate=5.0, mean_gate=0.6, share=1.0 - math.exp(-1.0 / 120.0), return_time=60.0)


def memory(signals: int = 1) -> fail_safe.Trust:
    return fail_safe.at_start(np.full(signals, 300.0))


@given(st.floats(-1e-4, 1e-4), st.floats(-1, 1), st.floats(0.01, 600))
def test_a_correction_stays_within_its_limits(previous: float, wanted: float, step: float) -> None:
    found = fail_safe.limited(previous, wanted, P, step)
    assert abs(found) <= P.correction_limit * (1 + 1e-12)
    assert abs(found - previous) <= P.correction_rate_limit * step * (1 + 1e-9)
    if abs(wanted - previous) <= P.correction_rate_limit * step and abs(wanted) <= P.correction_limit:
        assert found == pytest.approx(wanted, abs=1e-18)


@pytest.mark.parametrize(
    ("correction", "wanted", "expected"), [(1e-5, 1e-5, 0.0), (6e-5, 6e-5, 1.0), (1e-5, 3e-5, 1.0)]
)
def test_a_warning_near_a_limit_or_held_back(correction: float, wanted: float, expected: float) -> None:
    assert fail_safe.warning(correction, wanted, P) == expected


def test_a_reading_that_repeats_itself_is_no_news_after_a_while() -> None:
    trust = memory()
    said = []
    for _ in range(40):
        news, trust = fail_safe.fresh(trust, np.array([300.0]), P, 1.0)
        said.append(news[0])
    assert said == [1.0] * 29 + [0.0] * 11
    news, trust = fail_safe.fresh(trust, np.array([300.01]), P, 1.0)
    assert news[0] == 1.0


def test_a_missing_reading_is_no_news_and_the_last_is_kept() -> None:
    news, trust = fail_safe.fresh(memory(), np.array([math.nan]), P, 1.0)
    assert news[0] == 0.0
    assert trust.last[0] == 300.0


NEW = fail_safe.Memory(0.0, 0.0, 0.0)


def judge(memory: fail_safe.Memory, innovation: float, news: float = 1.0) -> tuple[float, fail_safe.Memory]:
    return fail_safe.gate_reading(memory, news, innovation, 1.0, 1.0, GATES, 1.0)


def test_a_leap_is_out_at_once_and_comes_back_when_it_has_been_calm() -> None:
    use, after = judge(NEW, 6.0)
    assert (use, after.out) == (0.0, 1.0)
    uses = []
    for _ in range(80):
        use, after = judge(after, 0.1)
        uses.append(use)
    assert uses == [0.0] * 59 + [1.0] * 21


def test_a_lasting_bias_is_out_though_no_single_reading_leaps() -> None:
    after, said = NEW, []
    for _ in range(200):
        _, after = judge(after, 1.5)
        said.append(after.out)
    expected = -120 * math.log(1 - 0.6 / 1.5)
    assert said.index(1.0) == pytest.approx(expected, abs=1.5)


def test_a_repeated_reading_is_a_fault_only_off_the_prediction() -> None:
    assert judge(NEW, 1.0, news=0.0)[1].out == 0.0
    assert judge(NEW, 4.0, news=0.0)[1].out == 1.0
    assert judge(NEW, math.nan, news=0.0)[1].out == 0.0, "missing is another matter"


def test_sound_signals_are_not_doubted() -> None:
    """White standard normal innovations: a mean gate of nine of its standard deviations, a gate of five."""
    draw, after = np.random.default_rng(4), NEW
    out = 0.0
    for number in draw.normal(size=10_000):
        _, after = judge(after, float(number))
        out += after.out
    assert out == 0.0
