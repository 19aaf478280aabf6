"""Run jobs in Ecos, one simulation after the other."""

from __future__ import annotations

import ctypes
import json
import sys
from pathlib import Path

for library in (Path(sys.prefix) / "lib").glob("libtbb.so*"):
    ctypes.CDLL(str(library), mode=ctypes.RTLD_GLOBAL)

from ecospy import EcosSimulation, EcosSimulationStructure  # noqa: E402
from fmpy import read_model_description  # noqa: E402


def run(job: dict) -> dict:
    types = {v.name: v.type for v in read_model_description(job["fmu"]).modelVariables}
    kinds = {"Real": float, "Integer": int, "Boolean": bool}
    rows: list[list[float]] = []
    with EcosSimulationStructure() as structure:
        structure.add_model("one", job["fmu"])
        structure.add_parameter_set("p", {f"one::{n}": kinds[types[n]](v) for n, v in job["set"].items()})
        with EcosSimulation(structure=structure, step_size=job["step"]) as simulation:
            get = {
                "Real": simulation.get_real,
                "Integer": simulation.get_integer,
                "Boolean": simulation.get_bool,
            }
            simulation.init(parameter_set="p")
            for _ in range(job["steps"]):
                simulation.step(1)
                rows.append([get[types[n]](f"one::{n}") for n in job["watch"]])
            simulation.terminate()
    return {"rows": rows, "log": []}


print(json.dumps([run(job) for job in json.load(sys.stdin)]))
