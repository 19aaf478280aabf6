"""What a diagnosis delivers of machines of other structure, judged on duty cycles that it never saw.

Each machine has a seed. An owner's log, or three, are diagnosed as they are, and nothing else is known. The
growth is told from inputs alone, from the temperatures at the start of each run, and counts from there; and
as a virtual measurement, from the other thermometers by a ridge on the fitted rows. Duty cycles that may be
logs are never judged, so that one log and three are judged on the same ones.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
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
    from warmlink.orchestration.diagnosis.ladder.signals import Signals

LOGS = ("training", "random_shift", "slow_heavy")
"""Logs that are diagnosed, the first alone or all three."""

_EVERY = 10
"""Rows of a log, one a second, of which one is read."""

_ZERO = 3
"""Readings of the growth at the start of a run, one a minute, whose mean is taken for 0."""

_CLEARLY = 1.05
"""Ratio of errors from which a model is worse."""

_UNTOLD = "hot_workpieces"
"""The duty cycle whose heat no input tells of: what is left there no model can take away."""

Errors = dict[str, float]
"""Of the growth in um, rms, by duty cycle."""


@dataclass(frozen=True)
class Judged:
    """One machine: what was said of it, and how the delivered model does on duty cycles that it never saw.

    `before`, `after` and `virtual` are errors of the uncorrected model, of the delivered one, and of the
    virtual measurement.
    """

    seed: int
    verdict: str
    delivered: str
    before: Errors
    after: Errors
    virtual: Errors
    seconds: float

    @property
    def share(self) -> float:
        """Error of the delivered model over that of the uncorrected one, all duty cycles together."""
        return self._share_of(self.after, list(self.before))

    @property
    def share_of_told(self) -> float:
        """The same where inputs tell of all that gives heat."""
        return self._share_of(self.after, [name for name in self.before if name != _UNTOLD])

    @property
    def virtual_share(self) -> float:
        """Error of the virtual measurement over that of the uncorrected model, all duty cycles together."""
        return self._share_of(self.virtual, list(self.before))

    def _share_of(self, errors: Errors, names: list[str]) -> float:
        over, of = (np.array([each[name] for name in names]) for each in (errors, self.before))
        return float(np.sqrt(np.mean(over**2) / np.mean(of**2)))


def log_of(machine: Machine, name: str, seed: int) -> pd.DataFrame:
    """What the owner has of one duty cycle of a machine."""
    every = duty_cycles(seed)
    if name == "training":
        return machine.run(training(), 1000 * seed).log().iloc[::_EVERY]
    demands, room = every[name]
    return machine.run(demands, 1000 * seed + 1 + list(every).index(name), room).log().iloc[::_EVERY]


def trial(task: tuple[int, int]) -> Judged:
    """Diagnose the logs of a machine, given its seed and how many logs there are."""
    from warmlink.orchestration.diagnosis.diagnose import diagnose_experiment, read
    from warmlink.orchestration.threads import one_thread

    seed, count = task
    machine = Machine(seed)
    logs = [log_of(machine, name, seed).drop(columns="growth [um]") for name in LOGS[:count]]
    began = time.process_time()
    found = diagnose_experiment(read(logs))
    with one_thread():
        delivered = found.delivered if found.delivers else "nothing"
        seconds = time.process_time() - began
        return Judged(seed, found.verdict, delivered, *_unseen(found, machine, seed), seconds)


def _unseen(found: Diagnosis, machine: Machine, seed: int) -> tuple[Errors, Errors, Errors]:
    """Errors in unseen duty cycles: of the uncorrected model, the delivered one, the virtual measurement."""
    from warmlink.orchestration.diagnosis.data.experiment import together
    from warmlink.orchestration.diagnosis.diagnose import read
    from warmlink.orchestration.diagnosis.fit.fitted import Carried
    from warmlink.orchestration.diagnosis.fit.problem import Problem
    from warmlink.orchestration.diagnosis.ladder.signals import growth_output, signals_of

    def run(name: str) -> Experiment:
        experiment = read([log_of(machine, name, seed).drop(columns="growth [um]")])
        whole = replace(experiment.runs[0], name=name, heldout=True)
        return replace(experiment, runs=(whole,), initial_measured=True)

    names = [name for name in duty_cycles(seed) if name not in (*LOGS, "overnight")]
    problem = Problem(together([run(name) for name in names]))
    channel = problem.variables.index(growth_output(problem))

    def told(fit: Fit, learnt: Remainder | None) -> list[Array]:
        readings = [problem.finest(i, z) for i, z in enumerate(Carried(problem, fit).values)]
        readings = readings if learnt is None else list(learnt.corrected(problem, readings))
        return [each[:, channel] for each in readings]

    def errors(courses: Sequence[Array]) -> Errors:
        pairs = zip(names, problem.data, courses, strict=True)
        return {name: growth_error(data.readings[:, channel], course) for name, data, course in pairs}

    return (
        errors(told(found.before.fit, None)),
        errors(told(found.handed_on.fit, found.delivery.remainder)),
        errors([_by_thermometers(found, run) for run in signals_of(problem)]),
    )


def _by_thermometers(found: Diagnosis, run: Signals) -> Array:
    """The growth in m by the ridge on the other thermometers."""
    ridge, growth = found.ladder.named("ridge"), found.ladder.growth
    assert growth is not None  # as every log has it
    by_name = dict(zip((*run.channels, *run.names), (*run.readings.T, *run.inputs.T), strict=True))
    fit = ridge.linear[growth]
    return np.asarray(fit.offset + sum(weight * by_name[name] for (name,), weight in fit.direct.items()))


def growth_error(measured: Array, told: Array) -> float:
    """Error in um, rms, of growth in m that counts from the start of a run."""
    error = measured - told
    error = error[np.isfinite(error)]
    return float(1e6 * np.sqrt(np.mean((error - error[:_ZERO].mean()) ** 2)))


def summary(judged: list[Judged], logs: int) -> str:
    """How many models are better than the uncorrected ones, by how much, and how many causes were named."""
    shares, told, virtual = (
        np.array([getattr(one, name) for one in judged])
        for name in ("share", "share_of_told", "virtual_share")
    )
    ratios = np.array([after / one.before[name] for one in judged for name, after in one.after.items()])
    named = sum(one.verdict in ("named", "ambiguous") for one in judged)
    return (
        f"{len(judged)} machines, seeds {judged[0].seed} to {judged[-1].seed}, logs of each: {logs}\n"
        f"better than uncorrected {np.sum(shares < 1)}, worse by more than 5 % {np.sum(shares > _CLEARLY)}\n"
        f"share of the uncorrected: median {np.median(ratios):.2f} of the duty cycles, "
        f"{np.median(shares):.2f} of machines, {np.median(told):.2f} without {_UNTOLD}\n"
        f"as virtual measurement: median {np.median(virtual):.3f} of machines\n"
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
            f"the uncorrected, {one.virtual_share:.3f} by thermometers; {one.seconds:.0f} s; um: {errors}"
        )
    answer(summary(judged, logs))


if __name__ == "__main__":
    start(main)
