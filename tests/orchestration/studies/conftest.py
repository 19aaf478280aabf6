from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest

from warmlink.orchestration import catalogue
from warmlink.orchestration.fmu_store import store
from warmlink.orchestration.machine.shipped import WARMUP_CELL
from warmlink.orchestration.studies.case import Case, Outcome
from warmlink.orchestration.studies.workers import FmuSet, attempt

# Ten minutes each, so that a test may run many.
DUTIES = {
    "work": [("10 min", "3.43 rad/s", "2.5 N*m")],
    "pause": [("5 min", "4 rad/s", "3 N*m"), ("5 min", "0 rad/s", "0 N*m")],
}

STUDY = """
title = "Lag law, two short duty cycles"
controller = "lag"
duty_cycles = ["work.toml", "pause.toml"]
seed = 3

[parameters]
"compensator.gain" = { min = "2 um/W", max = "8 um/W" }
"compensator.time_constant" = { min = "10 min", max = "2 h", log = true }

[objective]
metric = "max_abs_um"

[[constraint]]
metric = "correction_rate_um_s"
at_most = 0.08

[tune]
trials = 14
batch = 4

[sweep]
kind = "grid"
points = 3
"""


class Here:
    """Workers that are this process, and may be interrupted after so many runs."""

    def __init__(self, fmus: FmuSet, at_most: int | None = None) -> None:
        self.fmus, self.left, self.done = fmus, at_most, 0

    def run(self, cases: Sequence[Case]) -> Iterator[tuple[int, Outcome]]:
        for place, case in enumerate(cases):
            if self.done == self.left:
                raise KeyboardInterrupt
            self.done += 1
            yield place, attempt(case, self.fmus)


@pytest.fixture(scope="session")
def fmus() -> FmuSet:
    laws = [catalogue.controller(name).name for name in ("none", "lag")]
    kinds = sorted({kind for law in laws for kind in WARMUP_CELL.parts_with(law).values()})
    chosen = store(None, kinds, lambda text: None)
    return FmuSet.read(chosen.kind, chosen.files(kinds))


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Folder with two short duty cycles and a study of them."""
    for name, segments in DUTIES.items():
        lines = ['stop_time = "10 min"']
        for duration, speed, torque in segments:
            lines += [
                "[[segment]]",
                f'duration = "{duration}"',
                f'speed = "{speed}"',
                f'torque = "{torque}"',
            ]
        (tmp_path / f"{name}.toml").write_text("\n".join(lines))
    (tmp_path / "study.toml").write_text(STUDY)
    return tmp_path
