"""Run a job in FMPy."""

from __future__ import annotations

import json
import sys

from slave import OK, Slave

job = json.load(sys.stdin)
slave = Slave(job["fmu"]).initialize(job["set"])
rows = []
for k in range(job["steps"]):
    if slave.step(k * job["step"], job["step"]) != OK:
        break
    rows.append(slave.get(*job["watch"]))
print(json.dumps({"rows": rows, "log": [text for _, _, text in slave.messages]}))
