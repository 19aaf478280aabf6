"""Logs with damage of every day: what `--check` says of each, and whether a wrong cause is named."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, TypeAlias

import numpy as np
import pandas as pd
import typer

from benchmarks.command import start
from warmlink.fmus.errors import InputError
from warmlink.orchestration.console import answer
from warmlink.orchestration.diagnosis.answer.doubtful import before_diagnosis
from warmlink.orchestration.diagnosis.answer.slips import slips
from warmlink.orchestration.diagnosis.diagnose import diagnose_experiment, read
from warmlink.orchestration.diagnosis.practice.hide import hide, write_csv

Log: TypeAlias = pd.DataFrame
Damage = Callable[[Log, np.random.Generator], None]

TEMPERATURES = [f"{name}_temperature [degC]" for name in ("shaft", "winding", "base", "middle", "tip")]
READ = [*TEMPERATURES, "elongation [um]"]
HOUR = 3600.0


def spikes(log: Log, random: np.random.Generator) -> None:
    """One reading of a hundred leaps by 2 to 40 K, or micrometres, in every column."""
    for name in READ:
        rows = random.random(len(log)) < 0.01
        log.loc[rows, name] += random.choice([-1, 1], rows.sum()) * random.uniform(2, 40, rows.sum())


def small_spikes(log: Log, random: np.random.Generator) -> None:
    """Three readings of a hundred leap by 3 to 6 times the noise."""
    for name in READ:
        rows, noise = random.random(len(log)) < 0.03, 0.4 if "um" in name else 0.08
        log.loc[rows, name] += random.choice([-1, 1], rows.sum()) * noise * random.uniform(3, 6, rows.sum())


def bursts(log: Log, random: np.random.Generator) -> None:
    """A loose contact: ten stretches of 4 to 12 rows in which the base reads up to 20 K off, at random."""
    for first in random.integers(20, len(log) - 20, 10):
        rows = slice(first, first + random.integers(4, 13))
        values = log["base_temperature [degC]"].to_numpy(copy=True)
        values[rows] += random.uniform(-20, 20, values[rows].size)
        log["base_temperature [degC]"] = values


def _over(log: Log, seconds: float, random: np.random.Generator) -> pd.Series:
    begin = random.uniform(600, float(log["time [s]"].iloc[-1]) * 0.7 - seconds)
    return log["time [s]"].between(begin, begin + seconds)


def stuck(name: str) -> Damage:
    """A reading stays as it is for an hour."""

    def damage(log: Log, random: np.random.Generator) -> None:
        rows = _over(log, HOUR, random)
        log.loc[rows, name] = log.loc[rows, name].iloc[0]

    return damage


def dead(name: str, value: float) -> Damage:
    """A sensor reads the same value throughout."""

    def damage(log: Log, random: np.random.Generator) -> None:
        log[name] = value

    return damage


def zero_rows(log: Log, random: np.random.Generator) -> None:
    """Every column is 0 in three rows of a hundred."""
    log.loc[random.random(len(log)) < 0.03, [c for c in log.columns if c != "time [s]"]] = 0.0


def zero_readings(log: Log, random: np.random.Generator) -> None:
    """The tip reads 0 for ten minutes."""
    log.loc[_over(log, 600, random), "tip_temperature [degC]"] = 0.0


def open_circuit(log: Log, random: np.random.Generator) -> None:
    """The middle's thermometer is open for six minutes and reads 850 degC."""
    log.loc[_over(log, 360, random), "middle_temperature [degC]"] = 850.0


def dropout(log: Log, random: np.random.Generator) -> None:
    """Nothing is read for twenty minutes, and one cell of five is empty."""
    log.loc[_over(log, 1200, random), READ] = np.nan
    for name in READ:
        log.loc[random.random(len(log)) < 0.2, name] = np.nan


def fast_clock(log: Log, random: np.random.Generator) -> None:
    """The readings' logger runs 2 % fast: what it saw comes ever later in the common table."""
    _by_other_clock(log, 0.0, 0.02)


def late_clock(log: Log, random: np.random.Generator) -> None:
    """The readings' logger is 90 s late."""
    _by_other_clock(log, 90.0, 0.0)


def _by_other_clock(log: Log, late: float, drift: float) -> None:
    time = log["time [s]"].to_numpy()
    for name in READ:
        log[name] = np.interp(time / (1 + drift) - late, time, log[name].to_numpy())


def swapped(log: Log, random: np.random.Generator) -> None:
    """Base and tip are exchanged."""
    one, two = "base_temperature [degC]", "tip_temperature [degC]"
    log[one], log[two] = log[two].copy(), log[one].copy()


