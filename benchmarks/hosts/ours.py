"""Our own master."""

from __future__ import annotations

import tempfile
from pathlib import Path

from benchmarks.hosts import Finished, Job
from warmlink.fmus.errors import InputError
from warmlink.orchestration.master.algorithms.algorithm import Algorithm
from warmlink.orchestration.master.algorithms.explicit import Jacobi
from warmlink.orchestration.master.algorithms.iterated import FixedPoint
from warmlink.orchestration.master.compiled.loop import Stepping
from warmlink.orchestration.master.run import simulate
from warmlink.orchestration.system.assemble import read_system


def plain(job: Job) -> Finished:
    """Jacobi in a loop of Python."""
    return _run(job, Jacobi(), "plain")


def compiled(job: Job) -> Finished:
    """Jacobi in the compiled loop."""
    return _run(job, Jacobi(), "compiled")


def iterated(job: Job) -> Finished:
    """Fixed point with interpolated inputs, which others do not offer: what accuracy costs."""
    return _run(job, FixedPoint(), "plain")


def _run(job: Job, algorithm: Algorithm, stepping: Stepping) -> Finished:
    with tempfile.TemporaryDirectory(prefix="warmlink-") as work:
        system = read_system(Path(job.ssp), Path(work))
        result = simulate(
            system, job.stop_time, job.step_size, algorithm, record=(job.watched,), stepping=stepping
        )
    if result.reason is not None:
        raise InputError(result.reason)
    return Finished(result.statistics.wall_seconds / job.steps * 1e6, float(result[job.watched][-1]))
