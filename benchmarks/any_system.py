"""How often causes hidden in a stranger's systems are found: two links, and a foreign spindle on a column."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated

import numpy as np
import typer

from benchmarks.command import start
from benchmarks.own_systems import (
    CHANNELS,
    INPUTS,
    MACHINE_COLUMNS,
    chain,
    experiment,
    machine,
    measured,
    spindle,
    with_values,
    write_csv,
)
from warmlink.orchestration.console import answer
from warmlink.orchestration.diagnosis.causes.declared import read_causes
from warmlink.orchestration.diagnosis.diagnose import diagnose_experiment, read
from warmlink.orchestration.machine.heat_paths import with_paths
from warmlink.orchestration.system.model import System

PATH = """
[[cause]]
name = "{name}"
sentence = "Heat flows where the model has no path."
check = "Put a thermometer there."
adds = {{ conductance = "W/K", from = "{giver}", to = "{to}", into = "{into}" }}
between = ["0 W/K", "5 W/K"]
"""
FREES = """
[[cause]]
name = "{name}"
sentence = "A parameter differs."
check = "Measure it."
frees = ["{variable}"]
between = [{lower}, {upper}]
"""
CHAIN_CAUSES = PATH.format(
    name="flange", giver="motor1.shaft_temperature", to="link2.base_temperature", into="link2.heat_flow"
)
SPINDLE_CAUSES = (
    PATH.format(
        name="coolant", giver="spindle.temperature", to="column.tip_temperature", into="column.tip_heat_flow"
    )
    + FREES.format(name="preload", variable="spindle.friction", lower=0.2, upper=20)
    + FREES.format(name="housing", variable="spindle.loss", lower=0.0, upper=5)
    + FREES.format(name="mass", variable="spindle.capacity", lower=300, upper=3000)
    + FREES.format(name="seat", variable="spindle.flange", lower=0.2, upper=10)
)


@dataclass(frozen=True)
class Kind:
    """A hidden effect: where, in which range (log-uniform), and what should be said of it.

    Attributes
    ----------
    hidden : cause or instance, and variable of the system with all heat paths
    low, high : strength in SI
    right : title of the cause, or the verdict where none should be named
    told : causes that the experiment declares
    """

    foreign: bool
    hidden: tuple[str, str]
    low: float
    high: float
    right: str
    told: str
    columns: Mapping[str, str]


KINDS = {
    "path": Kind(False, ("flange", "conductance"), 0.03, 1.0, "flange", CHAIN_CAUSES, {**INPUTS, **CHANNELS}),
    "parameter": Kind(
        False, ("link2", "emissivity"), 0.05, 0.9, "radiation:link2", CHAIN_CAUSES, {**INPUTS, **CHANNELS}
    ),
    "outside": Kind(False, ("flange", "conductance"), 0.1, 1.0, "unknown", "", {**INPUTS, **CHANNELS}),
    "foreign path": Kind(
        True, ("coolant", "conductance"), 0.02, 0.5, "coolant", SPINDLE_CAUSES, MACHINE_COLUMNS
    ),
    "foreign parameter": Kind(
        True, ("spindle", "friction"), 2.1, 4.0, "preload", SPINDLE_CAUSES, MACHINE_COLUMNS
    ),
    "foreign outside": Kind(
        True,
        ("coolant", "conductance"),
        0.05,
        0.5,
        "unknown",
        SPINDLE_CAUSES.partition('[[cause]]\nname = "preload')[2].join(('[[cause]]\nname = "preload', "")),
        MACHINE_COLUMNS,
    ),
}


@dataclass(frozen=True)
class Trial:
    """One run: what was hidden, what was said, and the seconds that it took."""

    kind: str
    strength: float
    verdict: str
    named: str
    right: bool
    wrong: bool
    seconds: float


def trial(kind: str, seed: int, folder: Path, foreign: Callable[[], Path]) -> Trial:
    """Hide an effect of a drawn strength, and diagnose the run."""
    of, random = KINDS[kind], np.random.default_rng(seed)
    strength = float(np.exp(random.uniform(np.log(of.low), np.log(of.high))))
    base: System = machine(foreign()) if of.foreign else chain()
    path = experiment(folder, base, of.columns, SPINDLE_CAUSES if of.foreign else CHAIN_CAUSES)
    changed, _ = with_paths(base, read_causes(folder / "causes.toml").paths)
    truth = with_values(changed, {of.hidden[0]: {of.hidden[1]: strength}})
    write_csv(measured(truth, of.columns, 0.05, seed), folder / "run.csv")
    (folder / "causes.toml").write_text(of.told, "utf-8")
    text = path.read_text("utf-8").replace("shipped = false", "")
    path.write_text(text if of.told else text.replace('file = "causes.toml"', ""), "utf-8")
    begun = time.perf_counter()
    found = diagnose_experiment(read([path]))
    said = " + ".join(sorted(item.title for item in found.causes))
    sets = {title for each in (found.assessment.best, *found.assessment.rivals) for title in [each.name]}
    right = found.verdict == of.right or (found.verdict != "unknown" and of.right in sets)
    wrong = found.verdict == "named" and said != of.right
    return Trial(kind, strength, found.verdict, said, right, wrong, time.perf_counter() - begun)


def main(
    runs: Annotated[int, typer.Option(help="Runs of each kind.")] = 10,
    seed: Annotated[int, typer.Option(help="Seed of all random choices.")] = 0,
    kinds: Annotated[str, typer.Option(help="Kinds, separated by commas. Default: all.")] = ",".join(KINDS),
) -> None:
    """Hide effects of random strength in two systems of a stranger's, and count what the diagnosis says."""
    with TemporaryDirectory() as name:
        fmu: list[Path] = []

        def foreign() -> Path:
            fmu[:] = fmu or [spindle(Path(name))]
            return fmu[0]

        for kind in kinds.split(","):
            done = []
            for i in range(runs):
                done.append(trial(kind, 1000 * seed + i, Path(name), foreign))
                each = done[-1]
                answer(f"  {kind} {each.strength:.3g}: {each.verdict} {each.named} ({each.seconds:.0f} s)")
            right, wrong = sum(t.right for t in done), sum(t.wrong for t in done)
            answer(f"{kind}: right or in the stated set {right} of {runs}, confident wrong name {wrong}")


if __name__ == "__main__":
    start(main)
