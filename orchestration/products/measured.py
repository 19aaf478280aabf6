"""What an exported law needs on two processors, measured with Arm's compiler where it is installed."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Mapping

from warmlink.controllers.export.core import Core
from warmlink.controllers.export.program.statements import Routine
from warmlink.orchestration.files import temporary_folder

COMPILER, SIZE = "arm-none-eabi-gcc", "arm-none-eabi-size"

FLAGS = ("-std=c99", "-Os", "-ffp-contract=off", "-mthumb", "-mfloat-abi=hard", "-fstack-usage", "-c")

PROCESSORS = {
    "Cortex-M7": ("-mcpu=cortex-m7", "-mfpu=fpv5-d16"),
    "Cortex-M4F": ("-mcpu=cortex-m4", "-mfpu=fpv4-sp-d16"),
}
"""Processors and what the compiler is told of them; the second computes double precision in software."""

NOT_MEASURED = (
    "Code and stack were not measured: `arm-none-eabi-gcc` was not installed where this was written.\n"
)


def measured(core: Core, files: Mapping[str, str]) -> str:
    """A table of code and stack in bytes for a law's C, or a sentence where there is no compiler."""
    if shutil.which(COMPILER) is None or shutil.which(SIZE) is None:
        return NOT_MEASURED
    rows = []
    with temporary_folder() as folder:
        for name in (f"{core.name}.c", f"{core.name}.h"):
            (folder / name).write_text(files[name], encoding="utf-8")
        for processor, flags in PROCESSORS.items():
            command = [COMPILER, *FLAGS, *flags, f"{core.name}.c"]
            subprocess.run(command, cwd=folder, check=True, capture_output=True)
            asked = [SIZE, f"{core.name}.o"]
            said = subprocess.run(asked, cwd=folder, check=True, capture_output=True, text=True).stdout
            text, data, *_ = said.splitlines()[1].split()
            stack = deepest(core, (folder / f"{core.name}.su").read_text("utf-8"))
            rows.append(f"| {processor} | {int(text) + int(data)} | {stack} |")
    version = subprocess.run([COMPILER, "-dumpversion"], capture_output=True, text=True).stdout.strip()
    head = (
        f"Measured with {COMPILER} {version} and the flags below, in bytes; the mathematical library aside:"
    )
    return "\n".join(
        [head, "", "| processor | code and constants | stack of a step |", "|---|---|---|", *rows, ""]
    )


def deepest(core: Core, usage: str) -> int:
    """Bytes of stack on the deepest way through a law's functions, from what the compiler says of each."""
    own: dict[str, int] = {}
    for line in usage.splitlines():
        place, size, _ = line.split("\t")
        name = place.rpartition(":")[2].partition(".")[0].removeprefix(f"{core.name}_")
        own[name] = max(own.get(name, 0), int(size))

    def below(routine: Routine) -> int:
        parts = [own[each] for each in own if each.startswith(f"{routine.name}_part_")]
        inner = max(map(below, routine.calls()), default=0)
        return own.get(routine.name, 0) + max(parts, default=0) + inner

    program = core.program
    return own.get("step", 0) + max(below(program.update), below(program.outputs_of))
