"""What a diagnosis delivers of machines of other structure, judged on duty cycles that it never saw.

Each machine has a seed. An owner's log, or three, are diagnosed as they are, and nothing else is known. The
growth is told from inputs alone, from the temperatures at the start of each run, and counts from there. Duty
cycles that may be logs are never judged, so that one log and three are judged on the same ones.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated

import numpy as np
import typer

from benchmarks.command import start
from benchmarks.strange_machine import Machine, duty_cycles, training
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.console import answer

if TYPE_CHECKING:
    import pandas as pd

    from warmlink.orchestration.diagnosis.answer.diagnosis import Diagnosis
    from warmlink.orchestration.diagnosis.data.experiment import Experiment
    from warmlink.orchestration.diagnosis.fit.fitting import Fit
    from warmlink.orchestration.diagnosis.ladder.remainder import Remainder

LOGS = ("training", "random_shift", "slow_heavy")
"""Logs that are diagnosed, the first alone or all three."""

_EVERY = 10
"""Rows of a log, one a second, of which one is read."""

_ZERO = 3
"""Readings of the growth at the start of a run, one a minute, whose mean is taken for 0."""

_CLEARLY = 1.05
"""Ratio of errors from which a model is worse."""


@dataclass(frozen=True)
class Judged:
    """One machine: what was said of it, and how the delivered model does on duty cycles that it never saw.

    `before` and `after` are errors of the growth in um, rms, by duty cycle. `virtual` is the error of a ridge
    on the thermometers at the held-out end of the log over that of the uncorrected model; nan without one.
    """

    seed: int
    verdict: str
    delivered: str
    before: dict[str, float]
    after: dict[str, float]
    virtual: float
    seconds: float

    @property
    def share(self) -> float:
        """Error of the delivered model over that of the uncorrected one, all duty cycles together."""
        before, after = (np.array(list(each.values())) for each in (self.before, self.after))
        return float(np.sqrt(np.mean(after**2) / np.mean(before**2)))


def log_of(machine: Machine, name: str, seed: int) -> pd.DataFrame:
    """What the owner has of one duty cycle of a machine."""
    every = duty_cycles(seed)
    if name == "training":
        return machine.run(training(), 1000 * seed).log().iloc[::_EVERY]
    demands, room = every[name]
    return machine.run(demands, 1000 * seed + 1 + list(every).index(name), room).log().iloc[::_EVERY]


def trial(task: tuple[int, int]) -> Judged:
    """Diagnose the logs of a machine, given its seed and how many logs there are."""
    from warmlink.orchestration.diagnosis.answer.ladder import rows_of
    from warmlink.orchestration.diagnosis.diagnose import diagnose_experiment, read
    from warmlink.orchestration.threads import one_thread

    seed, count = task
    machine = Machine(seed)
    logs = [log_of(machine, name, seed).drop(columns="growth [um]") for name in LOGS[:count]]
    began = time.process_time()
    found = diagnose_experiment(read(logs))
    with one_thread():
        delivered = found.delivered if found.delivers else "nothing"
        rows = {row.channel: row.errors for row in rows_of(found)}
        seconds = time.process_time() - began
        before, after = _unseen(found, machine, seed)
    growth = next((errors for name, errors in rows.items() if name.startswith("elongation")), {})
    virtual = growth.get("ridge", float("nan")) / growth.get("uncorrected", float("nan"))
    return Judged(seed, found.verdict, delivered, before, after, virtual, seconds)


def _unseen(found: Diagnosis, machine: Machine, seed: int) -> tuple[dict[str, float], dict[str, float]]:
    """Errors of the growth in um by unseen duty cycle, of the uncorrected model and the delivered one."""
    from warmlink.orchestration.diagnosis.data.experiment import together
    from warmlink.orchestration.diagnosis.diagnose import read
    from warmlink.orchestration.diagnosis.fit.fitted import Carried
    from warmlink.orchestration.diagnosis.fit.problem import Problem
    from warmlink.orchestration.diagnosis.ladder.signals import growth_output

    def run(name: str) -> Experiment:
        experiment = read([log_of(machine, name, seed).drop(columns="growth [um]")])
        whole = replace(experiment.runs[0], name=name, heldout=True)
        return replace(experiment, runs=(whole,), initial_measured=True)

    names = [name for name in duty_cycles(seed) if name not in (*LOGS, "overnight")]
    problem = Problem(together([run(name) for name in names]))
    channel = problem.variables.index(growth_output(problem))

    def errors(fit: Fit, learnt: Remainder | None) -> dict[str, float]:
        readings = [problem.finest(i, z) for i, z in enumerate(Carried(problem, fit).values)]
        told = readings if learnt is None else learnt.corrected(problem, readings)
        pairs = zip(names, problem.data, told, strict=True)
        return {name: growth_error(data.readings[:, channel], each[:, channel]) for name, data, each in pairs}

    return errors(found.before.fit, None), errors(found.handed_on.fit, found.delivery.remainder)


def growth_error(measured: Array, told: Array) -> float:
    """Error in um, rms, of growth in m that counts from the start of a run."""
    error = measured - told
    error = error[np.isfinite(error)]
    return float(1e6 * np.sqrt(np.mean((error - error[:_ZERO].mean()) ** 2)))


def summary(judged: list[Judged], logs: int) -> str:
    """How many models are better than the uncorrected ones, by how much, and how many causes were named."""
    shares = np.array([one.share for one in judged])
    ratios = np.array([after / one.before[name] for one in judged for name, after in one.after.items()])
    virtual = np.array([one.virtual for one in judged])
    named = sum(one.verdict in ("named", "ambiguous") for one in judged)
    return (
        f"{len(judged)} machines, seeds {judged[0].seed} to {judged[-1].seed}, logs of each: {logs}\n"
        f"better than uncorrected {np.sum(shares < 1)}, worse by more than 5 % {np.sum(shares > _CLEARLY)}\n"
        f"share of the uncorrected: median {np.median(shares):.2f} of machines, {np.median(ratios):.2f} of "
        f"their duty cycles\n"
        f"as virtual measurement at the log's end: median {np.nanmedian(virtual):.2f}\n"
        f"wrong names {named}: no cause of the catalogue is what these machines lack"
    )


def main(
    machines: Annotated[int, typer.Option(help="How many machines, with seeds from the first on.")] = 10,
    seed: Annotated[int, typer.Option(help="Seed of the first machine.")] = 1,
    logs: Annotated[int, typer.Option(help="Logs of each machine that are diagnosed.", min=1, max=3)] = 1,
) -> None:
    """Diagnose machines of other structure, and judge what is delivered on unseen duty cycles."""
    judged = []
    for each in range(seed, seed + machines):
        one = trial((each, logs))
        judged.append(one)
        errors = ", ".join(
            f"{name} {one.before[name]:.3g} to {after:.3g}" for name, after in one.after.items()
        )
        answer(
            f"seed {each}: {one.verdict}, {one.delivered} delivered; unseen duty cycles {one.share:.2f} of "
            f"the uncorrected; {one.seconds:.0f} s; um: {errors}"
        )
    answer(summary(judged, logs))


if __name__ == "__main__":
    start(main)
