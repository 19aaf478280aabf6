"""PyFMI's Master."""

from __future__ import annotations

import tempfile
import time
from pathlib import Path

from warmlink.fmus.errors import InputError
from warmlink.orchestration.bench.hosts import Finished, Job
from warmlink.orchestration.system.read import read_system


def run(job: Job) -> Finished:
    """Its Jacobi with a fixed step, without error control."""
    from pyfmi import Master, load_fmu

    with tempfile.TemporaryDirectory(prefix="warmlink-") as work:
        system = read_system(Path(job.ssp), Path(work))
        if any((link.factor, link.offset) != (1.0, 0.0) for link in system.connections):
            raise InputError("PyFMI Master: converts nothing between two variables")
        models = {name: load_fmu(str(held.fmu), log_level=2) for name, held in system.components.items()}
        for name, held in system.components.items():
            for variable, value in held.parameters.values.items():
                models[name].set(variable, value)
        wires = [
            (
                models[link.source_component],
                link.source_variable,
                models[link.target_component],
                link.target_variable,
            )
            for link in system.connections
        ]
        master = Master(list(models.values()), wires)
        options = master.simulate_options()
        options["step_size"] = job.step_size
        options["error_controlled"] = False
        options["result_handling"] = "none"
        began = time.perf_counter()
        master.simulate(start_time=0.0, final_time=job.stop_time, options=options)
        took = time.perf_counter() - began
        value = models[job.instance].get(job.variable)
    return Finished(took / job.steps * 1e6, float(value[0] if hasattr(value, "__len__") else value))
