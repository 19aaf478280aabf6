"""Scripts that load FMUs, each in a process of its own: a crash is a result, and none outlives its test."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

HOSTS_FOLDER = Path(__file__).with_name("hosts")


@dataclass(frozen=True)
class Outcome:
    """What a script printed last, as JSON, and everything that it wrote."""

    result: Any
    output: str


def run_apart(script: str, *arguments: str, jobs: Sequence[dict[str, Any]] = ()) -> Outcome:
    """Run `hosts/<script>.py`; it must end well."""
    done = subprocess.run(
        [sys.executable, str(HOSTS_FOLDER / f"{script}.py"), *arguments],
        input=json.dumps(jobs),
        capture_output=True,
        text=True,
        timeout=200,
        check=False,
    )
    output = done.stdout + done.stderr
    assert done.returncode == 0, output[-4000:]
    lines = [line for line in done.stdout.splitlines() if line.startswith(("[{", "{", '"'))]
    return Outcome(json.loads(lines[-1]), output)
