"""One trial of the diagnosis: a fresh run with hidden effects, and what was said of it."""

from __future__ import annotations

import tempfile
import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from warmlink.orchestration.diagnosis.practice.effects import CHANNELS, EFFECTS, effect_of
from warmlink.orchestration.diagnosis.practice.hidden import COLD
from warmlink.orchestration.diagnosis.practice.hide import (
    INFORMATIVE,
    MOVING,
    REAL,
    STILL,
    WHITE,
    Noise,
    hide,
    write_csv,
)
from warmlink.orchestration.scenarios.duties.duty import PAD_TEMPERATURE, Segment, length

if TYPE_CHECKING:
    from warmlink.orchestration.diagnosis.data.experiment import Experiment
    from warmlink.orchestration.diagnosis.fit.verdict import Assessment

_TWINS = {"expansion_coefficient", "elongation_scale"}
"""Their product is all that shows."""

KNOWN = tuple(name for name, effect in EFFECTS.items() if effect.known)
"""Effects that a cause of the catalogue explains."""

_VARIED = 7200.0
"""s that a drawn duty cycle lasts, or a little longer."""

_TRACE = 1.0
"""Expected gain in chi-square below which an effect leaves no trace in a run."""


@dataclass(frozen=True)
class Kind:
    """A kind of trial: how many effects are hidden, from where, under which noise and duty cycle.

    `stated` is the noise that the experiment claims as a multiple of the true one, None where it claims
    none; `gaps` takes two measured columns and parts of others away; `varied` draws the duty cycle anew for
    each trial, and the strength over a decade, and takes the causes in turn.
    """

    effects: int
    known: bool = True
    noise: Noise = WHITE
    duty: tuple[Segment, ...] = INFORMATIVE
    weak: bool = False
    stated: float | None = None
    gaps: bool = False
    varied: bool = False


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
    "none, noise called half": Kind(0, stated=0.5),
    "none, noise called twice": Kind(0, stated=2.0),
    "single, noise called half": Kind(1, stated=0.5),
    "single, noise called twice": Kind(1, stated=2.0),
    "none, columns missing and gaps": Kind(0, gaps=True),
    "single, columns missing and gaps": Kind(1, gaps=True),
    "any cause, any duty": Kind(1, gaps=True, varied=True),
}


@dataclass(frozen=True)
class Trial:
    """One hidden truth and what was said of it.

    Attributes
    ----------
    number : of the trial within its kind, from which its random choices follow
    strengths : of the hidden effects in SI, in the order of `truth`
    rivals : the other sets of an ambiguous verdict
    unexplained_p : chance level of what the chosen model leaves
    right : the truth is the verdict, or a member of the stated ambiguous set; `adequate` where the effect
        leaves no trace in the run
    wrong_name : a cause or set was named with confidence that is not the truth
    covered : whether each hidden strength lies in its 95 % interval, where the truth was found best
    heldout : held-out error in units of noise, where the verdict is `named`
    followed : whether the next experiment of an ambiguous verdict, carried out on the truth, leads to the
        right name, both runs diagnosed together; None where none was proposed
    as_said : whether it does, or leaves beside the truth only what the proposal said nothing tells from it
    seconds : processor time of the search
    """

    kind: str
    number: int
    truth: tuple[str, ...]
    strengths: tuple[float, ...]
    verdict: str
    found: tuple[str, ...]
    rivals: tuple[str, ...]
    unexplained_p: float
    right: bool
    wrong_name: bool
    covered: tuple[bool, ...]
    heldout: float | None
    followed: bool | None
    as_said: bool | None
    seconds: float


def drawn(kind: Kind, random: np.random.Generator) -> dict[str, float]:
    """Draw hidden effects with their strengths in SI."""
    pool = [name for name, effect in EFFECTS.items() if effect.known == kind.known]
    effects: dict[str, float] = {}
    while len(effects) < kind.effects:
        name = str(random.choice(pool))
        effect = EFFECTS[name]
        stems = {stem.partition(":")[0] for stem in effects}
        # Both together are one: their product is all that shows.
        if name in stems or (name in _TWINS and stems & _TWINS):
            continue
        places = (*CHANNELS, "elongation") if name == "sensor_offset" else CHANNELS
        channel = f":{random.choice(places)}" if effect.per_channel else ""
        sign = random.choice([-1, 1]) if effect.both_signs else 1
        away = (effect.size - effect.neutral) * random.uniform(0.7, 1.3) * sign
        effects[name + channel] = float(effect.neutral + away)
    return effects


