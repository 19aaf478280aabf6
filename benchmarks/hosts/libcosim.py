"""libcosim, through its Python package."""

from __future__ import annotations

import time

from benchmarks.hosts import Finished, Job
from warmlink.fmus.errors import InputError


def run(job: Job) -> Finished:
    """Its fixed-step algorithm; the step size is the SSP's own. It is observed in the last step alone."""
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimObserver import CosimObserver

    execution = CosimExecution.from_ssp_file(job.ssp)
    # The first step initializes.
    done = execution.step()
    began = time.perf_counter()
    done = done and execution.step(job.steps - 2)
    took = time.perf_counter() - began
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer)
    if not (done and execution.step()):
        raise InputError("libcosim: a step failed")
    slave = execution.slave_index_from_instance_name(job.instance)
    return Finished(took / (job.steps - 2) * 1e6, observer.last_real_values(slave, [job.reference])[0])
