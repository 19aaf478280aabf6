"""The same study on a Dask cluster of two workers, one of which is killed in the middle."""

import logging
import os
import pickle
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from warmlink.fmus.errors import InputError
from warmlink.orchestration.studies.case import Case, Outcome
from warmlink.orchestration.studies.processes import ClusterWorkers, connected
from warmlink.orchestration.studies.study import load_study
from warmlink.orchestration.studies.sweep import points_of, sweep
from warmlink.orchestration.studies.workers import FmuSet

from .conftest import Here
from .test_workers import OUTCOME, deadly, short

distributed = pytest.importorskip("distributed")
dask = pytest.importorskip("dask")
psutil = pytest.importorskip("psutil")

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def cluster() -> Any:
    # A worker that is not back after 15 s is given up otherwise, which a busy machine may need.
    patient = {
        "distributed.deploy.lost-worker-timeout": "10 minutes",
        # Deaths that the scheduler takes before it blames a task: three by default, each a worker's start.
        "distributed.scheduler.allowed-failures": 1,
    }
    with (
        dask.config.set(patient),
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, dashboard_address=":0", silence_logs=50
        ) as cluster,
    ):
        yield cluster


def test_figures_are_those_of_this_process_though_a_worker_dies(
    cluster: Any, folder: Path, fmus: FmuSet
) -> None:
    study = load_study(str(folder / "study.toml"))
    points = points_of(study)
    here = sweep(study, points, Here(fmus), lambda done: None)
    killed = []

    def kill_one(done: int) -> None:
        if done == 2 and not killed:
            killed.append(next(iter(cluster.workers.values())).pid)
            psutil.Process(killed[0]).kill()

    with connected(cluster.scheduler_address) as client, ClusterWorkers(fmus, client) as workers:
        there = sweep(study, points, workers, kill_one)
    assert killed
    assert repr(there) == repr(here)


@pytest.mark.skipif(os.name != "posix", reason="SIGKILL is POSIX")
def test_a_run_that_always_kills_its_worker_is_recorded(
    cluster: Any, folder: Path, fmus: FmuSet, monkeypatch: pytest.MonkeyPatch
) -> None:
    # The scheduler blames a task for the first death: each costs a worker's start.
    monkeypatch.setattr(cluster.scheduler, "allowed_failures", 0)
    good = short(folder)
    with connected(cluster.scheduler_address) as client, ClusterWorkers(fmus, client) as workers:
        found = dict(workers.run([good, deadly(folder, 99), good]))
    assert [place for place, outcome in sorted(found.items()) if outcome.stopped is not None] == [1]
    assert "the worker died at each" in str(found[1].stopped)


def test_what_a_worker_refuses_is_not_called_a_lost_cluster(monkeypatch: pytest.MonkeyPatch) -> None:
    class Ended(list[object]):
        add = list.append
        __next__ = list.pop

    class Full:
        key = "x"

        def result(self) -> None:
            raise InputError("a temporary file: cannot be written (No space left on device); make room")

    workers = ClusterWorkers.__new__(ClusterWorkers)
    workers._shared, workers._count = None, lambda: 1
    workers._client = SimpleNamespace(submit=lambda *given, **named: Full(), loop=None)
    monkeypatch.setattr(workers, "_shares", lambda cases: [[]])
    monkeypatch.setattr(distributed, "as_completed", lambda loop: Ended())
    with pytest.raises(InputError, match=r"^a temporary file: cannot be written"):
        list(workers.run([]))


def test_a_large_study_is_given_away_bit_by_bit(
    folder: Path, fmus: FmuSet, monkeypatch: pytest.MonkeyPatch
) -> None:
    given: list[int] = []
    most: list[int] = []

    class Ended(list[object]):
        def add(self, future: object) -> None:
            self.append(future)
            most.append(len(self) - len(found))

        def __next__(self) -> object:
            return self[len(found)]

    class Done:
        def __init__(self, cases: list[Case]) -> None:
            self.key, self.cases = object(), cases

        def result(self) -> list[Outcome]:
            return [OUTCOME] * len(self.cases)

        def release(self) -> None:
            found.append(self)

    def submit(what: object, cases: list[Case], shared: object, pure: bool) -> Done:
        given.append(len(pickle.dumps(cases)))
        return Done(cases)

    found: list[Done] = []
    workers = ClusterWorkers.__new__(ClusterWorkers)
    workers._fmus, workers._shared, workers._count = fmus, None, lambda: 2
    workers._client = SimpleNamespace(submit=submit, loop=None)
    monkeypatch.setattr(distributed, "as_completed", lambda loop: Ended())
    case = short(folder)
    cases = [replace(case, values={**case.values, "compensator": {"x": float(i)}}) for i in range(3000)]
    assert sorted(place for place, _ in workers.run(cases)) == list(range(3000))
    assert max(given) < 2e6, "Dask warns of a graph of 10 MB"
    assert len(given) > 16
    assert max(most) <= 6


def test_a_cluster_that_is_lost_between_two_batches_is_told_in_a_sentence(folder: Path, fmus: FmuSet) -> None:
    def lost() -> None:
        raise distributed.comm.core.CommClosedError("Timed out trying to connect")

    workers = ClusterWorkers.__new__(ClusterWorkers)
    workers._fmus, workers._count = fmus, lost
    with pytest.raises(
        InputError, match=r"the cluster was lost \(CommClosedError\); what is finished is kept"
    ):
        list(workers.run([short(folder)]))


def test_dask_prints_no_traceback_beside_that_sentence(
    cluster: Any, fmus: FmuSet, caplog: pytest.LogCaptureFixture
) -> None:
    log = logging.getLogger("distributed.client")
    log.addHandler(caplog.handler)
    with connected(cluster.scheduler_address) as client, ClusterWorkers(fmus, client):
        log.error("Failed to reconnect to scheduler after 5.00 seconds, closing client")
    log.removeHandler(caplog.handler)
    assert [each for each in caplog.records if each.name == log.name] == []
