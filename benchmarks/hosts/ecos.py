"""Ecos, through its Python package."""

from __future__ import annotations

import ctypes
import time
from importlib import metadata

from benchmarks.hosts import Finished, Job
from warmlink.orchestration.system.write import PARAMETER_SET


def load_tbb() -> None:
    """Load the library of Ecos' dependency tbb, which ecospy finds only if that was done."""
    for file in metadata.files("tbb") or ():
        if file.name.startswith("libtbb.so."):
            ctypes.CDLL(str(file.locate()), mode=ctypes.RTLD_GLOBAL)
            return


def run(job: Job) -> Finished:
    """Its fixed-step algorithm."""
    load_tbb()
    from ecospy import EcosSimulation

    with EcosSimulation(ssp_path=job.ssp, step_size=job.step_size) as simulation:
        simulation.init(parameter_set=PARAMETER_SET)
        began = time.perf_counter()
        simulation.step(job.steps)
        took = time.perf_counter() - began
        value = simulation.get_real(f"{job.instance}::{job.variable}")
    return Finished(took / job.steps * 1e6, float(value))
