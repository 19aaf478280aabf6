"""Whether FMUs in a loop lead to the verdicts and values that the equations in one piece lead to."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated

import numpy as np
import typer

from benchmarks.command import start
from benchmarks.hidden_effects import KNOWN, drawn_duty, over_a_decade
from warmlink.orchestration.console import answer
from warmlink.orchestration.diagnosis.answer.diagnosis import Diagnosis
from warmlink.orchestration.diagnosis.diagnose import diagnose_experiment, read
from warmlink.orchestration.diagnosis.practice.hide import hide, write_csv

_LASTS, _ROWS = 5400.0, 15.0
"""s that a run lasts, or a little longer, and between its rows."""


@dataclass(frozen=True)
class Trial:
    """A run diagnosed both ways.

    Attributes
    ----------
    hidden : effect
    verdicts : verdict and causes, joined and in a loop
    apart : largest difference of a value of the causes, in standard deviations; None where causes differ
    seconds : that each way took
    """

    hidden: str
    verdicts: tuple[str, str]
    apart: float | None
    seconds: tuple[float, float]

    @property
    def alike(self) -> bool:
        """Whether both say the same, and values are within 0.1 standard deviations."""
        return self.verdicts[0] == self.verdicts[1] and self.apart is not None and self.apart <= 0.1


def trial(seed: int, number: int, folder: Path) -> Trial:
    """Hide an effect in a warm-up cell, and diagnose the run both ways."""
    random = np.random.default_rng([seed, number])
    effects = over_a_decade(KNOWN[int(random.integers(len(KNOWN)))], random)
    columns = hide(effects, drawn_duty(random, _LASTS), interval=_ROWS, seed=int(random.integers(2**31)))
    write_csv(columns, folder / "run.csv")
    found: list[Diagnosis] = []
    seconds: list[float] = []
    for looped in ("false", "true"):
        path = folder / f"looped_{looped}.toml"
        path.write_text(f'system = "WarmupCell"\nin_loop = {looped}\n[[run]]\ndata = "run.csv"\n', "utf-8")
        begun = time.perf_counter()
        found.append(diagnose_experiment(read([path])))
        seconds.append(time.perf_counter() - begun)
    joined, looped_fit = (each.assessment.best for each in found)
    said = tuple(f"{each.verdict} {each.assessment.best.name}" for each in found)
    apart = None
    if joined.key == looped_fit.key:
        deviations = np.sqrt(np.diag(joined.covariance()))
        values = dict(zip((f.key for f in looped_fit.freed), looped_fit.theta, strict=True))
        moved = [values[f.key] - value for f, value in zip(joined.freed, joined.theta, strict=True)]
        apart = float(np.max(np.abs(moved) / deviations, initial=0.0))
    ((hidden, strength),) = effects.items()
    return Trial(f"{hidden} {strength:.3g}", (said[0], said[1]), apart, (seconds[0], seconds[1]))


def main(
    runs: Annotated[int, typer.Option(help="Number of runs.")] = 100,
    seed: Annotated[int, typer.Option(help="Seed of all random choices.")] = 0,
    first: Annotated[int, typer.Option(help="Number of the first run.")] = 0,
) -> None:
    """Diagnose runs of the warm-up cell with our own FMUs treated as foreign, and joined."""
    done: list[Trial] = []
    with TemporaryDirectory() as folder:
        for number in range(first, first + runs):
            done.append(trial(seed, number, Path(folder)))
            each = done[-1]
            apart = "causes differ" if each.apart is None else f"{each.apart:.3f} sd apart"
            answer(
                f"  {each.hidden}: {' | '.join(dict.fromkeys(each.verdicts))}; {apart} "
                f"({each.seconds[0]:.0f} s joined, {each.seconds[1]:.0f} s in the loop)"
            )
            alike = sum(t.alike for t in done)
            verdict = sum(t.verdicts[0] == t.verdicts[1] for t in done)
            answer(f"same verdict {verdict} of {len(done)}, values within 0.1 sd too {alike}")


if __name__ == "__main__":
    start(main)
