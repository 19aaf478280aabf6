"""What a comparison, a tuning study and a sweep run with: FMUs, and workers that keep what they finish."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

from warmlink.fmus.errors import InputError
from warmlink.orchestration.catalogue import Controller
from warmlink.orchestration.console import remark
from warmlink.orchestration.files import locked_folder, temporary_folder
from warmlink.orchestration.fmu_store import FmuKind, store
from warmlink.orchestration.scenarios.scenario import Scenario
from warmlink.orchestration.studies.cores.agreement import agreeing
from warmlink.orchestration.studies.cores.joined import joined_systems
from warmlink.orchestration.studies.cores.local import LocalWorkers, check_jobs
from warmlink.orchestration.studies.cores.workers import DEFAULT_JOBS, Workers
from warmlink.orchestration.studies.fmu_set import FmuSet
from warmlink.orchestration.studies.ledger import FILE, Ledger


@dataclass(frozen=True)
class Means:
    """What a study runs with.

    Attributes
    ----------
    fmus : kind of FMU
    jobs : processes that run at once
    scheduler : in their place a Dask scheduler, `tcp://10.0.0.1:8786`
    exact : run the FMUs also where the system can be joined, as with a kind of FMU that is asked for
    """

    fmus: FmuKind | None = None
    jobs: int = DEFAULT_JOBS
    scheduler: str | None = None
    exact: bool = False


USUAL = Means()


@dataclass(frozen=True)
class AtWork:
    """Workers, and the FMUs that they run."""

    fmus: FmuSet
    workers: Workers

    def joins(self, controller: Controller) -> bool:
        """Whether the systems with a controller run joined."""
        return controller.component.name in self.fmus.rollouts


@contextmanager
def folder_for(out: str | Path | None) -> Iterator[Path]:
    """The given folder, or a temporary one."""
    if out is not None:
        yield Path(out)
        return
    with temporary_folder() as home:
        yield home / "study"


@contextmanager
def at_work(scenarios: Sequence[Scenario], means: Means, folder: Path) -> Iterator[AtWork]:
    """FMUs of the scenarios, and workers that keep each finished run in a folder, which is locked for them.

    If no run was finished, a folder that was empty before is empty again. InputError if another study is
    using the folder.
    """
    if means.scheduler is None:
        check_jobs(means.jobs)
    with locked_folder(folder):
        fresh, said = not any(folder.iterdir()), list[str]()
        try:
            built = store(means.fmus, sorted({kind for each in scenarios for kind in each.kinds}), remark)
            files = {name: path for each in scenarios for name, path in each.files(built).items()}
            fmus = FmuSet.read(built.kind, files)
            if built.kind == "native" and means.fmus is None and not means.exact:
                whole = joined_systems(scenarios, said.append)
                fmus = replace(fmus, rollouts=agreeing(scenarios, fmus, whole, said.append))
            with _workers(fmus, means) as workers:
                yield AtWork(fmus, Ledger(folder, fmus.digest, workers, remark, said))
        except InputError:
            if fresh and not (folder / FILE).exists():
                _clear(folder)
            raise


@contextmanager
def _workers(fmus: FmuSet, means: Means) -> Iterator[Workers]:
    if means.scheduler is not None:
        from warmlink.orchestration.studies.cores.cluster import ClusterWorkers

        with ClusterWorkers(fmus, means.scheduler) as cluster:
            yield cluster
        return
    with LocalWorkers(fmus, means.jobs) as local:
        yield local


def _clear(folder: Path) -> None:
    for path in folder.iterdir():
        if path.is_file():
            path.unlink()