def fahrenheit(log: Log, random: np.random.Generator) -> None:
    """The base is in degF under a header in degC."""
    log["base_temperature [degC]"] = log["base_temperature [degC]"] * 1.8 + 32


def millimetres(log: Log, random: np.random.Generator) -> None:
    """The growth is in mm under a header in um."""
    log["elongation [um]"] /= 1000


def rpm(log: Log, random: np.random.Generator) -> None:
    """The speed is in rpm under a header in rad/s."""
    log["speed [rad/s]"] *= 60 / (2 * np.pi)


def reversed_growth(log: Log, random: np.random.Generator) -> None:
    """The growth has the other sign."""
    log["elongation [um]"] *= -1


def step_of_offset(log: Log, random: np.random.Generator) -> None:
    """A connector is moved: the base reads 1.5 K more from some time on."""
    rows = log["time [s]"] > random.uniform(0.3, 0.5) * log["time [s]"].iloc[-1]
    log.loc[rows, "base_temperature [degC]"] += 1.5


def nothing(log: Log, random: np.random.Generator) -> None:
    """Nothing is damaged."""


KINDS: Mapping[str, tuple[Damage, str, str]] = {
    "nothing": (nothing, "", ""),
    "spikes": (spikes, "leaps away", ""),
    "small spikes": (small_spikes, "", ""),
    "bursts": (bursts, "base_temperature", ""),
    "stuck base": (stuck("base_temperature [degC]"), "base_temperature", ""),
    "stuck winding": (stuck("winding_temperature [degC]"), "winding_temperature", ""),
    "stuck growth": (stuck("elongation [um]"), "elongation", ""),
    "dead at zero": (dead("tip_temperature [degC]", 0.0), "tip_temperature", ""),
    "dead at room": (dead("middle_temperature [degC]", 22.3), "middle_temperature", ""),
    "zero rows": (zero_rows, "zeros", ""),
    "zero readings": (zero_readings, "tip_temperature", ""),
    "open circuit": (open_circuit, "middle_temperature", ""),
    "dropout": (dropout, "nothing was read", ""),
    "clock 2 % fast": (fast_clock, "clock", "clock"),
    "clock 90 s late": (late_clock, "clock", "clock"),
    "swapped": (swapped, "swapped", ""),
    "degF": (fahrenheit, "degF", ""),
    "mm": (millimetres, "mm", ""),
    "rpm": (rpm, "rpm", ""),
    "reversed growth": (reversed_growth, "sign", ""),
    "connector moved": (step_of_offset, "base_temperature", ""),
}
"""Kinds of damage by name: what makes it, a word that `--check` should say, and a word of a right cause."""


def said_by_check(source: Path) -> list[str]:
    """Sentences of `--check` on a log, or the one that refuses it."""
    try:
        experiment = read([source])
        return [*slips(experiment).certain, *before_diagnosis(experiment), *experiment.remarks]
    except InputError as fault:
        return [str(fault)]


def found_in(source: Path) -> Iterator[str]:
    """Verdict on a log, the causes that are named, and what is to be looked at first."""
    try:
        found = diagnose_experiment(read([source]))
    except InputError as fault:
        yield f"refused: {fault}"
        return
    yield found.verdict
    yield "+".join(each.title for each in found.causes)
    yield from (*found.slips, *found.doubts)


def main(
    seed: Annotated[int, typer.Option(help="Of the logs.")] = 1,
    only: Annotated[str, typer.Option(help="Kinds of damage whose name contains this.")] = "",
    effect: Annotated[str, typer.Option(help="Hidden in each log, as joint_resistance=0.3.")] = "",
) -> None:
    """Damage a log of the warm-up cell in every way, check it, and diagnose it."""
    name, _, size = effect.partition("=")
    for number, (kind, (damage, word, right)) in enumerate(KINDS.items()):
        if only not in kind:
            continue
        log = pd.DataFrame(hide({name: float(size)} if name else {}, seed=seed + 100 * number))
        damage(log, np.random.default_rng([seed, number]))
        with TemporaryDirectory() as folder:
            path = Path(folder) / "run.csv"
            write_csv({column: log[column].to_numpy() for column in log}, path)
            told = said_by_check(path)
            verdict, *rest = found_in(path)
        causes = rest[0] if rest else ""
        wrong = verdict == "named" and not (right and right in causes) and causes != name
        shown = "shown" if any(word in each for each in told) else "NOT SHOWN"
        answer(f"{kind}: {verdict[:150]} {causes} {'WRONG' if wrong else ''}; {shown}")
        for each in told:
            if word and word in each:
                answer(f"    check: {each[:200]}")
        for each in rest[1:4]:
            answer(f"    first: {each[:200]}")


if __name__ == "__main__":
    start(main)
