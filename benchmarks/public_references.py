"""Other masters on one public file, each in a process of its own; `benchmarks.public_files` starts them."""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any


def by_fmpy(job: Mapping[str, Any]) -> dict[str, list[float]]:
    """Times and outputs of an FMU, co-simulated if it can be, else integrated by CVode to a `tolerance`."""
    from fmpy import simulate_fmu

    result = simulate_fmu(
        job["file"],
        start_time=job["start"],
        stop_time=job["stop"],
        step_size=job["step"],
        output_interval=job["step"],
        output=job["names"],
        relative_tolerance=job["tolerance"],
        record_events=False,
        validate=False,
    )
    return {name: [float(value) for value in result[name]] for name in result.dtype.names}


def by_libcosim(job: Mapping[str, Any]) -> dict[str, list[float]]:
    """Outputs of a system at its end; `references` has the value reference of each Real one."""
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimObserver import CosimObserver

    nanoseconds = round(1e9 * job["step"])
    execution = CosimExecution.from_ssp_file(job["file"], nanoseconds)
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer)
    if not execution.step(job["steps"]):
        raise RuntimeError("a step failed")
    found = {}
    for name, (instance, reference) in job["references"].items():
        slave = execution.slave_index_from_instance_name(instance)
        found[name] = [float(observer.last_real_values(slave, [reference])[0])]
    return found


if __name__ == "__main__":
    asked = json.loads(Path(sys.argv[1]).read_text("utf-8"))
    answer = {"fmpy": by_fmpy, "libcosim": by_libcosim}[asked["by"]](asked)
    Path(sys.argv[2]).write_text(json.dumps(answer), encoding="utf-8")
