"""A cell that ages: a fixed observer, one designed anew each month, and one with the camera.

`python -m benchmarks.six_months` prints the table, and draws it with `--picture`. Each month the cell works a
shift, which is logged. The observer that is designed anew gets what `diagnose` makes of the log of the month
before: a month's ageing it never knows.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
import pandas as pd
import typer
from rich.console import Console
from rich.table import Table

import warmlink as wl
from benchmarks.command import start
from warmlink.fmus.errors import InputError
from warmlink.orchestration.closed_loop.outcome import ClosedLoop

SCENARIO, SENSORS = "production_shift", "noisy_sensors"
ANEW = "designed anew"
LAWS = {"none": "none", "observer": "observer", ANEW: "observer", "observer_drift": "observer_drift"}
"""The shipped law by the name of its line."""
TEMPERATURES = ("shaft", "winding", "base", "middle", "tip")
"""What the sensors read, in their order."""
PLANT = ("motor.", "link.")
ROW = 30
"""s between two rows of a log."""


def aged(months: float) -> dict[str, float]:
    """Parameters: friction falls, the joint loosens, the surface dulls, the base sensor drifts."""
    return {
        "motor.coulomb_friction": 1.5 * (0.75 + 0.25 * 0.6**months),
        "motor.viscous_friction": 0.6 * (0.85 + 0.15 * 0.6**months),
        "motor.joint_conductance": 1.0 * 0.93**months,
        "link.emissivity": min(0.05 * months, 0.9),
        "sensors.offset[3]": 0.06 * months,
    }


@dataclass(frozen=True)
class Month:
    """What a month came to.

    Attributes
    ----------
    number : months of work before it
    causes : what was found in the log of the month before
    largest, outside : by line of `LAWS`, the largest error in um, and the share of time beyond the tolerance
    """

    number: int
    causes: tuple[str, ...]
    largest: dict[str, float]
    outside: dict[str, float]


def months(count: int, pace: float, seed: int) -> Iterator[Month]:
    """Run the months one after another, the cell ageing at a multiple of the ordinary pace."""
    known: Mapping[str, float] = {}
    causes: tuple[str, ...] = ()
    for number in range(count + 1):
        seeds = {"sensors.seed": seed + number, "camera.seed": seed + number}
        cell = {**aged(pace * number), **seeds}
        loops = {
            line: wl.run(
                SCENARIO,
                law,
                parameters={**cell, **maintained(cell, known)} if line == ANEW else cell,
                mismatches=[SENSORS],
            )
            for line, law in LAWS.items()
        }
        errors = {line: np.abs(loop.error) for line, loop in loops.items()}
        yield Month(
            number,
            causes,
            {line: 1e6 * float(each.max()) for line, each in errors.items()},
            {line: float(np.mean(each > loops[line].scenario.tolerance)) for line, each in errors.items()},
        )
        found = wl.diagnose(log(loops["observer_drift"]))
        causes = found.causes or (found.verdict,)
        known = {n: v for n, v in found.extended.items() if n.startswith(PLANT) or n in cell} or known


def maintained(cell: Mapping[str, float], known: Mapping[str, float]) -> dict[str, float]:
    """What is done about what was found: a design for it, and the offsets of sensors taken out."""
    plant = {name: value for name, value in known.items() if name.startswith(PLANT)}
    offsets = {name: cell[name] - known.get(name, 0.0) for name in cell if name.startswith("sensors.offset")}
    return {**offsets, **(wl.design(law="observer", parameters=plant).parameters if plant else {})}


def log(loop: ClosedLoop) -> pd.DataFrame:
    """What a logger keeps of a shift; the growth is what the camera saw and the correction took out."""
    result = loop.result
    rows = slice(None, None, ROW)
    temperatures = {
        f"{name}_temperature [degC]": result[f"sensors.reading[{place}]"][rows] - 273.15
        for place, name in enumerate(TEMPERATURES, 1)
    }
    seen = result["camera.measured_drift"] + result["compensator.correction"]
    # A picture is good for the growth when it is taken; between two of them the row stays empty.
    fresh = np.flatnonzero(np.diff(result["camera.measured_drift"], prepend=np.nan))
    growth = np.full(loop.time.size, np.nan)
    growth[fresh] = 1e6 * seen[fresh]
    duty = {
        "speed [rad/s]": result["duty.speed"][rows],
        "torque [N.m]": result["duty.torque"][rows],
        "ambient_temperature [degC]": result["duty.ambient_temperature"][rows] - 273.15,
    }
    return pd.DataFrame(
        {"time [s]": loop.time[rows], **duty, **temperatures, "elongation [um]": growth[rows]}
    )


def main(
    count: Annotated[int, typer.Option(help="Months.")] = 6,
    pace: Annotated[float, typer.Option(help="How fast the cell ages, 1 being ordinary.")] = 1.0,
    seed: Annotated[int, typer.Option(help="Of all noise.")] = 1,
    picture: Annotated[Path | None, typer.Option(help="SVG, PNG or PDF to draw.")] = None,
) -> None:
    """Say how far off the tool point is month after month, by controller."""
    if count < 1 or not 0 < pace <= 10:
        raise InputError(
            f"--count {count} --pace {pace:g}: give at least 1 month, and a pace above 0, at most 10"
        )
    table = Table("month", *(f"{line} [µm]" for line in LAWS), "found in the last month's log", box=None)
    found = []
    for month in months(count, pace, seed):
        found.append(month)
        figures = (f"{month.largest[line]:.1f} ({month.outside[line]:.1%})" for line in LAWS)
        table.add_row(str(month.number), *figures, ", ".join(month.causes))
    Console(width=130).print(table)
    print("largest error of the shift (share of the shift beyond the tolerance)")
    if picture is not None:
        draw(found, picture)


def draw(found: list[Month], path: Path) -> None:
    """Largest error by month, a line for each controller."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.0, 3.6), layout="constrained")
    axes = figure.subplots()
    styles = {"observer": "--s", ANEW: "-o", "observer_drift": ":^"}
    for line, style in styles.items():
        axes.plot([m.number for m in found], [m.largest[line] for m in found], style, label=line)
    axes.axhspan(0, 5, color="0.9", label="tolerance")
    axes.set(xlabel="months of work", ylabel="largest error of a shift [µm]", ylim=(0, None))
    axes.legend(loc="upper left")
    figure.savefig(path)


if __name__ == "__main__":
    start(main)
