"""`warmlink simulate` in this process, and a small system to run with it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from warmlink.orchestration.cli import main
from warmlink.orchestration.system.model import (
    Connection,
    DefaultExperiment,
    FmuPart,
    System,
    Value,
)
from warmlink.orchestration.system.write import write_ssp


def oscillator(fmu: Path, stop: float = 10.0, step: float = 0.1, **b: Value) -> Path:
    """a'' = -a from a = 1: two integrators in a loop."""
    a = FmuPart("a", fmu, {}, {"y": 1.0, "rate": -1.0})
    parts = {"a": a, "b": FmuPart("b", fmu, {}, dict(b))}
    wires = (Connection("a", "y", "b", "u"), Connection("b", "y", "a", "u"))
    path = Path("oscillator.ssp")
    write_ssp(System("oscillator", parts, wires, DefaultExperiment(0.0, stop, step)), path)
    return path


def called(path: Path, *options: str) -> int:
    """Exit code of the command, run in this process."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("sys.argv", ["warmlink", "simulate", str(path), *options])
        with pytest.raises(SystemExit) as stop:
            main()
    return int(stop.value.code or 0)


def simulate(
    path: Path, *options: str, capsys: pytest.CaptureFixture[str], expected: int = 0
) -> tuple[dict[str, Any], str]:
    """Answer as JSON, and what was said beside it."""
    code = called(path, "--json", *options)
    out, err = capsys.readouterr()
    assert code == expected, err
    return json.loads(out) if out else {}, err
