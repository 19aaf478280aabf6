import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from warmlink.fmus.errors import InputError
from warmlink.orchestration.studies.case import METRICS, Case, Constraint, Gathered, Outcome, gather
from warmlink.orchestration.written.tables import read_table

VALUES = st.lists(st.floats(0, 1e3), min_size=1, max_size=12)


def outcome(largest: float, settled: float | None = 0.0) -> Outcome:
    return Outcome(largest, largest / 2, largest / 3, settled, 30.0, 10.0, 0.1, 0.01)


def case(stop_time: float = 3600.0) -> Case:
    return Case(("lag", "work", "nominal"), "LagCompensator", {}, stop_time, 1.0, "gauss_seidel", 5e-6)


def test_cvar_is_the_mean_of_the_worst_share() -> None:
    values = [1.0, 8.0, 2.0, 4.0]
    assert gather(values, "cvar", 0.25) == 8.0
    assert gather(values, "cvar", 0.5) == 6.0
    # A value at the edge counts in part: 0.375 of four are the largest and half of the next.
    assert gather(values, "cvar", 0.375) == pytest.approx((8 + 0.5 * 4) / 1.5)
    assert gather(values, "cvar", 0.1) == 8.0


@given(values=VALUES, level=st.floats(0.01, 1))
def test_cvar_lies_between_mean_and_worst_and_falls_with_the_share(values: list[float], level: float) -> None:
    mean, worst = gather(values, "mean", 1), gather(values, "worst", 1)
    found = gather(values, "cvar", level)
    assert mean - 1e-9 <= found <= worst + 1e-9
    assert gather(values, "cvar", 1.0) == pytest.approx(mean, abs=1e-9)
    assert gather(values, "cvar", min(1.0, 1.1 * level)) <= found + 1e-9


@pytest.mark.parametrize("over", ["worst", "mean", "cvar"])
def test_a_run_without_figures_leaves_no_objective(over: str) -> None:
    assert math.isnan(gather([1.0, math.nan], over, 0.5))
    objective = Gathered(over=over)
    assert math.isnan(objective.value([outcome(3.0), Outcome(stopped="it stopped")], [case(), case()]))


def test_a_run_that_never_settles_counts_as_its_whole_time() -> None:
    assert METRICS["time_to_tolerance_s"](outcome(9.0, None), case(7200)) == 7200
    assert METRICS["outside_tolerance_min"](outcome(9.0), case(3600)) == 30.0


def test_a_constraint_tells_by_how_much_it_is_broken() -> None:
    constraint = Constraint("max_abs_um", at_most=5)
    assert constraint.excess([outcome(3.0), outcome(7.0)], [case(), case()]) == 2.0


@pytest.mark.parametrize(
    ("table", "sentence"),
    [
        (3, "3 is not a table; write a table with any of level, metric and over"),
        ({"metrik": "rms_um"}, "metrik is not known"),
        ({"metric": "speed"}, "'speed' is not known; choose max_abs_um"),
        ({"over": "median"}, "'median' is not known; did you mean mean?"),
        ({"level": 0}, "0 is no share"),
        ({"level": 1.5}, "1.5 is no share"),
        ({"level": math.nan}, "nan is no share"),
    ],
)
def test_a_bad_objective_is_refused(table: object, sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        read_table(Gathered, table, "mine: objective")


@pytest.mark.parametrize("bound", [None, "5", math.nan, math.inf, True])
def test_a_constraint_needs_a_bound(bound: object) -> None:
    with pytest.raises(InputError, match="is no bound"):
        read_table(Constraint, {"metric": "max_abs_um", "at_most": bound}, "mine: constraint 1")
