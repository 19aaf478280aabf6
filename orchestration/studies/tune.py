"""Tuning: Optuna chooses the points, a batch at a time, and the closed loop judges them.

A batch has a size of its own, and each trial draws from its own seed, so that the table is the same whatever
the number of workers. A study that goes on chooses its old trials once more and takes their results from the
storage, so that an interrupted study ends like one that was not.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from itertools import zip_longest
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

from warmlink.fmus.arguments import argument
from warmlink.fmus.errors import InputError
from warmlink.fmus.safe_text import write_frame
from warmlink.orchestration.files import fresh_file
from warmlink.orchestration.progress import progress_bar
from warmlink.orchestration.studies.points import (
    OBJECTIVES,
    Judged,
    Searched,
    best,
    evaluate,
    first_points,
    front,
    refuse_without_objective,
)
from warmlink.orchestration.studies.session import USUAL, RunOptions, open_study
from warmlink.orchestration.studies.storage import Chooser, Storage, default_url, import_optuna
from warmlink.orchestration.studies.study import Study, load_study
from warmlink.orchestration.studies.winner import polish
from warmlink.orchestration.studies.workers import Workers

if TYPE_CHECKING:
    import pandas


@dataclass(frozen=True, repr=False)
class Tuned(Searched):
    """A study with all its trials, and its winner polished; `joined` says whether that is possible."""

    storage: Storage = field(compare=False)
    polished: Judged | None = None
    joined: bool = False
    word: ClassVar[str] = "trial"

    @property
    def best(self) -> Judged | None:
        """The winner, polished where that was possible."""
        return self.polished or best(self.found)

    @property
    def gain(self) -> str:
        """What polishing gave the winner, in words."""
        if self.polished is None:
            return "not polished yet" if self.joined else "not polished, since the system is not joined"
        before, after = self.found[self.polished.number].objectives, self.polished.objectives
        less = 100 * (before[0] - after[0]) / (before[0] or 1.0)  # a time to tolerance may be 0
        told = f"polished along its gradient from {before[0]:.5g}, {less:.2g} % less"
        beside = zip(self.study.objectives[1:], after[1:], before[1:], strict=True)
        return told + "".join(f", and {of.title} {now:.4g}, before {was:.4g}" for of, now, was in beside)

    @property
    def reached(self) -> list[str]:
        """What the winner has come to, a sentence for each objective."""
        study, winner, first = self.study, self.best, self.found[0]
        if winner is None:
            return self.unmet
        where = "at best" if len(study.objectives) == 1 else f"in trial {winner.number}, amid the front"
        shipped = first.objectives if study.shipped else ()
        return [
            f"{of.title}: {now:.4g} {where}" + ("" if was is None else f", {was:.4g} as shipped")
            for of, now, was in zip_longest(study.objectives, winner.objectives, shipped)
        ]

    @property
    def trials(self) -> list[Judged]:
        """All of them by number."""
        return self.found

    def _best_lines(self) -> list[str]:
        study, lines = self.study, [*self.reached]
        if self.best is not None:
            lines += [*study.lines(self.best.point), self.gain]
        lines += self._front_lines()
        unfit = sum(trial.reason is None and not trial.feasible for trial in self.found)
        return [*lines, f"{unfit} trials break a constraint"] if unfit else lines

    def to_frame(self) -> pandas.DataFrame:
        """A row for each trial, as in `trials.csv`."""
        import pandas

        two, kept = len(self.study.objectives) > 1, front(self.found)
        excesses = [f"{c.title} above {c.at_most:g}" for c in self.study.constraints]
        rows = [
            {
                "number": trial.number,
                **{axis.heading: trial.point[axis.name] for axis in self.study.axes},
                **dict(zip_longest(OBJECTIVES[: 1 + two], trial.objectives)),
                **({"in_front": int(trial in kept)} if two else {}),
                "feasible": int(trial.feasible),
                **dict(zip(excesses, trial.excess or [None] * len(excesses), strict=True)),
                "reason": trial.reason,
            }
            for trial in self.found
        ]
        return pandas.DataFrame(rows)

    def write_csv(self, path: Path) -> None:
        """Write `trials.csv`, whole or not at all; InputError if it cannot be written."""
        with fresh_file(path) as target:
            write_frame(self.to_frame(), target)


TRIALS = "trials.csv"
"""Table of the trials; while a study runs it is written anew after each batch."""

Progress = Callable[[int, Judged | None], None]
"""Called with the number of trials done and the best so far."""


def tune(
    study: Study,
    workers: Workers,
    storage: Storage,
    progress: Progress,
    *,
    joined: bool = False,
    keep: Callable[[Tuned], object] = id,
) -> Tuned:
    """Go on with a study until it has its trials, and polish its winner where joined runs are cheap.

    `keep` is called with what is found so far after each batch in which something was run.
    InputError if the first point gives no objective, or the storage's trials do not follow from the study.
    """
    done, first_of_all = storage.trials()[: study.tune.trials], first_points(study)
    if not done:
        refuse_without_objective(study, workers)
    chooser = Chooser(study, first_of_all)
    trials: list[Judged] = []
    while len(trials) < study.tune.trials:
        first = len(trials)
        points = chooser.ask(min(study.tune.batch, study.tune.trials - first))
        batch = done[first : first + len(points)]
        for trial, point in zip(batch, points, strict=False):
            if any(trial.point.get(axis.name) != point[axis.name] for axis in study.axes):
                raise InputError(
                    f"storage: trial {trial.number} of {storage.name} was not chosen by this study with this "
                    f"version of Optuna; choose another {argument('out')} or storage"
                )
        begin = first + len(batch)
        for trial in storage.adding(evaluate(study, points[len(batch) :], workers, begin), begin):
            batch.append(trial)
            progress(len(trials) + len(batch), best([*trials, *batch]))
        chooser.tell(batch)
        trials += batch
        progress(len(trials), best(trials))
        if len(trials) > len(done):
            keep(Tuned(study, [*trials], storage, joined=joined))
    winner = best(trials) if joined else None
    polished = None if winner is None else polish(study, winner, workers)
    return Tuned(study, trials, storage, polished, joined)


def tune_study(
    study: str | Path | Study,
    trials: int | None = None,
    *,
    options: RunOptions = USUAL,
    out: str | Path | None = None,
) -> Tuned:
    """Find a controller's best parameters with Optuna, judged in closed loop.

    Parameters
    ----------
    study : a study file (TOML), or a shipped study by name
    trials : how many; what the study says by default
    options : kind of FMU, and number of processes or a Dask scheduler
    out : folder in which finished runs are kept, so that the same call goes on where it was interrupted

    Raises
    ------
    InputError
        If there is no such study, or it asks for what does not exist or cannot be.

    Examples
    --------
    >>> tuned = wl.tune("study.toml", trials=20, options=wl.RunOptions(jobs=4), out="tuned")
    >>> print(tuned)
    """
    asked = (study if isinstance(study, Study) else load_study(str(study))).lasting(trials)
    with tuned(asked, options, out) as found:
        return found


def _table_into(folder: Path, found: Tuned) -> None:
    found.write_csv(folder / TRIALS)


@contextmanager
def tuned(
    study: Study,
    options: RunOptions,
    out: str | Path | None,
    keep: Callable[[Path, Tuned], object] = _table_into,
) -> Iterator[Tuned]:
    """Tune; the folder in which finished runs are kept is locked until the block ends.

    `keep` is called with this folder and what is found so far after each batch in which something was run.
    """
    import_optuna()

    def note(leader: Judged | None) -> str:
        return "" if leader is None else f"best {leader.objective:.4g} (trial {leader.number})"

    with open_study(study.runs, options, out) as work:
        storage = Storage(study, work.fmus.digest, study.tune.storage or default_url(work.folder))
        with progress_bar(study.title) as show:
            found = tune(
                study,
                work.workers,
                storage,
                lambda done, leader: show(done / study.tune.trials, note(leader)),
                joined=study.controller.component.name in work.fmus.rollouts,
                keep=partial(keep, work.folder),
            )
        yield found
