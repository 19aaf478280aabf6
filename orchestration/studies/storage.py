"""Optuna: where the trials of a tuning study are kept, and what chooses the next ones."""

from __future__ import annotations

import os
import re
import warnings
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from warmlink.fmus.errors import InputError, MissingExtraError
from warmlink.orchestration.studies.axis import Axis
from warmlink.orchestration.studies.points import Judged
from warmlink.orchestration.studies.study import Point, Study

if TYPE_CHECKING:
    import optuna
    from optuna.distributions import BaseDistribution

LOCK_TIMEOUT_S = 3.0
JOURNAL = "journal:///"
"""Before the path of a file to which each trial is appended, which goes on shared file systems too."""

REASON, EXCESS = "reason", "excess"
"""User attributes of a trial."""


def import_optuna() -> None:
    """Load Optuna, or say that it is missing, and silence what it logs beside our own words."""
    try:
        import optuna
    except ImportError:
        raise MissingExtraError("tuning", "studies") from None
    optuna.logging.set_verbosity(optuna.logging.ERROR)


class Storage:
    """The finished trials of one study, in the order of their numbers.

    A study that is not quite the same, or runs on other FMUs, has another name in the storage: its trials
    are not mixed with these.
    `fmus` is the digest of the FMUs, `url` as Optuna takes it, or `journal:///` and a path.
    """

    def __init__(self, study: Study, fmus: str, url: str) -> None:
        import optuna

        self.name = f"{study.name}-{study.digest(fmus)}"
        self.place = shown_place(url)
        self._distributions = _distributions(study)
        try:
            storage: Any = url
            if url.startswith("sqlite"):
                arguments = {"connect_args": {"timeout": LOCK_TIMEOUT_S}}
                storage = optuna.storages.RDBStorage(url, engine_kwargs=arguments)
            elif url.startswith(JOURNAL):
                storage = _journal(str(Path(url.removeprefix(JOURNAL)).absolute()))
            self.study = optuna.create_study(
                storage=storage,
                study_name=self.name,
                load_if_exists=True,
                directions=["minimize"] * len(study.objectives),
            )
            # Found out now rather than after the first batch: may it be written?
            self.study.set_user_attr("title", study.title)
        except Exception as fault:
            told = f"storage {self.place}: cannot be used ({_brief(fault)})"
            raise InputError(f"{told}; wait for whoever uses it, or choose another") from fault

    def trials(self) -> list[Judged]:
        """Finished trials by number; InputError if the storage cannot be read."""
        with _answering("cannot be read"):
            trials = self.study.get_trials(deepcopy=False)
        found = []
        for trial in trials:
            point = {name: float(value) for name, value in trial.params.items()}
            excess, reason = tuple(trial.user_attrs.get(EXCESS) or ()), trial.user_attrs.get(REASON)
            found.append(Judged(trial.number, point, tuple(trial.values or ()), excess, reason))
        return found

    def adding(self, ended: Iterable[Judged], first: int) -> Iterator[Judged]:
        """Add trials in the order of their numbers, and give each as soon as those before it are there."""
        waiting: dict[int, Judged] = {}
        for trial in ended:
            waiting[trial.number] = trial
            while first in waiting:
                found = waiting.pop(first)
                self.add(found)
                yield found
                first += 1

    def add(self, judged: Judged) -> None:
        """Add the trial that comes next; InputError if the storage takes it no more, or has it already."""
        from optuna.trial import TrialState, create_trial

        trial = create_trial(
            state=TrialState.COMPLETE if judged.reason is None else TrialState.FAIL,
            values=list(judged.objectives) or None,
            params=dict(judged.point),
            distributions=dict(self._distributions),
            user_attrs={REASON: judged.reason, EXCESS: list(judged.excess)},
        )
        with _answering("takes no more trials"):
            there = len(self.study.get_trials(deepcopy=False))
            if there == judged.number:
                self.study.add_trial(trial)
        if there != judged.number:
            raise InputError(
                f"storage {self.place}: somebody else works on {self.name}, which has {there} trials where "
                f"{judged.number} were expected; end one of the two, and run again to go on"
            )


