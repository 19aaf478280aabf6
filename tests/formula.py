"""Workers of a study whose runs are a formula."""

import math
from collections.abc import Iterator, Sequence
from pathlib import Path

from warmlink.orchestration.studies.case import Case, Outcome
from warmlink.orchestration.studies.workers import FmuSet


def fmus_named(name: str) -> FmuSet:
    """FMUs whose bytes are this name."""
    return FmuSet("native", {"ThermalLink": name.encode()})


class Formula:
    """Workers for whom a run's error is a formula in gain and time constant, with its least at (5, 3000)."""

    def __init__(self, poison: float = -1.0, backwards: bool = False, at_most: int | None = None) -> None:
        self.poison, self.backwards, self.left, self.done = poison, backwards, at_most, 0

    def run(self, cases: Sequence[Case]) -> Iterator[tuple[int, Outcome]]:
        places = range(len(cases))
        for place in reversed(places) if self.backwards else places:
            if self.done == self.left:
                raise KeyboardInterrupt
            self.done += 1
            values = cases[place].values["compensator"]
            gain, time = 1e6 * float(values["gain"]), float(values["time_constant"])
            error = 1 + (gain - 5) ** 2 + math.log(time / 3000) ** 2
            rate = 0.01 * gain
            yield (
                place,
                (
                    Outcome(stopped="the slave said no")
                    if gain < self.poison
                    else Outcome(error, error, error, None, 5.0, 2.0, rate, 0.01)
                ),
            )


def make(folder: Path, name: str) -> Path:
    (folder / name).mkdir()
    return folder / name
