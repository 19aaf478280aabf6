"""Which hypothesis explains an alarm: each is tried from several times on, and the best are named."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.watch.combining import Scatter, told_by
from warmlink.orchestration.watch.filter.shadow import Shadow, corrected
from warmlink.orchestration.watch.hypotheses import THERMOMETER, Hypothesis
from warmlink.orchestration.watch.ticks import Tick

_AGES = (
    *range(1, 21),
    24,
    28,
    33,
    39,
    46,
    55,
    65,
    77,
    92,
    110,
    130,
    155,
    185,
    220,
    260,
    310,
    370,
    440,
    530,
    630,
)
"""Ticks before the last one at which a fault may have begun, before those around the best are tried."""

_FINER = 12
"""Ticks to either side of the best that are tried then, at most."""

_ALIKE, _SHARE = 6.0, 0.15
"""Evidence, in chi-square, and share of the best's by which others fall short and are still in the set."""

_EXPLAINED = 0.5
"""Share of what is off that a cause has to explain, else it is unknown."""

_LEANS = 0.5
"""Share of the largest level from which the test for a cause says so too."""

_CLEARLY = 2.0
"""Times the evidence of the best cause whose test says so, from which one is believed without its test."""

_TOGETHER = 600.0
"""s within which a cause whose test does not say so must begin with the best, to stand beside it."""

_MOST = 4
"""Causes in a set; more than that is not a name."""


class Explanation(NamedTuple):
    """How well one hypothesis explains the readings.

    Attributes
    ----------
    name : of the cause; `sensor_drift:...` for an offset that grows
    hypothesis : what it is
    value : by which it moved, in SI; of a drift in SI per s
    std : standard deviation of the value
    evidence : chi-square that it explains
    since : s of the log at which it began
    level : how far the test for it has come, as a share of the test that has come furthest
    """

    name: str
    hypothesis: Hypothesis
    value: float
    std: float
    evidence: float
    since: float
    level: float

    @property
    def is_leaning(self) -> bool:
        """Whether the test for it says so too: what explains a moment may be there by chance."""
        return self.level >= _LEANS

    @property
    def size(self) -> str:
        """The value with its uncertainty and unit; a drift by the hour."""
        per, unit = 1.0, "" if self.hypothesis.unit == "1" else f" {self.hypothesis.unit}"
        if self.name != self.hypothesis.name:
            per, unit = 3600.0, f"{unit}/h"
        return f"{per * self.value:+.3g} (+- {per * self.std:.2g}){unit}"


@dataclass(frozen=True)
class Naming:
    """What an alarm is put down to.

    Attributes
    ----------
    ranked : explanations, best first, behind those that are believed the others
    believed : whose test leans, or whose evidence is clearly more than of any whose test does
    excess : chi-square of all leanings beyond what they have by chance, over the time of the best one
    """

    ranked: Sequence[Explanation]
    believed: frozenset[str]
    excess: float

    @classmethod
    def of(cls, found: Mapping[str, tuple[Explanation, float]]) -> Naming:
        """Of explanations by name, each with the chi-square of all leanings over its time."""
        each = [explanation for explanation, _ in found.values()]
        clear = _CLEARLY * max((e.evidence for e in each if e.is_leaning), default=np.inf)
        believed = frozenset(e.name for e in each if e.is_leaning or e.evidence >= clear)
        ranked = sorted(each, key=lambda e: (e.name not in believed, -e.evidence))
        return cls(ranked, believed, found[ranked[0].name][1] if ranked else 0.0)

    @property
    def set(self) -> tuple[Explanation, ...]:
        """Explanations that the readings do not tell apart; empty if the cause is unknown."""
        if not self.believed:
            return ()
        best = self.ranked[0].evidence
        least = best - max(_ALIKE, _SHARE * best)
        near = tuple(
            e
            for e in self.ranked
            if e.evidence >= least
            and (e.name in self.believed or abs(e.since - self.ranked[0].since) <= _TOGETHER)
        )
        known = best >= _EXPLAINED * self.excess and len(near) <= _MOST
        return near if known else ()

    @property
    def verdict(self) -> str:
        """Of the best explanation."""
        return self.ranked[0].hypothesis.verdict if self.ranked else "model"


class _Seen(NamedTuple):
    """A tick as naming needs it: the filter's gain, rows that whiten, and the readings that were expected."""

    seen: Array
    onward: Array
    pushed: Array
    direct: Array
    gain: Array
    there: NDArray[np.intp]
    whiten: Array
    white: Array
    expected: Array
    end: float


