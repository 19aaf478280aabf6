"""Run jobs in libcosim, one execution after the other."""

from __future__ import annotations

import json
import sys

from fmpy import read_model_description
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
from libcosimpy.CosimObserver import CosimObserver
from libcosimpy.CosimSlave import CosimLocalSlave

log_output_level(CosimLogLevel.WARNING)


def run(job: dict) -> dict:
    variables = {v.name: v for v in read_model_description(job["fmu"]).modelVariables}
    execution = CosimExecution.from_step_size(int(job["step"] * 1e9))
    index = execution.add_local_slave(CosimLocalSlave(fmu_path=job["fmu"], instance_name="one"))
    initial = {
        "Real": (execution.real_initial_value, float),
        "Integer": (execution.integer_initial_value, int),
        "Boolean": (execution.boolean_initial_value, bool),
    }
    for name, value in job["set"].items():
        setter, kind = initial[variables[name].type]
        setter(index, variables[name].valueReference, kind(value))
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer)
    last = {
        "Real": observer.last_real_values,
        "Integer": observer.last_integer_values,
        "Boolean": observer.last_boolean_values,
    }
    rows = []
    for _ in range(job["steps"]):
        if not execution.step():
            break
        rows.append([last[variables[n].type](index, [variables[n].valueReference])[0] for n in job["watch"]])
    return {"rows": rows, "log": []}


print(json.dumps([run(job) for job in json.load(sys.stdin)]))
