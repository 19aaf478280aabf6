"""The linear observer on machines that warmlink did not make: `python -m benchmarks.foreign_observers`.

Each law is designed for a machine in one duty cycle, and judged in others of the library, in closed loop,
with thermometers of 0.1 K of noise. The rod needs a checkout of the Reference-FMUs, named in REFERENCE_FMUS.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated

import numpy as np
import typer

from benchmarks.command import start
from benchmarks.foreign_plants import PLANTS, ForeignPlant
from warmlink.fmus.errors import InputError
from warmlink.orchestration.closed_loop.outcome import ClosedLoop, run
from warmlink.orchestration.console import print_table, remark
from warmlink.orchestration.studies.design import design

LAWS = ("linear_observer", "regression")

DUTIES = (
    "heavy_payload",
    "shift_with_breaks",
    "random_jobs",
    "rising_hall_temperature",
    "windshield_wiper",
)
"""Duty cycles in which laws are judged."""


@dataclass(frozen=True)
class Judged:
    """What a law left in one duty cycle.

    Attributes
    ----------
    grown : largest growth in um
    removed : share of it that the law took out
    rms : of the error in um
    inside : share of the time in which the error was within two `correction_std`
    """

    grown: float
    removed: float
    rms: float
    inside: float


def judged(outcome: ClosedLoop) -> Judged:
    """Figures of a run."""
    frame = outcome.to_frame()
    error, std = (frame[each].to_numpy() for each in ("error [m]", "compensator.correction_std [m]"))
    grown = outcome.uncompensated.max_abs_um
    removed = 1.0 - outcome.metrics.max_abs_um / grown
    inside = float(np.mean(np.abs(error) <= 2.0 * std))
    return Judged(grown, removed, 1e6 * float(np.sqrt(np.mean(error**2))), inside)


def of_plant(
    name: str, plant: ForeignPlant, folder: Path, duties: tuple[str, ...] = DUTIES
) -> dict[str, list[Judged]]:
    """What each law leaves of a plant's growth, by law; it is designed in the duty cycle stop_and_go."""
    known = plant.written(name.replace(" ", "_"), folder)
    found: dict[str, list[Judged]] = {law: [] for law in LAWS}
    for law in LAWS:
        values = folder / f"{law}.ssv"
        design(known, law, plant.sensors).write(values)
        for duty in duties:
            unseen = plant.scenario(name.replace(" ", "_"), folder, duty)
            found[law].append(judged(run(unseen, law, parameters=values)))
    return found


def main(
    duties: Annotated[str, typer.Option(help="Duty cycles to judge in, separated by commas.")] = ",".join(
        DUTIES
    ),
) -> None:
    """Design the linear observer and the regression for three foreign plants, and judge both."""
    rows = []
    for name, plant in PLANTS.items():
        with TemporaryDirectory() as work:
            try:
                found = of_plant(name, plant, Path(work), tuple(duties.split(",")))
            except InputError as why:
                remark(f"{name}: {why}")
                continue
        for law, every in found.items():
            removed, rms = [each.removed for each in every], max(each.rms for each in every)
            grown = [each.grown for each in every]
            rows.append(
                [
                    name,
                    law,
                    f"{min(grown):.0f} to {max(grown):.0f}",
                    f"{min(removed):.1%} to {max(removed):.1%}",
                    f"{rms:.2f}",
                    f"{min(each.inside for each in every):.1%}",
                ]
            )
    headings = ["plant", "law", "growth um", "removed", "rms um, at most", "within 2 std, least"]
    print_table("Laws for machines of others", headings, rows, texts=2)


if __name__ == "__main__":
    start(main)