class Chooser:
    """Optuna in memory: it knows the trials of all batches before, and nothing of wall time.

    The first points are given; each trial is drawn from a seed of its own.
    """

    def __init__(self, study: Study, first: Sequence[Point]) -> None:
        import optuna

        self._study, self._number = study, 0
        self._distributions = _distributions(study)
        self._optuna = optuna.create_study(
            sampler=_sampler(study, 0), directions=["minimize"] * len(study.objectives)
        )
        self._asked: list[optuna.trial.Trial] = []
        for point in first:
            self._optuna.enqueue_trial(dict(point))

    def ask(self, count: int) -> list[Point]:
        """Choose the next points."""
        for _ in range(count):
            self._optuna.sampler = _sampler(self._study, self._number)
            self._number += 1
            self._asked.append(self._optuna.ask(dict(self._distributions)))
        return [{name: float(trial.params[name]) for name in self._distributions} for trial in self._asked]

    def tell(self, batch: list[Judged]) -> None:
        """Take the results of the points last chosen."""
        from optuna.trial import TrialState

        for asked, trial in zip(self._asked, batch, strict=True):
            if _sets_constraints():
                for i, value in enumerate(trial.excess):
                    asked.set_constraint(str(i), value)
            else:
                asked.set_user_attr(EXCESS, list(trial.excess))
            if trial.reason is None:
                self._optuna.tell(asked, list(trial.objectives))
            else:
                self._optuna.tell(asked, state=TrialState.FAIL)
        self._asked = []


def _sampler(study: Study, number: int) -> optuna.samplers.BaseSampler:
    import optuna

    seed = int(np.random.SeedSequence([study.seed, number]).generate_state(1)[0])
    if study.tune.sampler == "random":
        return optuna.samplers.RandomSampler(seed=seed)
    asked = study.constraints and not _sets_constraints()
    excess = (lambda trial: list(trial.user_attrs.get(EXCESS, []))) if asked else None
    with warnings.catch_warnings():  # Optuna 4 calls these arguments experimental
        warnings.simplefilter("ignore", optuna.exceptions.ExperimentalWarning)
        return optuna.samplers.TPESampler(
            seed=seed, multivariate=True, constant_liar=True, constraints_func=excess
        )


def _sets_constraints() -> bool:
    """Whether a trial is told its constraints, as from Optuna 5 on; before, the sampler asks for them."""
    import optuna

    return hasattr(optuna.trial.Trial, "set_constraint")


def _journal(path: str) -> optuna.storages.JournalStorage:
    """Storage in a file; a last line that a kill cut short, after which Optuna reads no more, is removed.

    The path is absolute, since the lock is a link to it: Optuna waits forever for one that leads nowhere.
    """
    from optuna.storages import journal

    backend, lock = journal.JournalFileBackend(path), journal.JournalFileSymlinkLock(path)
    lock.acquire()
    try:
        os.truncate(path, Path(path).read_bytes().rfind(b"\n") + 1)
    finally:
        lock.release()
    return journal.JournalStorage(backend)


@contextmanager
def _answering(complaint: str) -> Iterator[None]:
    """Turn what a storage of anybody's may raise into an InputError."""
    try:
        yield
    except Exception as fault:
        raise InputError(
            f"storage: {complaint} ({_brief(fault)}); what it has is kept, run again to go on"
        ) from fault


def _distributions(study: Study) -> dict[str, BaseDistribution]:
    """What Optuna chooses from, by the axis' name."""
    from optuna.distributions import CategoricalDistribution, FloatDistribution, IntDistribution

    def of(axis: Axis) -> BaseDistribution:
        if axis.choice:
            return CategoricalDistribution(axis.choice)
        if axis.integer:
            return IntDistribution(int(axis.low), int(axis.high), log=axis.log)
        return FloatDistribution(axis.low, axis.high, log=axis.log)

    return {axis.name: of(axis) for axis in study.axes}


def default_url(folder: Path) -> str:
    """SQLite file in a folder, whatever its name; Optuna takes braces for places to be filled in."""
    from sqlalchemy.engine import URL

    url = str(URL.create("sqlite", database=(folder / "study.db").resolve().as_posix()))
    return url.replace("{", "{{").replace("}", "}}")


def shown_place(url: str) -> str:
    """The URL without a password, or the path of a journal, as optuna-dashboard takes them too."""
    return re.sub(f"^{JOURNAL}|(?<=://)[^/].*@", "", url)


def _brief(fault: BaseException) -> str:
    """First line of the innermost cause."""
    while fault.__cause__ is not None:
        fault = fault.__cause__
    text = str(fault).strip().splitlines()
    return text[0] if text else type(fault).__name__
