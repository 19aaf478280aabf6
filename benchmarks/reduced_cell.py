"""A cell with a link of any shape: full elements, the reduced link and a slender one side by side.

Also whether `diagnose`, with the reduced link, names what was hidden in a run that the full elements made.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import numpy as np
import typer
from numpy.typing import NDArray

from benchmarks.command import start
from benchmarks.reduction import COLD, FullElements, example_part
from warmlink.fmus.component import Component
from warmlink.fmus.component.join import join
from warmlink.fmus.component.reference import integrate
from warmlink.fmus.motor_heat_source.component import COMPONENT as MOTOR
from warmlink.fmus.plant import WIRES, demand
from warmlink.fmus.reduced_link.component import reduced_link
from warmlink.fmus.thermal_link.component import COMPONENT as SLENDER
from warmlink.orchestration import cli
from warmlink.orchestration.console import answer, print_table
from warmlink.orchestration.diagnosis.practice.hidden import Course, Truth, motor_rates, surroundings
from warmlink.orchestration.diagnosis.practice.hide import hide, write_csv
from warmlink.orchestration.scenarios.duties.duty import Segment

if TYPE_CHECKING:
    from warmlink.orchestration.reduction.part import Part

Array = NDArray[np.float64]

STEP = 2.0
"""s, of the full elements; segments last so many times that."""

WORK = (Segment(1800, 3.43, 2.5), Segment(600, 1.0, 4.0, COLD + 2), Segment(1200))
"""An hour of work for the comparison."""


def full_course(part: Part, truth: Truth, duty: Sequence[Segment], times: Array) -> Course:
    """Course of a cell whose link is all finite elements of a part, as `hide` wants it of a solver."""
    outputs, size = np.vstack([part.elements.heat.outputs, part.elements.heat.loads[:, :2].T]), STEP
    values = {
        "conductivity": truth.conductivity,
        "density": truth.capacity / part.within.material["specific_heat"],
        "convection_still": truth.still,
        "convection_per_speed": truth.per_speed,
    }
    full, motor, clock = FullElements(part, values), np.full(2, COLD), 0.0
    at, rows = [clock], [np.concatenate([motor, outputs @ full.rise])]
    for segment in duty:
        air = surroundings(truth, segment, clock)
        full.drive({"speed": segment.speed, "ambient_temperature": air})
        for _ in range(round(segment.duration / size)):
            base = COLD + float(outputs[-2] @ full.rise)
            rates, before = motor_rates(truth, segment, clock, motor[0], motor[1], base, air)
            ahead = motor + size * np.array(rates)
            later, after = motor_rates(truth, segment, clock, ahead[0], ahead[1], base, air)
            motor = motor + size / 2 * (np.array(rates) + np.array(later))
            full.step((before + after) / 2, size)
            clock += size
            at.append(clock)
            rows.append(np.concatenate([motor, outputs @ full.rise]))
    winding, shaft, *seen = (np.interp(times, at, row) for row in np.array(rows).T)
    along = part.elements.heat.reach / np.linalg.norm(part.elements.heat.reach)
    growth = truth.expansion * along @ np.array(seen[:3])
    return Course(times, shaft, winding, COLD + seen[-2], COLD + seen[7], COLD + seen[-1], growth)


def grown(link: Component, times: Array, **parameters: float) -> Array:
    """Elongation of a link on the motor during `WORK` in m, shape (times,)."""
    phases = [demand(each.duration, each.speed, each.torque, each.ambient_temperature) for each in WORK]
    run = integrate(
        join("Plant", {"motor": MOTOR, "link": link}, WIRES),
        phases,
        ["link.elongation"],
        every=600.0,
        parameters={f"link.{name}": value for name, value in parameters.items()},
    )
    return np.interp(times, run.time, run.values["link.elongation"])


def main(
    effect: Annotated[str, typer.Option(help="Hidden effect (`warmlink list`).")] = "joint_resistance",
    strength: Annotated[float, typer.Option(help="Of the effect, in SI units.")] = 0.3,
    mesh_size: Annotated[float | None, typer.Option(help="Of the elements in mm.")] = None,
    out: Annotated[Path, typer.Option(help="Folder for the FMU, the run and its diagnosis.")] = Path(
        "out/reduced_cell"
    ),
) -> None:
    """Compare three links in the cell, hide an effect in a run of the full elements, and diagnose it."""
    from warmlink.orchestration.reduction.part import write_fmu
    from warmlink.orchestration.report.reduction import remarks

    part = example_part(None if mesh_size is None else mesh_size / 1e3)
    times = np.arange(0.0, 3601.0, 600.0)
    full = full_course(part, Truth(), WORK, times).elongation
    reduced = grown(reduced_link("Reduced", part.model), times)
    slender = grown(SLENDER, times, tip_position=0.3302)
    print_table(
        f"{len(part.patterns)} temperatures, reduced to {part.model.order}",
        ("time [s]", "full [µm]", "reduced less full [nm]", "slender less full [µm]"),
        [
            (f"{t:g}", f"{1e6 * a:.3f}", f"{1e9 * (b - a):.2f}", f"{1e6 * (c - a):.3f}")
            for t, a, b, c in zip(times, full, reduced, slender, strict=True)
        ],
    )
    out.mkdir(parents=True, exist_ok=True)
    fmu, run = out / "MyLink.fmu", out / "run.csv"
    failed = write_fmu(part.model, remarks(part, "link.step"), fmu)
    answer(f"checks failed: {failed or 'none'}")
    columns = hide({effect: strength}, solver=lambda *given: full_course(part, *given))
    write_csv(columns, run)
    given = ["diagnose", str(run), "--replace", f"link={fmu}", "--out", str(out / "diagnosis")]
    cli.application(given)(given, standalone_mode=False)


if __name__ == "__main__":
    start(main)
