"""A machine tool with a foreign FMU: from its SSP to a diagnosis, a designed compensator and what that gains.

The files beside this script are all that it takes. `real.ssp` stands for the machine: it is only run, as a
machine is, and nothing but a recording of it reaches the diagnosis.
"""

import os
import runpy
import shutil
from pathlib import Path
from tempfile import mkdtemp

import warmlink as wl

os.chdir(shutil.copytree(Path(__file__).parent, mkdtemp(), dirs_exist_ok=True))

# 1. The machine is described, and its first shift recorded.
runpy.run_path("machine.py")
runpy.run_path("record.py")

# 2. What does the model get wrong, and why? The extended model is an SSP for any tool.
found = wl.diagnose("experiment.toml")
print(found)
print(found.to_frame())
found.write("found")
scenario = Path("machine.toml").read_text("utf-8").replace("machine.ssp", "found/extended.ssp")
Path("extended.toml").write_text(scenario, "utf-8")

# 3. A compensator is designed for the machine as its maker knew it, and for the extended model.
largest = {}
for name in ("machine", "extended"):
    wl.design(f"{name}.toml", "regression", ["shaft", "base", "tip"]).write(f"{name}.ssv")
    outcome = wl.run("real.toml", parameters=f"{name}.ssv")
    largest[name] = outcome.metrics.max_abs_um
    print(f"designed with {name}.toml:")
    print(outcome)

assert found.causes == ("lubricant",)
(conductance,) = found.to_frame()["value"]
assert abs(conductance - 0.6) < 0.02
assert largest["extended"] < 0.2 * largest["machine"]
