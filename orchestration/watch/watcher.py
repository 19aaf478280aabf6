"""The twin: it learns from the sound part, judges every tick that follows, and names what it alarms of."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, NamedTuple

import numpy as np

from warmlink.fmus.arguments import argument
from warmlink.fmus.errors import InputError
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.progress import spinner
from warmlink.orchestration.watch.combining import leanings
from warmlink.orchestration.watch.filter.shadow import Shadow
from warmlink.orchestration.watch.hypotheses import CLOCK, LAW, MODEL, THERMOMETER, WatchedMachine
from warmlink.orchestration.watch.law import LawError
from warmlink.orchestration.watch.learning import SoundPart, learn, surprise_of
from warmlink.orchestration.watch.naming import Explanation, Naming, named
from warmlink.orchestration.watch.sequential import APART, FEWEST, SETTLED, Limits, Sequential, worked_out
from warmlink.orchestration.watch.ticks import Tick

SHADOW_KEPT = ("x", "rest", "P", "directions", "lags")
"""What of a filter changes from tick to tick."""

SHOWN = 360
"""Ticks that a page shows."""

WINDOW, _SNAPSHOT = 720, 60
"""Ticks that are kept to name an alarm by, and ticks from one kept filter to the next."""

_AGAIN = (10, 30, 60, 120, 240, 480)
"""Ticks after an alarm at which its name is sought again, with what was read since."""

_QUIET = 0.7
"""Share of the threshold below which all sums have to stay for some time for an alarm to be over."""


@dataclass
class Standing:
    """An alarm that is not over: when it came, ticks since, quiet ticks, its causes and since when."""

    time: float
    ticks: int = 0
    quiet: int = 0
    causes: tuple[str, ...] = ()
    since: float = 0.0


class Moment(NamedTuple):
    """A tick as a page shows it: time in s, levels by verdict, readings, expected ones and 1 sigma in SI."""

    time: float
    levels: dict[str, float]
    readings: Array
    expected: Array
    sigma: Array


@dataclass
class Watcher:
    """Watches one machine.

    Parameters
    ----------
    machine : what is watched
    sound : s of the opening part that is declared sound
    rate : of false alarms in 1/day
    law : what a law leaves of the growth; None if there is no law, or the growth is not measured

    Attributes
    ----------
    learnt, limits : None until the sound part is over
    learning : whether it is learning from it now, which may be given up at any moment
    explained : what the alarm that was told last is put down to
    combined : leanings of all hypotheses that tell each best that is watched for, shape (hypotheses, things)
    levels : each thing's largest sum as a share of its threshold, shape (things,)
    """

    machine: WatchedMachine
    sound: float
    rate: float
    law: LawError | None = None
    explained: Sequence[Explanation] = ()
    learnt: SoundPart | None = None
    limits: Limits | None = None
    shadow: Shadow | None = None
    test: Sequential | None = None
    standing: Standing | None = None
    opening: list[Tick] = field(default_factory=list)
    recent: deque[Tick] = field(default_factory=deque)
    snapshots: deque[tuple[int, Shadow]] = field(default_factory=deque)
    judged: int = 0
    learning: bool = False
    combined: Array = field(default_factory=lambda: np.zeros((0, 0)))
    moments: deque[Moment] = field(default_factory=lambda: deque(maxlen=SHOWN))

    KEPT: ClassVar[tuple[str, ...]] = (
        *("learnt", "limits", "standing", "opening", "recent", "judged", "moments"),
    )
    """What a restart needs of it, beside filter and test."""

    @property
    def things(self) -> list[str]:
        """Names of what is tested for, in the order of the levels; then that anything is wrong, and a law."""
        names = [each.name for each in self.machine.hypotheses if each.wears] + ["anything"]
        return names if self.law is None else [*names, LAW]

    @property
    def levels(self) -> Array:
        """Largest sum of each thing as a share of its threshold, shape (things,); 0 before judging."""
        return np.zeros(len(self.things)) if self.test is None else self.test.level

    def add(self, tick: Tick) -> Iterator[dict[str, Any]]:
        """Take a tick; give what is to be told, mostly nothing."""
        error = np.nan if self.law is None else self.law.add(tick)
        if self.test is None:
            self.opening.append(tick)
            if self.law is not None:
                self.law.opening.append(error)
            if tick.end - self.opening[0].start >= self.sound:
                yield self._begin()
            return
        yield from self._judge(tick, error)

    def refuse_unlearnt(self) -> None:
        """Raise InputError where the log has ended within its sound part."""
        if self.test is None:
            hours = (self.opening[-1].end - self.opening[0].start) / 3600 if self.opening else 0.0
            given = argument("sound", f"{self.sound / 3600:.4g} h")
            raise InputError(
                f"{given}: the log ends after {hours:.4g} h, "
                "within the part that is declared sound; nothing was judged, declare a shorter part"
            )

    def _begin(self) -> dict[str, Any]:
        """Learn from the sound part, and work out the thresholds."""
        if len(self.opening) < FEWEST + SETTLED:
            least = (FEWEST + SETTLED) * self.machine.tick / 3600
            given = argument("sound", f"{self.sound / 3600:.4g} h")
            raise InputError(
                f"{given}: holds only {len(self.opening)} ticks of {self.machine.tick:g} s with "
                f"rows; the noise and the thresholds need at least {least:.2g} h"
            )
        self.learning = True
        with spinner("Learning from the sound part") as progress:
            self.learnt = learn(self.machine, self.opening, progress)
        errors = None if self.law is None else self.law.learn()
        lean, weight = self._tested(self.learnt.lean, self.learnt.weight, self.learnt.surprise, errors)
        self.limits = worked_out(lean[SETTLED:], weight[SETTLED:], self.rate, 86400 / self.machine.tick)
        self.learning = False
        self.learnt = replace(self.learnt, lean=lean[:0], weight=weight[:0], surprise=lean[:0, 0])
        self.restart(self.learnt, self.limits)
        errors = errors or [np.nan] * len(self.opening)
        for each, error in list(zip(self.opening, errors, strict=True))[-WINDOW:]:
            self._step(each, error)
        end, self.opening = self.opening[-1].end, []
        return {"time_s": end, "alarm": False, "watching": True, "told": self.limits.told()}

    def restart(self, learnt: SoundPart, limits: Limits) -> None:
        """Begin to judge, with what was learnt and the thresholds."""
        self.shadow = Shadow(self.machine, learnt.noise, learnt.values, learnt.offsets, learnt.weights)
        self.test = Sequential(limits, len(self.things))
        self.combined = learnt.scatter.combined(self.machine.watched)

    def _tested(self, lean: Any, weight: Any, surprise: Any, errors: Any) -> tuple[Any, Any]:
        """Of what is watched for, and beside it how much is off at all, and what the law leaves."""
        leans = [lean, np.asarray(surprise)[..., None]]
        weights = [weight, np.ones_like(leans[1])]
        if self.law is not None:
            said, known = self.law.leans(errors)
            leans.append(said[..., None])
            weights.append(known[..., None])
        return np.concatenate(leans, axis=-1), np.concatenate(weights, axis=-1)

    def _step(self, tick: Tick, error: float) -> None:
        """Step filter and test by a tick, which is kept for naming."""
        assert self.shadow is not None
        assert self.test is not None
        if tick.anew:
            self.test.begin()
        if self.judged % _SNAPSHOT == 0:
            self.snapshots.append((self.judged, twin_of(self.shadow)))
            while len(self.snapshots) > 1 + WINDOW // _SNAPSHOT:
                self.snapshots.popleft()
        self.recent.append(tick)
        while len(self.recent) > self.judged - self.snapshots[0][0] + 1:
            self.recent.popleft()
        self.judged += 1
        said, _ = self.shadow.step(tick)
        told = leanings(said.rows, self.combined)
        self.test.add(*self._tested(*told, surprise_of(said.white), error))
        self.moments.append(Moment(tick.end, self.by_verdict(), tick.readings, said.expected, said.sigma))

    def by_verdict(self) -> dict[str, float]:
        """Largest level of each verdict; that anything is wrong counts as the model's."""
        found = {MODEL: 0.0, THERMOMETER: 0.0, CLOCK: 0.0}
        verdicts = [each.verdict for each in self.machine.hypotheses if each.wears] + [MODEL]
        verdicts += [] if self.law is None else [LAW]
        found |= {} if self.law is None else {LAW: 0.0}
        for verdict, level in zip(verdicts, self.levels.tolist(), strict=True):
            found[verdict] = max(found[verdict], level)
        return found

    def _judge(self, tick: Tick, error: float) -> Iterator[dict[str, Any]]:
        self._step(tick, error)
        level = float(self.levels.max())
        if self.standing is None:
            if level >= 1.0:
                self.standing = Standing(tick.end)
                yield self._told(tick.end)
            return
        self.standing.ticks += 1
        self.standing.quiet = self.standing.quiet + 1 if level < _QUIET else 0
        if self.standing.quiet >= APART:
            began, self.standing = self.standing.time, None
            told = "the alarm is over: what was wrong has ended, or the work since does not show it"
            yield {"time_s": tick.end, "alarm": False, "over": True, "began_s": began, "told": told}
        elif self.standing.ticks in _AGAIN and self.standing.quiet == 0:
            before = self.standing.causes
            said = self._told(tick.end)
            if self.standing.causes != before:
                yield {**said, "again": True}

    def _of_law(self, time: float) -> dict[str, Any]:
        """An alarm of the law alone."""
        assert self.law is not None
        assert self.standing is not None
        self.explained, self.standing.causes = (), (LAW,)
        told = (
            f"the law leaves {1e6 * self.law.shift:+.1f} um of the growth beside what it left in the sound "
            "part, while the model explains the readings"
        )
        return {"time_s": time, "alarm": True, "verdict": LAW, "causes": [], "told": told}

    def named(self) -> Naming:
        """What the last ticks are put down to."""
        assert self.snapshots
        first = self.judged - len(self.recent)
        at, shadow = next(pair for pair in self.snapshots if pair[0] >= first)
        since = self.standing.since if self.standing else 0.0
        assert self.learnt is not None
        levels = dict(zip(self.things, (self.levels / self.levels.max()).tolist(), strict=True))
        return named(twin_of(shadow), list(self.recent)[at - first :], self.learnt.scatter, levels, since)

    def _told(self, time: float) -> dict[str, Any]:
        """An alarm, with what it is put down to."""
        assert self.standing is not None
        if self.law is not None and self.levels[:-1].max() < min(self.levels[-1], 1.0):
            return self._of_law(time)
        found = self.named()
        causes = self.explained = found.set
        self.standing.causes = tuple(each.name for each in causes)
        self.standing.since = causes[0].since if causes else self.standing.since
        best = self.things[int(np.argmax(self.levels))]
        return {
            "time_s": time,
            "alarm": True,
            "verdict": found.verdict if causes else "model",
            "causes": [
                {"name": e.name, "value": e.value, "std": e.std, "since_s": e.since, "evidence": e.evidence}
                for e in causes
            ],
            "told": sentence(found, self.standing.time if time == self.standing.time else time, best),
        }


def sentence(found: Naming, time: float, first: str) -> str:
    """What an alarm is put down to and on which evidence, in one sentence."""
    causes = found.set
    if not causes:
        near = ", ".join(each.name for each in found.ranked[:3])
        return (
            f"the readings lean as {first} would make them, but no known cause explains them "
            f"(nearest: {near})"
        )
    best = causes[0]
    names = " or ".join(dict.fromkeys(each.name for each in causes))
    minutes = max(time - best.since, 0.0) / 60
    share = min(best.evidence / max(found.excess, best.evidence, 1e-9), 1.0)
    return (
        f"{names}: since about {minutes:.0f} min before, {best.hypothesis.variable} by {best.size} explains "
        f"{100 * share:.0f} % of what the readings are off by"
    )


def twin_of(shadow: Shadow) -> Shadow:
    """A filter of the same machine that goes on by itself."""
    other = Shadow(shadow.machine, shadow.noise, shadow.values, shadow.offsets, shadow.weights)
    for name in SHADOW_KEPT:
        setattr(other, name, getattr(shadow, name).copy())
    return other
