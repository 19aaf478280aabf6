"""How often the diagnosis is right: fresh runs with hidden effects, and what was said of them."""

from __future__ import annotations

import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from warmlink.orchestration.diagnosis.hidden import Segment
from warmlink.orchestration.diagnosis.hide import (
    CHANNELS,
    EFFECTS,
    INFORMATIVE,
    MOVING,
    REAL,
    STILL,
    WHITE,
    Noise,
    effect_of,
    hide,
    write_csv,
)

if TYPE_CHECKING:
    from warmlink.orchestration.diagnosis.experiment import Experiment
    from warmlink.orchestration.diagnosis.verdict import Assessment


@dataclass(frozen=True)
class Kind:
    """A kind of trial: how many effects are hidden, from where, under which noise and duty cycle."""

    effects: int
    known: bool = True
    noise: Noise = WHITE
    duty: tuple[Segment, ...] = INFORMATIVE
    weak: bool = False


KINDS: dict[str, Kind] = {
    "single": Kind(1),
    "weak": Kind(1, weak=True),
    "pair": Kind(2),
    "triple": Kind(3),
    "none": Kind(0),
    "unknown": Kind(1, known=False),
    "single, real noise": Kind(1, noise=REAL),
    "pair, real noise": Kind(2, noise=REAL),
    "none, real noise": Kind(0, noise=REAL),
    "unknown, real noise": Kind(1, known=False, noise=REAL),
    "still": Kind(1, duty=STILL),
    "moving": Kind(1, duty=MOVING),
}

FULL = {
    "single": 400,
    "weak": 200,
    "pair": 200,
    "triple": 100,
    "none": 400,
    "unknown": 200,
    "single, real noise": 200,
    "pair, real noise": 100,
    "none, real noise": 200,
    "unknown, real noise": 100,
    "still": 50,
    "moving": 50,
}


@dataclass(frozen=True)
class Trial:
    """One hidden truth and what was said of it.

    Attributes
    ----------
    right : the truth is the verdict, or a member of the stated ambiguous set
    wrong_name : a cause or set was named with confidence that is not the truth
    covered : whether each hidden strength lies in its 95 % interval, where the truth was found best
    heldout : held-out error in units of noise, where the verdict is `named`
    followed : whether the next experiment of an ambiguous verdict, carried out on the truth, named it;
        None where none was proposed
    seconds : processor time of the search
    """

    kind: str
    truth: tuple[str, ...]
    verdict: str
    found: tuple[str, ...]
    right: bool
    wrong_name: bool
    covered: tuple[bool, ...]
    heldout: float | None
    followed: bool | None
    seconds: float


@dataclass(frozen=True)
class Bench:
    """All trials; `table` gives the figures, `confusion` who was taken for whom."""

    trials: tuple[Trial, ...]

    def table(self) -> list[dict[str, Any]]:
        """Figures by kind of trial; shares in percent, None where there is nothing to count."""
        rows = []
        for kind in dict.fromkeys(t.kind for t in self.trials):
            trials = [t for t in self.trials if t.kind == kind]
            held = [t.heldout for t in trials if t.heldout is not None]
            covered = [c for t in trials for c in t.covered]
            rows.append(
                {
                    "kind": kind,
                    "runs": len(trials),
                    "right_percent": _percent(t.right for t in trials),
                    "wrong_name_percent": _percent(t.wrong_name for t in trials),
                    **{word: sum(t.verdict == word for t in trials) for word in _WORDS},
                    "in_interval_percent": _percent(covered),
                    "heldout_within_10_percent": _percent(h < 1.1 for h in held),
                    "next_experiment_right_percent": _percent(
                        t.followed for t in trials if t.followed is not None
                    ),
                    "seconds": float(np.mean([t.seconds for t in trials])),
                }
            )
        return rows

    def confusion(self) -> dict[tuple[str, str], int]:
        """Number of runs by hidden causes and causes said, without their channels."""
        counts = Counter((_stems(t.truth), _stems(t.found) if t.found else t.verdict) for t in self.trials)
        return dict(counts)

    def write(self, folder: Path) -> None:
        """Write `bench_diagnosis.csv`, `confusion.csv` and each trial in `trials.csv`."""
        import pandas as pd

        folder.mkdir(parents=True, exist_ok=True)
        pd.DataFrame(self.table()).to_csv(folder / "bench_diagnosis.csv", index=False)
        confusion = [{"hidden": a, "said": b, "runs": n} for (a, b), n in sorted(self.confusion().items())]
        pd.DataFrame(confusion).to_csv(folder / "confusion.csv", index=False)
        pd.DataFrame([vars(t) for t in self.trials]).to_csv(folder / "trials.csv", index=False)


_WORDS = ("adequate", "named", "ambiguous", "unknown")


