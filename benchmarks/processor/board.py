"""A board with one processor and a law on it, emulated by qemu."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType

import numpy as np
from numpy.typing import NDArray

from warmlink.controllers.export.c_files import header, source
from warmlink.controllers.export.core import Core, Precision
from warmlink.fmus.errors import InputError

SOURCES = Path(__file__).parent
COMPILER, SIZE, EMULATOR = "arm-none-eabi-gcc", "arm-none-eabi-size", "qemu-system-arm"
CALIBRATION = 1000
"""Instructions of `ticks_of_known_work` in loop.c."""
FLAGS = ("-std=c99", "-O2", "-ffp-contract=off", "-Wall", "-Wextra", "-Werror", "-mthumb", "-mfloat-abi=hard")


@dataclass(frozen=True)
class Target:
    """A processor: its name, the arithmetic it has in hardware, compiler flags, and qemu's board."""

    name: str
    precision: Precision
    flags: tuple[str, ...]
    board: str


TARGETS = (
    Target("Cortex-M7", "double", ("-mcpu=cortex-m7", "-mfpu=fpv5-d16"), "mps2-an500"),
    Target("Cortex-M4F", "single", ("-mcpu=cortex-m4", "-mfpu=fpv4-sp-d16"), "mps2-an386"),
)


def missing_tools() -> str | None:
    """What has to be installed before a law runs on an emulated processor; None if all is there."""
    absent = [name for name in (COMPILER, SIZE, EMULATOR) if shutil.which(name) is None]
    if not absent:
        return None
    packages = "gcc-arm-none-eabi libnewlib-arm-none-eabi qemu-system-arm"
    return f"not installed: {', '.join(absent)} (Debian's packages: {packages})"


def built(core: Core, target: Target, folder: Path) -> int:
    """Compile the core for a target as `folder/law.elf`, and give its code and constants in bytes."""
    (folder / f"{core.name}.h").write_text(header(core), encoding="utf-8")
    (folder / f"{core.name}.c").write_text(source(core), encoding="utf-8")
    compiler = (COMPILER, *FLAGS, *target.flags)
    _called((*compiler, "-c", f"{core.name}.c", "-o", "law.o"), folder)
    names = {"LAW": core.name, "RECALLS": ", NULL, 0" if core.goes_on else ""}
    _called(
        (
            *compiler,
            *(f"-D{name}={value}" for name, value in names.items()),
            *("-include", f"{core.name}.h", f"-I{folder}"),
            *(str(SOURCES / name) for name in ("reset.c", "loop.c")),
            "law.o",
            *("-nostartfiles", "-T", str(SOURCES / "cortex.ld"), "-lm", "-o", "law.elf"),
        ),
        folder,
    )
    text, data, *_ = _called((SIZE, "law.o"), folder).splitlines()[1].split()
    return int(text) + int(data)


def _called(command: Sequence[str], folder: Path) -> str:
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    if done.returncode:
        raise InputError(f"{command[0]}: {done.stderr.strip()[-2000:]}")
    return done.stdout


@dataclass
class Cost:
    """What the law needs on the processor: most instructions in a step, bytes of stack and of the struct."""

    instructions: float = 0.0
    stack: int = 0
    struct: int = 0


class Board:
    """The emulated board under way; a context, at whose end it is switched off.

    Parameters
    ----------
    core : the law, as `built` wrote it
    target : the processor
    folder : where `law.elf` lies
    """

    def __init__(self, core: Core, target: Target, folder: Path) -> None:
        real = np.float32 if core.precision == "single" else np.float64
        self._asked = np.zeros(
            1, np.dtype([("begins", np.int32), ("inputs", real, core.component.u.size)], align=True)
        )
        counts = [(name, np.uint32) for name in ("ticks", "calibration", "stack", "memory")]
        self._answer = np.dtype([("outputs", real, core.component.y.size), *counts], align=True)
        self._folder, self._target = folder, target
        self.cost = Cost()

    def __enter__(self) -> Board:
        for name in ("inputs", "outputs"):
            os.mkfifo(self._folder / name)
        # An instruction takes 32 ns of the board's time, so that its clock of 40 ns tells instructions apart.
        self._machine = subprocess.Popen(
            (
                *(EMULATOR, "-M", self._target.board, "-kernel", "law.elf", "-icount", "shift=5,sleep=off"),
                *("-semihosting-config", "enable=on,target=native"),
                *("-display", "none", "-serial", "none", "-monitor", "none"),
            ),
            cwd=self._folder,
            stdin=subprocess.DEVNULL,
        )
        self._to = (self._folder / "inputs").open("wb", buffering=0)
        self._from = (self._folder / "outputs").open("rb")
        return self

    def __exit__(
        self, kind: type[BaseException] | None, fault: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._to.close()  # the law's main ends with its inputs
        try:
            self._machine.wait(5)
        except subprocess.TimeoutExpired:
            self._machine.kill()
        self._from.close()

    def outputs(self, inputs: NDArray[np.float64], begins: bool) -> NDArray[np.float64]:
        """Outputs, shape (y.size,), of `init` or `step` with these inputs, shape (u.size,), in SI units."""
        self._asked["begins"], self._asked["inputs"] = begins, inputs
        self._to.write(self._asked.tobytes())
        answer = np.frombuffer(self._from.read(self._answer.itemsize), self._answer)[0]
        if not begins:
            taken = float(answer["ticks"]) * CALIBRATION / float(answer["calibration"])
            self.cost.instructions = max(self.cost.instructions, taken)
        self.cost.stack, self.cost.struct = int(answer["stack"]), int(answer["memory"])
        return np.asarray(answer["outputs"], dtype=float)
