"""How much worse a set of causes must be to be told apart from the best: what that means in runs.

Of two causes, each with one strength, the right one has the standardised gain z ~ N(d, 1) and the other one
w ~ N(rd, 1), where r is their correlation: chi-square differs by w^2 - z^2. Where both are nearly alike,
1 - r = s^2 / d^2 with a large d, that is normal with mean -2 s^2 and standard deviation 2 s sqrt(2).
"""

from types import SimpleNamespace
from typing import Any, cast

import numpy as np

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.fit.search import Search

RUNS = 20_000
LARGE = 1000.0
"""Strength of the right cause in standard deviations."""


class Two(Search):
    """A search that has fitted two causes, which cost the same and free different things."""

    def __init__(self, right: float, other: float) -> None:
        named = {"right": right, "other": other}
        self.fits: Any = {
            frozenset((name,)): SimpleNamespace(key=frozenset((name,)), items=(name,), chi2=chi2)
            for name, chi2 in named.items()
        }

    def score(self, fit: Any) -> float:
        return float(fit.chi2)

    def _twins(self, fit: Any) -> Any:
        return ()

    def named(self) -> set[str]:
        """The best and what is not told apart from it."""
        best = min(self.fits.values(), key=self.score)
        return {fit.items[0] for fit in (best, *self.rivals(best))}


def alike(s: float) -> Array:
    """Chi-square of the right cause minus that of the other one, shape (RUNS,)."""
    r = 1 - s**2 / LARGE**2
    first, second = np.random.default_rng(1).standard_normal((2, RUNS))
    z = LARGE + first
    w = r * LARGE + r * first + np.sqrt(1 - r**2) * second
    return np.asarray(w**2 - z**2)


def test_the_right_cause_is_among_those_named_in_995_of_1000_runs_however_alike_another_is() -> None:
    shares = []
    for s in (0.5, 1.0, 1.5, 2.0, 2.5, 3.0):
        named = [Two(difference, 0.0).named() for difference in alike(s)]
        shares.append(np.mean(["right" not in each for each in named]))
    assert 0.001 < max(shares) < 0.006


def test_two_causes_that_differ_by_five_standard_deviations_are_told_apart_in_19_of_20_runs() -> None:
    named = [Two(difference, 0.0).named() for difference in alike(5 / np.sqrt(2))]
    assert np.mean([each == {"right"} for each in named]) > 0.95


def test_a_set_of_as_many_causes_is_tried_where_it_may_come_near_and_a_larger_one_where_it_may_win() -> None:
    """What is promised may be off by 6 for a set of as many causes, and by 4 for a larger one."""

    class Priced(Two):
        def penalty(self, items: Any, alone: bool = False) -> float:
            return 10.0 * len(items)

    search, best = Priced(0.0, 0.0), cast("Any", SimpleNamespace(items=("a",)))
    allowed = [search._excess(cast("Any", SimpleNamespace(items=items)), best) for items in ("b", "bc")]
    assert allowed == [7.0 + 6.0 - 10.0, 4.0 - 20.0]
