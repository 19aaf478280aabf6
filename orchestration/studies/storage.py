"""Where a tuning study's trials are kept: a database by its URL, SQLite by default, or a file that grows."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from warmlink.fmus.errors import InputError, MissingExtraError
from warmlink.orchestration.studies.points import Judged
from warmlink.orchestration.studies.study import Study

if TYPE_CHECKING:
    import optuna
    from optuna.distributions import BaseDistribution

LOCK_TIMEOUT_S = 3.0
JOURNAL = "journal:///"
"""Before the path of a file to which each trial is appended, which goes on shared file systems too."""

REASON, EXCESS = "reason", "excess"
"""User attributes of a trial."""


def import_optuna() -> None:
    """Load Optuna, or say that it is missing, and silence what it says beside our own words."""
    try:
        import optuna
    except ImportError:
        raise MissingExtraError("tuning", "studies") from None
    optuna.logging.set_verbosity(optuna.logging.ERROR)
    warnings.filterwarnings("ignore", category=optuna.exceptions.ExperimentalWarning)


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
        self._distributions = distributions(study)
        try:
            if url.startswith("sqlite"):
                arguments = {"connect_args": {"timeout": LOCK_TIMEOUT_S}}
                storage: Any = optuna.storages.RDBStorage(url, engine_kwargs=arguments)
            elif url.startswith(JOURNAL):
                storage = _journal(url.removeprefix(JOURNAL))
            else:
                storage = optuna.storages.get_storage(url)
            self.study = optuna.create_study(
                storage=storage, study_name=self.name, load_if_exists=True, directions=directions(study)
            )
            # Found out now rather than after the first batch: may it be written?
            self.study.set_user_attr("title", study.title)
        except Exception as fault:
            raise InputError(
                f"storage {self.place}: cannot be used ({_brief(fault)}); wait for whoever uses it, "
                "or choose another"
            ) from fault

    def trials(self) -> list[optuna.trial.FrozenTrial]:
        """Finished trials by number; InputError if the storage cannot be read."""
        with _answering("cannot be read"):
            return list(self.study.get_trials(deepcopy=False))

    def add(self, evaluation: Judged) -> None:
        """Add the trial that comes next; InputError if the storage takes it no more, or has it already."""
        import optuna
        from optuna.trial import TrialState

        trial = optuna.trial.create_trial(
            state=TrialState.COMPLETE if evaluation.reason is None else TrialState.FAIL,
            values=told(evaluation) if evaluation.reason is None else None,
            params=internal(evaluation.point, self._distributions),
            distributions=dict(self._distributions),
            user_attrs={REASON: evaluation.reason, EXCESS: list(evaluation.excess)},
        )
        with _answering("takes no more trials"):
            there = len(self.study.get_trials(deepcopy=False))
            if there == evaluation.number:
                self.study.add_trial(trial)
        if there != evaluation.number:
            raise InputError(
                f"storage {self.place}: somebody else works on {self.name}, which has {there} trials where "
                f"{evaluation.number} were expected; end one of the two, and run again to go on"
            )


def _journal(path: str) -> optuna.storages.JournalStorage:
    """Storage in a file; a last line that a kill cut short, after which Optuna reads no more, is removed."""
    from optuna.storages import JournalStorage
    from optuna.storages.journal import JournalFileBackend, JournalFileSymlinkLock

    backend, lock = JournalFileBackend(path), JournalFileSymlinkLock(path)
    lock.acquire()
    try:
        with Path(path).open("r+b") as stream:
            stream.truncate(stream.read().rfind(b"\n") + 1)
    finally:
        lock.release()
    return JournalStorage(backend)


@contextmanager
def _answering(complaint: str) -> Iterator[None]:
    """Turn what a storage of anybody's may raise into an InputError."""
    try:
        yield
    except Exception as fault:
        raise InputError(
            f"storage: {complaint} ({_brief(fault)}); what it has is kept, run again to go on"
        ) from fault


def distributions(study: Study) -> dict[str, BaseDistribution]:
    """What Optuna chooses from, by the axis' name."""
    from optuna.distributions import CategoricalDistribution, FloatDistribution, IntDistribution

    found: dict[str, BaseDistribution] = {}
    for axis in study.axes:
        if axis.choice:
            found[axis.name] = CategoricalDistribution(axis.choice)
        elif axis.integer:
            found[axis.name] = IntDistribution(int(axis.low), int(axis.high), log=axis.log)
        else:
            found[axis.name] = FloatDistribution(axis.low, axis.high, log=axis.log)
    return found


def internal(point: Mapping[str, float], chosen: Mapping[str, BaseDistribution]) -> dict[str, float]:
    """A point's values as Optuna has them: whole numbers as such."""
    from optuna.distributions import IntDistribution

    return {
        name: int(point[name]) if isinstance(distribution, IntDistribution) else point[name]
        for name, distribution in chosen.items()
    }


def directions(study: Study) -> list[optuna.study.StudyDirection]:
    """That each objective is to be small."""
    from optuna.study import StudyDirection

    return [StudyDirection.MINIMIZE] * (1 if study.second is None else 2)


def told(evaluation: Judged) -> list[float]:
    """The objectives as Optuna hears them."""
    return [each for each in (evaluation.objective, evaluation.second) if each is not None]


def default_url(folder: Path) -> str:
    """SQLite file in a folder."""
    return f"sqlite:///{(folder / 'study.db').resolve().as_posix()}"


def shown_place(url: str) -> str:
    """The URL without a password, or the path of a journal, as optuna-dashboard takes them too."""
    if url.startswith(JOURNAL):
        return url.removeprefix(JOURNAL)
    scheme, there, rest = url.partition("://")
    return scheme + there + rest.rpartition("@")[2]


def _brief(fault: BaseException) -> str:
    """First line of the innermost cause."""
    while fault.__cause__ is not None:
        fault = fault.__cause__
    text = str(fault).strip().splitlines()
    return text[0] if text else type(fault).__name__