def drawn_duty(random: np.random.Generator, lasts: float) -> tuple[Segment, ...]:
    """Draw a duty cycle of about so many s: rest, work, torque at rest, a pad, in a room that is never still.

    The ambient temperature changes every one or two minutes, so that a logger has it row by row.
    """
    duty: list[Segment] = []
    ambient = COLD
    while length(duty) < lasts:
        heated, moving = random.random(2) < (0.4, 0.6)
        speed, torque = random.uniform((0.5, 0.5), (4.5, 5.0)) if moving else (0.0, random.choice([0.0, 3.5]))
        pad = COLD + random.uniform(10, 45)
        stage = random.uniform(300, 900)
        for share in random.dirichlet(np.full(int(stage / 100) + 1, 5.0)):
            ambient = float(np.clip(ambient + 0.3 * random.standard_normal(), COLD - 2, COLD + 2))
            piece = Segment(max(round(stage * share, 1), 1.0), float(speed), float(torque), ambient)
            held = replace(piece, pad_mode=PAD_TEMPERATURE, pad_temperature=pad)
            duty.append(held if heated else piece)
    return tuple(duty)


def over_a_decade(name: str, random: np.random.Generator) -> dict[str, float]:
    """A cause of the catalogue, on any channel, at a strength drawn over a decade, in SI."""
    effect = EFFECTS[name]
    channel = f":{random.choice(CHANNELS)}" if effect.per_channel else ""
    sign = random.choice([-1, 1]) if effect.both_signs else 1
    share = sign * 10 ** random.uniform(-0.85, 0.15)  # more would lie beyond a cause's bounds
    return {name + channel: float(effect.neutral + share * (effect.size - effect.neutral))}


def weakened(effects: dict[str, float], kind: Kind, random: np.random.Generator) -> dict[str, float]:
    """Scale a single effect so that its expected gain in chi-square lies between 15 and 40.

    The gain grows with the square of a small effect, and is taken from noiseless runs on the rows that a
    diagnosis fits, every channel counted with its noise.
    """
    ((name, size),) = effects.items()
    neutral = effect_of(name).neutral
    small = neutral + 0.05 * (size - neutral)
    wanted = random.uniform(15, 40)
    return {name: neutral + (small - neutral) * float(np.sqrt(wanted / expected_gain({name: small}, kind)))}


def expected_gain(effects: dict[str, float], kind: Kind) -> float:
    """Chi-square between runs without and with effects, on the rows that a diagnosis fits."""
    quiet = Noise(1e-12, 1e-18)
    without, with_it = hide({}, kind.duty, quiet), hide(effects, kind.duty, quiet)
    rows = slice(0, int(0.7 * without["time [s]"].size))
    chi2 = 0.0
    for header in list(without)[5:]:
        sigma = kind.noise.elongation * 1e6 if "elongation" in header else kind.noise.temperature
        chi2 += float(np.sum(((with_it[header] - without[header])[rows] / sigma) ** 2))
    return chi2


def with_gaps(
    columns: dict[str, Any], effects: dict[str, float], random: np.random.Generator
) -> dict[str, Any]:
    """Take away two measured columns, rows while no input changes, and cells: all, one column's, single ones.

    A column that a hidden instrument's effect is in stays. A gap in the rows that hides a change of the
    inputs is left out: nobody can tell then what the machine did.
    """
    spared = {name.partition(":")[2] for name in effects}
    spared |= {"elongation"} if {"camera_drift", *_TWINS} & set(effects) else set()
    inputs, measured = list(columns)[1:5], list(columns)[5:]
    loose = [h for h in measured if h.partition(" ")[0] not in spared]
    gone = set(random.choice(loose, 2, replace=False))
    result = {h: np.array(v) for h, v in columns.items() if h not in gone}
    left = [h for h in measured if h not in gone]
    rows = result["time [s]"].size

    def stretch(share: float) -> slice:
        begin = int(random.integers(1, int((1 - share) * rows)))
        return slice(begin, begin + int(share * rows))

    silent, single = stretch(0.06), stretch(0.12)
    for header in left:
        result[header][silent] = np.nan
    holed = result[str(random.choice(left))]
    holed[single] = np.nan
    holed[random.random(rows) < 0.1] = np.nan
    held = np.ones(rows, dtype=bool)
    for header in inputs:
        values = np.nan_to_num(result[header], nan=-1.0)
        held[1:] &= values[1:] == values[:-1]
    kept = np.ones(rows, dtype=bool)
    kept[stretch(0.05)] = False
    kept |= ~held
    return {h: v[kept] for h, v in result.items()}


