"""How often a missing term becomes the right equation: fresh runs with heat by laws outside the catalogue."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from benchmarks.command import start
from benchmarks.hidden_effects import KNOWN, drawn_duty, over_a_decade
from warmlink.fmus.errors import InputError
from warmlink.orchestration.console import answer, answer_json, print_table
from warmlink.orchestration.diagnosis.answer.diagnosis import Diagnosis
from warmlink.orchestration.diagnosis.data.experiment import read_experiment
from warmlink.orchestration.diagnosis.diagnose import diagnose_experiment
from warmlink.orchestration.diagnosis.practice.hidden_terms import hidden_term
from warmlink.orchestration.diagnosis.practice.hide import INFORMATIVE, REAL, WHITE, hide, write_csv
from warmlink.orchestration.diagnosis.terms.discovery import Discovery
from warmlink.orchestration.diagnosis.terms.equation import searched
from warmlink.orchestration.diagnosis.terms.gates import foretold
from warmlink.orchestration.diagnosis.terms.library import FORMS, Candidate
from warmlink.orchestration.diagnosis.terms.modelled import Chosen, fitted
from warmlink.orchestration.progress import progress_bar
from warmlink.orchestration.scenarios.duties.duty import Segment

WEAKEST, STRONGEST = 0.6, 6.0
"""W, about the largest heat of a hidden term: strengths are drawn evenly by their logarithm between them."""


@dataclass(frozen=True)
class Law:
    """A law that is hidden: the form of the library that it is, where it enters, and values of its numbers.

    `heat` is about 1 W at most, at speeds and temperatures that are usual in a run; its numbers are drawn
    between bounds.
    """

    heat: str
    about: str
    into: str = "shaft"
    numbers: tuple[tuple[str, float, float], ...] = ()

    def drawn(self, random: np.random.Generator, strength: float) -> tuple[str, dict[str, float]]:
        """The term as `hide` takes it, and its numbers."""
        values = {name: float(random.uniform(low, high)) for name, low, high in self.numbers}
        told = "".join(f"; {name} = {value!r}" for name, value in values.items())
        return f"{self.into}: {strength!r} * ({self.heat}){told}", values


LAWS: dict[str, Law] = {
    "T^4 to second surroundings": Law(
        "((b / 300)**4 - (shaft_temperature / 300)**4) / 0.3",
        "radiation to second surroundings",
        numbers=(("b", 280.0, 290.0),),
    ),
    "speed^1.5": Law("(speed / 4)**1.5", "speed to the power 1.5"),
    "dead zone": Law("max(speed - b, 0) / 3", "speed above a dead zone", numbers=(("b", 0.7, 2.5),)),
    "stick at low speed": Law(
        "speed * exp(-speed / b) / 0.37 / b", "stick at low speed", numbers=(("b", 0.5, 1.2),)
    ),
    "heat on a change of speed": Law(
        "abs(speed - lag(speed, tau)) / 4", "change of speed", numbers=(("tau", 100.0, 500.0),)
    ),
    "one-sided seal": Law(
        "speed * max(b - shaft_temperature, 0) / 20",
        "friction of a seal that is tight when cold",
        numbers=(("b", 300.0, 306.0),),
    ),
    "thermostat of a neighbour": Law(
        "step(b - ambient_temperature)",
        "switched on by cold surroundings",
        into="base",
        numbers=(("b", 295.0, 295.5),),
    ),
    "running-in memory": Law(
        "speed * (1 - lag(step(speed - 0.05), tau)) / 4",
        "friction that runs in",
        numbers=(("tau", 600.0, 2000.0),),
    ),
    "memory of speed": Law("lag(speed, tau) / 3", "memory of speed", numbers=(("tau", 800.0, 2500.0),)),
}
"""Laws outside the catalogue."""


@dataclass(frozen=True)
class TermTrial:
    """One hidden truth and what was said of it.

    Attributes
    ----------
    kind, number, seed : the law, or "nothing" or "a catalogue cause", and what the random choices follow from
    hidden : what was hidden
    verdict : by causes
    finding : of the search for an equation
    said : forms and places of the equations that were found, or why there is none
    outcome : right form, right set, none, catalogue, or wrong; for runs without a term nothing or invented
    ratio : held-out error over that of the true form fitted alike, where the form is right
    seconds : processor time
    """

    kind: str
    number: int
    seed: int
    hidden: str
    verdict: str
    finding: str
    said: str
    outcome: str
    ratio: float | None
    seconds: float


def trial(kind: str, number: int, seed: int) -> TermTrial:
    """Hide a law of a kind, or a cause, or nothing, and say what is made of it."""
    begun = time.process_time()
    random = np.random.default_rng([seed, number, *kind.encode()])
    duty: tuple[Segment, ...] = INFORMATIVE if number % 3 == 0 else drawn_duty(random, 7200.0)
    noise = REAL if number % 2 else WHITE
    effects: dict[str, float] = {}
    told, values = "", dict[str, float]()
    if kind in LAWS:
        strength = WEAKEST * (STRONGEST / WEAKEST) ** float(random.random())
        told, values = LAWS[kind].drawn(random, strength)
    elif kind != "nothing":
        effects = over_a_decade(KNOWN[int(random.integers(len(KNOWN)))], random)
    terms = [hidden_term(told)] if told else []
    columns = hide(effects, duty, noise, seed=int(random.integers(1 << 30)), terms=terms)
    with tempfile.TemporaryDirectory() as folder:
        write_csv(columns, Path(folder) / "run.csv")
        diagnosis = diagnose_experiment(read_experiment(Path(folder) / "run.csv"))
    found = searched(diagnosis)
    outcome = _outcome(kind, found, diagnosis)
    ratio = _ratio(kind, found, diagnosis, values) if outcome in ("right form", "right set") else None
    seconds = time.process_time() - begun
    hidden = told or ", ".join(f"{name} = {size:.4g}" for name, size in effects.items()) or "nothing"
    said = _said(found)
    return TermTrial(
        kind, number, seed, hidden, diagnosis.verdict, found.finding, said, outcome, ratio, seconds
    )


def _said(found: Discovery) -> str:
    equations = (
        " + ".join(f"{c.form.about} at the {c.place}" for c in each.model.chosen.candidates)
        for each in found.members
    )
    return " | ".join([*equations, *found.causes]) or found.because


def _outcome(kind: str, found: Discovery, diagnosis: Diagnosis) -> str:
    if kind not in LAWS:
        return "invented" if found.extends else "set with the causes" if found.found else "nothing"
    law = LAWS[kind]
    right = frozenset({(law.about, law.into)})
    if found.found:
        there = any(each.model.chosen.key == right for each in found.members)
        if not there:
            return "wrong" if found.finding == "equation" else "wrong set"
        return "right form" if found.finding == "equation" else "right set"
    if found.finding == "catalogue":
        return "wrong cause" if diagnosis.verdict == "named" else "catalogue set"
    return "adequate" if diagnosis.verdict == "adequate" else "none"


def _ratio(kind: str, found: Discovery, diagnosis: Diagnosis, values: dict[str, float]) -> float | None:
    """Held-out error of the best member over that of the true form with its true numbers as a start."""
    law = LAWS[kind]
    ours = found.foretold[0].held_out if found.foretold else None
    if ours is None:
        return None
    form = next(each for each in FORMS if each.about == law.about).at(law.into)
    shape = tuple(values[each.name] for each in form.shapes)
    chosen = Chosen((Candidate(form, law.into, shape),), (1.0,), (1.0,))
    model = fitted(diagnosis.assessment, chosen)
    true = foretold(model, diagnosis.experiment, diagnosis.scores, diagnosis.assessment.fitter.wander)
    return None if true.held_out is None else ours.in_noise / true.held_out.in_noise


def bench(count: int, sound: int, seed: int) -> Iterator[TermTrial]:
    """Trials of all laws in turn, and with them runs without a term: nothing, or a catalogue cause."""
    kinds = list(LAWS)
    tasks = [(kinds[i % len(kinds)], i // len(kinds)) for i in range(count)]
    tasks += [("nothing" if i % 4 == 0 else "a catalogue cause", i) for i in range(sound)]
    order = sorted(range(len(tasks)), key=lambda i: i / count if i < count else (i - count) / max(sound, 1))
    for i in order:
        yield trial(*tasks[i], seed)


def main(
    count: Annotated[int, typer.Option(help="Runs with a hidden term.")] = 60,
    sound: Annotated[int, typer.Option(help="Runs with nothing hidden, or a cause of the catalogue.")] = 200,
    seed: Annotated[int, typer.Option(help="Seed of all random choices; another one gives fresh runs.")] = 0,
    out: Annotated[Path, typer.Option(help="File for every trial, written as it ends.")] = Path(
        "out/bench_terms.csv"
    ),
    json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Hide heat by equations in fresh runs, and count how often the right one is found."""
    import pandas as pd

    if count < 0 or sound < 0 or count + sound == 0:
        raise InputError(f"--count {count} --sound {sound}: no runs; give a number above 0")
    out.parent.mkdir(parents=True, exist_ok=True)
    trials: list[TermTrial] = []
    with progress_bar("Hidden terms") as progress:
        for each in bench(count, sound, seed):
            trials.append(each)
            pd.DataFrame([vars(t) for t in trials]).to_csv(out, index=False)
            progress(len(trials) / (count + sound))
    rows = table(trials)
    if json:
        answer_json(rows)
        return
    print_table("", tuple(rows[0]), [tuple(map(str, row.values())) for row in rows], texts=1, width=160)
    answer(f"seed {seed}; every trial in {out}")


def table(trials: list[TermTrial]) -> list[dict[str, Any]]:
    """Numbers of runs by kind and outcome, and the largest ratio of held-out errors."""
    outcomes = list(dict.fromkeys(each.outcome for each in trials))
    rows = []
    for kind in dict.fromkeys(each.kind for each in trials):
        own = [each for each in trials if each.kind == kind]
        ratios = [each.ratio for each in own if each.ratio is not None]
        counts = {word: sum(each.outcome == word for each in own) for word in outcomes}
        worst = f"{max(ratios):.3g}" if ratios else "-"
        rows.append({"hidden": kind, "runs": len(own), **counts, "largest held-out ratio": worst})
    return rows


if __name__ == "__main__":
    start(main)
