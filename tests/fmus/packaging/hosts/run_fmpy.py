"""Run jobs in FMPy, all of them step by step together."""

from __future__ import annotations

import json
import sys
import types

from slave import OK, Slave

# A host may have anything under these names; the FMUs use their own.
for taken in ("warmlink", "pythonfmu"):
    sys.modules[taken] = types.ModuleType(taken)

jobs = json.load(sys.stdin)
slaves = [Slave(job["fmu"], f"slave{i}").initialize(job["set"]) for i, job in enumerate(jobs)]
rows: list[list[list[float]]] = [[] for _ in jobs]
running = set(range(len(jobs)))
for k in range(max(job["steps"] for job in jobs)):
    for i, (job, slave) in enumerate(zip(jobs, slaves, strict=True)):
        if i in running and slave.step(k * job["step"], job["step"]) == OK:
            rows[i].append(slave.get(*job["watch"]))
        else:
            running.discard(i)
logs = [[text for _, _, text in slave.messages] for slave in slaves]
print(json.dumps([{"rows": r, "log": log} for r, log in zip(rows, logs, strict=True)]))