def _stated(experiment: Experiment, kind: Kind) -> dict[str, float]:
    """Noise that the experiment claims by variable, SI."""
    factor = kind.stated or 1.0
    return {
        column.variable: factor
        * (kind.noise.elongation if column.name == "elongation" else kind.noise.temperature)
        for column in experiment.columns
    }


def trial(task: tuple[str, int, int]) -> Trial:
    """Carry out one trial, given its kind, the bench's seed and its number."""
    from warmlink.orchestration.diagnosis.answer.gain import Scores
    from warmlink.orchestration.diagnosis.fit.verdict import assess

    kind_name, seed, i = task
    kind = KINDS[kind_name]
    random = np.random.default_rng([seed, i, list(KINDS).index(kind_name)])
    effects = drawn(kind, random)
    if kind.varied:
        effects = over_a_decade(KNOWN[i % len(KNOWN)], random)
        kind = replace(kind, duty=drawn_duty(random, _VARIED))
    if kind.weak:
        effects = weakened(effects, kind, random)
    columns = hide(effects, kind.duty, kind.noise, seed=int(random.integers(2**31)))
    if kind.gaps:
        columns = with_gaps(columns, effects, random)
    experiment = _written_and_read(columns)
    if kind.stated is not None:
        experiment = replace(experiment, noise=_stated(experiment, kind))
    began = time.process_time()
    found = assess(experiment)
    seconds = time.process_time() - began
    truth = "+".join(sorted(effects))
    said = [fit.name for fit in (found.best, *found.rivals)] if found.word in ("named", "ambiguous") else []
    if kind.effects == 0:
        right = found.word == "adequate"
    elif kind.known:
        # What leaves no trace, as forced convection at rest, cannot be wrong.
        right = truth in said or (found.word == "adequate" and expected_gain(effects, kind) < _TRACE)
    else:
        right = found.word == "unknown"
    follow = kind.known and found.word == "ambiguous"
    followed, as_said = (
        _followed(found, experiment, effects, int(random.integers(2**31))) if follow else (None, None)
    )
    heldout = None
    if found.word == "named":
        scores = Scores(experiment, found.noise)
        measured = scores.rmse(scores.predict(found.best), True)
        heldout = None if measured is None else measured[0]
    return Trial(
        kind_name,
        i,
        tuple(sorted(effects)),
        tuple(effects[name] for name in sorted(effects)),
        found.word,
        tuple(sorted(found.best.key)) if said else (),
        tuple(said[1:]),
        found.left.p,
        right,
        found.word == "named" and not right,
        _covered(found, effects),
        heldout,
        followed,
        as_said,
        seconds,
    )


def _followed(
    found: Assessment, experiment: Experiment, effects: dict[str, float], seed: int
) -> tuple[bool | None, bool | None]:
    """Carry the next experiment out on the truth, and diagnose both runs together.

    Whether that names the truth, or says that nothing is wrong; and whether it does, or leaves beside the
    truth only what the proposal said that nothing tells from it. None where there was nothing to carry out.
    """
    from warmlink.orchestration.diagnosis.answer.next_experiment import next_experiment
    from warmlink.orchestration.diagnosis.data.experiment import together
    from warmlink.orchestration.diagnosis.fit.verdict import assess

    proposed = next_experiment(found, experiment)
    if proposed is None or not proposed.duty:
        return None, None
    again = assess(together([experiment, _written_and_read(hide(effects, proposed.duty, seed=seed))]))
    if not effects:
        return again.word == "adequate", again.word == "adequate"
    left = (
        {fit.name for fit in (again.best, *again.rivals)} if again.word in ("named", "ambiguous") else set()
    )
    truth = "+".join(sorted(effects))
    beside = left - {truth}
    right = truth in left and beside <= (_TWINS if set(effects) & _TWINS else set())
    alike = {frozenset(pair) for pair in proposed.alike}
    return right, right or (truth in left and all(frozenset((truth, each)) in alike for each in beside))


def _written_and_read(columns: dict[str, Any]) -> Experiment:
    from warmlink.orchestration.diagnosis.data.experiment import read_experiment

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
