"""Native FMUs under random calls, watched by sanitizers: nothing that a host does crashes it, or hangs.

With WARMLINK_RANDOM_CALLS=100000 every component takes so many calls; WARMLINK_SEED repeats a run.
"""

from __future__ import annotations

import os
import random
import subprocess
from pathlib import Path

import pytest

from warmlink.fmus.packaging.native.compile import Compiler

from .sanitized import COMPONENTS, KINDS, VERSIONS, compile_sanitized

pytestmark = pytest.mark.xdist_group("sanitized")

HERE = Path(__file__).parent
CALLS = os.environ.get("WARMLINK_RANDOM_CALLS")


@pytest.mark.parametrize("name", COMPONENTS if CALLS else KINDS)
def test_random_calls_do_no_harm(name: str, c_compiler: Compiler, sanitized_folder: Path) -> None:
    calls = CALLS or "10000"
    seed = os.environ.get("WARMLINK_SEED") or (str(random.SystemRandom().randrange(10**6)) if CALLS else "13")
    for version in VERSIONS:
        program = compile_sanitized(
            name,
            version,
            c_compiler,
            sanitized_folder,
            HERE / "drivers" / "random_calls.c",
            f"-DFMI={version[0]}",
        )
        done = subprocess.run([program, seed, calls], capture_output=True, text=True, timeout=250)
        print(f"FMI {version}, seed {seed}: {done.stdout}")
        assert done.returncode == 0, f"FMI {version}, seed {seed}: {done.stdout}{done.stderr[-3000:]}"
