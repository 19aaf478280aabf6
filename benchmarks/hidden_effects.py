"""The kinds of runs on which the diagnosis is tried: effects, duty cycles and logs, drawn afresh."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

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
)
from warmlink.orchestration.scenarios.duties.duty import PAD_TEMPERATURE, Segment, length

TWINS = {"expansion_coefficient", "elongation_scale"}
"""Their product is all that shows."""

JOINT = {"joint_conductance", "joint_resistance"}
"""Their sum is all that shows, as resistances."""

KNOWN = tuple(name for name, effect in EFFECTS.items() if not effect.about)
"""Effects that a cause of the catalogue explains."""


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


def drawn(kind: Kind, random: np.random.Generator) -> dict[str, float]:
    """Draw hidden effects with their strengths in SI."""
    pool = [name for name in EFFECTS if (name in KNOWN) == kind.known]
    effects: dict[str, float] = {}
    while len(effects) < kind.effects:
        name = str(random.choice(pool))
        effect = EFFECTS[name]
        stems = {stem.partition(":")[0] for stem in effects}
        # Two that are one together: nobody can tell what each is.
        if name in stems or any(name in pair and stems & pair for pair in (TWINS, JOINT)):
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
    spared |= {"elongation"} if {"camera_drift", *TWINS} & set(effects) else set()
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
