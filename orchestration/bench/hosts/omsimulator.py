"""OMSimulator, through the functions of its Python package up to version 2."""

from __future__ import annotations

import time
from typing import Any

from warmlink.fmus.errors import InputError
from warmlink.orchestration.bench.hosts import Finished, Job


def run(job: Job) -> Finished:
    """Its weakly coupled master with a fixed step."""
    import OMSimulator

    oms: Any = OMSimulator.OMSimulator()
    model, status = oms.importFile(job.ssp)
    if status != 0:
        raise InputError("OMSimulator: does not read the SSP")
    oms.setResultFile(model, "")
    oms.setStopTime(model, job.stop_time)
    oms.setFixedStepSize(model, job.step_size)
    if oms.instantiate(model) != 0 or oms.initialize(model) != 0:
        raise InputError("OMSimulator: does not initialize the system")
    began = time.perf_counter()
    status = oms.simulate(model)
    took = time.perf_counter() - began
    value, read = oms.getReal(f"{model}.root.{job.watched}")
    if status != 0 or read != 0:
        raise InputError("OMSimulator: the run failed")
    oms.terminate(model)
    return Finished(took / job.steps * 1e6, float(value))