def bench_diagnosis(
    counts: dict[str, int] | None = None,
    seed: int = 0,
    jobs: int = 1,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> Bench:
    """Run trials of every kind.

    Parameters
    ----------
    counts : trials by kind; default the full counts
    seed : of all random choices; a fresh one gives fresh trials
    jobs : processes
    progress : told how many trials are done, of how many
    """
    chosen = FULL if counts is None else counts
    tasks = [(kind, seed, i) for kind, count in chosen.items() for i in range(count)]
    trials: list[Trial] = []
    if jobs == 1:
        for task in tasks:
            trials.append(_trial(task))
            progress(len(trials), len(tasks))
    else:
        with ProcessPoolExecutor(jobs) as pool:
            for trial in pool.map(_trial, tasks):
                trials.append(trial)
                progress(len(trials), len(tasks))
    return Bench(tuple(trials))


def drawn(kind: Kind, random: np.random.Generator) -> dict[str, float]:
    """Draw hidden effects with their strengths in SI."""
    pool = [name for name, effect in EFFECTS.items() if effect.known == kind.known]
    effects: dict[str, float] = {}
    while len(effects) < kind.effects:
        name = str(random.choice(pool))
        effect = EFFECTS[name]
        stems = {stem.partition(":")[0] for stem in effects}
        # Both together are one: their product is all that shows.
        twins = {"expansion_coefficient", "elongation_scale"}
        if name in stems or (name in twins and stems & twins):
            continue
        places = (*CHANNELS, "elongation") if name == "sensor_offset" else CHANNELS
        channel = f":{random.choice(places)}" if effect.per_channel else ""
        sign = random.choice([-1, 1]) if effect.both_signs else 1
        away = (effect.size - effect.neutral) * random.uniform(0.7, 1.3) * sign
        effects[name + channel] = float(effect.neutral + away)
    return effects


def weakened(effects: dict[str, float], kind: Kind, random: np.random.Generator) -> dict[str, float]:
    """Scale a single effect so that its expected gain in chi-square lies between 15 and 40.

    The gain grows with the square of a small effect, and is taken from noiseless runs on the rows that a
    diagnosis fits, every channel counted with its noise.
    """
    ((name, size),) = effects.items()
    neutral = effect_of(name).neutral
    quiet = Noise(1e-12, 1e-18)
    without = hide({}, kind.duty, quiet)
    small = neutral + 0.05 * (size - neutral)
    with_it = hide({name: small}, kind.duty, quiet)
    rows = slice(0, int(0.7 * without["time [s]"].size))
    chi2 = 0.0
    for header in list(without)[5:]:
        sigma = kind.noise.elongation * 1e6 if "elongation" in header else kind.noise.temperature
        chi2 += float(np.sum(((with_it[header] - without[header])[rows] / sigma) ** 2))
    wanted = random.uniform(15, 40)
    return {name: neutral + (small - neutral) * float(np.sqrt(wanted / chi2))}


def _trial(task: tuple[str, int, int]) -> Trial:
    from warmlink.orchestration.diagnosis.gain import Scores, scales_of
    from warmlink.orchestration.diagnosis.verdict import assess, names

    kind_name, seed, i = task
    kind = KINDS[kind_name]
    random = np.random.default_rng([seed, i, list(KINDS).index(kind_name)])
    effects = drawn(kind, random)
    if kind.weak:
        effects = weakened(effects, kind, random)
    experiment = _written_and_read(hide(effects, kind.duty, kind.noise, seed=int(random.integers(2**31))))
    began = time.process_time()
    found = assess(experiment)
    seconds = time.process_time() - began
    truth = "+".join(sorted(effects))
    said = names([found.best, *found.rivals]) if found.word in ("named", "ambiguous") else []
    if kind.effects == 0:
        right = found.word == "adequate"
    else:
        right = truth in said if kind.known else found.word == "unknown"
    heldout = None
    if found.word == "named":
        scores = Scores(experiment, scales_of(found.noise, found.problem))
        measured = scores.rmse(scores.predict(found.best), True)
        heldout = None if measured is None else measured[0]
    return Trial(
        kind_name,
        tuple(sorted(effects)),
        found.word,
        tuple(sorted(found.best.key)) if said else (),
        right,
        found.word == "named" and not right,
        _covered(found, effects),
        heldout,
        _followed(found, experiment, effects, int(random.integers(2**31))) if kind.known else None,
        seconds,
    )


def _followed(found: Assessment, experiment: Experiment, effects: dict[str, float], seed: int) -> bool | None:
    """Carry the next experiment out on the truth, and see whether that names it."""
    from warmlink.orchestration.diagnosis.next_experiment import next_experiment
    from warmlink.orchestration.diagnosis.verdict import assess

    if found.word != "ambiguous":
        return None
    proposed = next_experiment(found.fitter, found.best, found.rivals, experiment)
    if proposed is None or not proposed.duty:
        return None
    duty = [
        Segment(s.duration_s, s.speed, s.torque, s.pad_temperature, s.ambient_temperature)
        for s in proposed.duty
    ]
    again = assess(_written_and_read(hide(effects, duty, seed=seed)))
    twins = {"expansion_coefficient", "elongation_scale"}
    if again.word == "ambiguous" and set(effects) & twins:
        return set(effects) in [set(fit.key) for fit in (again.best, *again.rivals)]
    return again.word == "named" and again.best.key == set(effects)


def _written_and_read(columns: dict[str, Any]) -> Experiment:
    from warmlink.orchestration.diagnosis.experiment import read_experiment

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "run.csv"
        write_csv(columns, path)
        return read_experiment(path)


def _covered(found: Assessment, effects: dict[str, float]) -> tuple[bool, ...]:
    """Whether each hidden strength lies in its interval; empty where another model was best."""
    if found.best.key != set(effects):
        return ()
    fit = found.best
    deviations = np.sqrt(np.diag(fit.covariance()))
    result = []
    for freed, value, deviation in zip(fit.freed, fit.theta, deviations, strict=True):
        item = next((i for i in fit.items if freed in i.freed), None)
        if item is None:
            continue
        truth = effects[item.name]
        if item.cause.relative:
            truth *= freed.start
        elif item.name.endswith(":elongation"):
            truth *= 1e-5  # the strength of an offset is told in K; the camera's is 10 um a K
        result.append(bool(abs(value - truth) < 1.96 * deviation))
    return tuple(result)


def _percent(values: Iterable[bool]) -> float | None:
    counted = list(values)
    return 100.0 * sum(counted) / len(counted) if counted else None


def _stems(names: Sequence[str]) -> str:
    return " + ".join(sorted(name.partition(":")[0] for name in names)) or "nothing"