def named(
    shadow: Shadow, ticks: Sequence[Tick], scatter: Scatter, levels: Mapping[str, float], since: float = 0.0
) -> Naming:
    """Name what explains the last ticks.

    Parameters
    ----------
    shadow : as it was before the first of the ticks; it is stepped on
    ticks : the last ones, in order
    scatter : how leanings scatter where all is sound
    levels : by hypothesis, how far the test for it has come, as a share of the furthest
    since : s of the log at which it was found to begin when less was read; 0 if it was not
    """
    shadow.clipped = np.inf  # what is named is a fault by now, whose course tells which
    hypotheses = shadow.machine.hypotheses
    drifting = np.array([each.verdict == THERMOMETER for each in hypotheses])
    seen = list[_Seen]()
    for tick in ticks:
        seen.append(_seen(shadow, tick, seen[-1].expected if seen else None))
    found: dict[str, tuple[Explanation, float]] = {}
    excess_by_tick = scatter.excess

    def tried(ages: Iterable[int]) -> None:
        for age in (each for each in ages if 0 < each <= len(seen)):
            since = seen[-age].end - shadow.machine.tick
            table = np.concatenate(_rows(seen[len(seen) - age :], drifting, since))
            leaning = table[:, 1 : 1 + len(hypotheses)].T
            score, means = leaning @ table[:, 0], leaning @ table[:, 1:]
            chance = means[:, : len(hypotheses)] + age * excess_by_tick
            told = told_by(chance, np.column_stack([score, means]), scatter.scale)
            excess = float(score @ told[:, 0]) - np.linalg.matrix_rank(scatter.white)
            known, said = np.sum(means * told[:, 1:], axis=0), means.T @ told[:, 0]
            for column, (hypothesis, drifts) in enumerate(_columns(hypotheses, drifting)):
                if hypothesis.wears:
                    sizes = float(known[column]), float(said[column])
                    level = levels[hypothesis.name]
                    each = _explained(hypothesis, drifts, *sizes, since, shadow, level)
                    if each.name not in found or each.evidence > found[each.name][0].evidence:
                        found[each.name] = each, excess

    tried(_AGES)
    begins = [since] if since else []
    if found:
        begins.append(max(found.values(), key=lambda pair: pair[0].evidence)[0].since)
    for begin in begins:
        age = round((seen[-1].end - begin) / shadow.machine.tick)
        tried(each for each in range(age - _FINER, age + _FINER + 1) if each not in _AGES)
    return Naming.of(found)


def _columns(hypotheses: Sequence[Hypothesis], drifting: Array) -> list[tuple[Hypothesis, bool]]:
    return [(h, False) for h in hypotheses] + [
        (h, True) for h, d in zip(hypotheses, drifting, strict=True) if d
    ]


def _seen(shadow: Shadow, tick: Tick, before: Array | None) -> _Seen:
    """Step the filter, and keep what a direction needs to go along."""
    if tick.anew or not shadow.x.size:
        shadow.begin(tick)
    P = shadow.P
    step, linear = shadow.step(tick._replace(anew=False))
    said, _, gain = corrected(
        linear.error,
        linear.seen,
        P,
        shadow.noise.variances(tick.counts),
        np.eye(linear.error.size),
        shadow.clipped,
    )
    there = np.flatnonzero(np.isfinite(linear.error))
    late, direct = np.array([each.late for each in shadow.machine.hypotheses]).T, linear.direct
    if before is not None:
        # What comes late by part of a tick is off by what this tick and the one before it rise by.
        risen = late * (step.expected - before)[:, None] / linear.lasting
        direct = np.where(late > 0, (direct - risen) / 2, direct)
    parts = linear.seen, linear.onward, linear.pushed, direct
    return _Seen(*parts, gain, there, said.rows[:, 1:][:, there], said.rows[:, 0], step.expected, tick.end)


def _rows(seen: Sequence[_Seen], drifting: Array, began: float) -> list[Array]:
    """Whitened innovations, and whitened directions of what began at a time, with the first of some ticks."""
    first, count = seen[0], drifting.size + int(drifting.sum())
    directions, rows = np.zeros((first.seen.shape[1], count)), list[Array]()
    for tick in seen:
        grown = (tick.end - began) / 3600.0
        direct = np.column_stack([tick.direct, grown * tick.direct[:, drifting]])
        leaning = (direct + tick.seen @ directions)[tick.there]
        rows.append(np.column_stack([tick.white, tick.whiten @ leaning]))
        pushed = np.column_stack([tick.pushed, grown * tick.pushed[:, drifting]])
        directions = tick.onward @ (directions - tick.gain @ leaning) + pushed
    return rows


def _explained(
    hypothesis: Hypothesis,
    drifts: bool,
    information: float,
    score: float,
    since: float,
    shadow: Shadow,
    level: float,
) -> Explanation:
    """Best value of a hypothesis within its bounds, and what it explains."""
    information += hypothesis.span**-2
    value = score / information
    if hypothesis.slots and not drifts:
        now = float(shadow.values[hypothesis.slots[0]])
        low, high = hypothesis.lower - now, hypothesis.upper - now
        value = min(max(value, min(low, 0.0)), max(high, 0.0))
    evidence = 2 * value * score - value**2 * information
    name = hypothesis.name.replace("sensor_offset", "sensor_drift") if drifts else hypothesis.name
    scale = 3600.0 if drifts else 1.0
    return Explanation(name, hypothesis, value / scale, information**-0.5 / scale, evidence, since, level)
