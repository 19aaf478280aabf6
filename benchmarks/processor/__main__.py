"""Exported laws as controllers on emulated processors: `python -m benchmarks.processor`."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, cast

import numpy as np
import typer
from rich.console import Console
from rich.table import Table

from benchmarks.command import start
from benchmarks.processor.board import TARGETS, Board, Cost, Target, built, missing_tools
from benchmarks.processor.slave import OnProcessor
from warmlink.controllers.export.core import Core
from warmlink.fmus.errors import InputError
from warmlink.orchestration.catalogue import controller
from warmlink.orchestration.closed_loop.load import load_scenario
from warmlink.orchestration.fmu_store import FmuStore
from warmlink.orchestration.machine.machine import COMPENSATOR
from warmlink.orchestration.master.algorithms.named import algorithm
from warmlink.orchestration.master.assembly import Assembly, assemble
from warmlink.orchestration.master.recording.result import Result
from warmlink.orchestration.master.run import simulate
from warmlink.orchestration.master.slaves.slave import Slave
from warmlink.orchestration.scenarios.scenario import Scenario, changed
from warmlink.orchestration.written.quantities import positive


@dataclass(frozen=True)
class Loop:
    """A law in the closed loop on a processor, and as the FMU.

    Attributes
    ----------
    code : bytes of code and constants
    cost : what it needed on the processor
    lost : largest difference of the correction from the FMU's, in m
    largest, largest_fmu : largest error of the tool point in m, with the processor and with the FMU
    """

    code: int
    cost: Cost
    lost: float
    largest: float
    largest_fmu: float


def closed_loop(scenario: Scenario, target: Target) -> Loop:
    """Run a scenario with its controller on a processor, and once more with the controller's FMU."""
    law = controller(scenario.controller.name)
    core = Core(law, scenario.controller.name, target.precision)
    system = scenario.system(scenario.files(FmuStore("native")))
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        code = built(core, target, folder)
        with Board(core, target, folder) as board:
            assembly = assemble(system)
            slaves: list[Slave] = [
                cast("Slave", OnProcessor(each, law, board)) if each.name == COMPENSATOR else each
                for each in assembly.slaves
            ]
            there = _simulated(replace(assembly, slaves=slaves), scenario)
    fmu = _simulated(assemble(system), scenario)
    correction, score = f"{COMPENSATOR}.correction", scenario.machine.roles.score
    return Loop(
        code,
        board.cost,
        float(np.abs(there[correction] - fmu[correction]).max()),
        *(float(np.abs(score.value(each.__getitem__)).max()) for each in (there, fmu)),
    )


def _simulated(assembly: Assembly, scenario: Scenario) -> Result:
    return simulate(
        assembly,
        scenario.stop_time,
        scenario.step_size,
        algorithm(scenario.master),
        stepping="plain",
        check_stability=False,
    )


def main(
    laws: Annotated[
        list[str] | None, typer.Argument(help="Controllers. Default: observer, observer_drift.")
    ] = None,
    scenario: Annotated[str, typer.Option(help="Scenario of the warm-up cell.")] = "stop_and_go",
    stop: Annotated[str, typer.Option(help="Simulated time.")] = "2 h",
) -> None:
    """Run exported laws on processors that qemu emulates: what a step costs, and what the precision loses."""
    lack = missing_tools()
    if lack is not None:
        raise InputError(lack)
    table = Table("law", "processor", *_COLUMNS, box=None, padding=(0, 1, 0, 0))
    for law in laws or ["observer", "observer_drift"]:
        asked = changed(load_scenario(scenario), law, mismatches=["noisy_sensors"])
        asked = replace(asked, duty=asked.duty.until(positive(stop, "s", "--stop")))
        for target in TARGETS:
            found = closed_loop(asked, target)
            table.add_row(law, f"{target.name} {target.precision}", *_cells(found))
    Console(width=110).print(table)
    print("instructions: most in a step, as qemu counts them; they are no time, and no hardware was touched")
    print("lost: largest difference of the correction from the FMU's; error: largest of the tool point")


_COLUMNS = ("instructions", "code [B]", "struct [B]", "stack [B]", "lost [µm]", "error [µm]", "FMU's [µm]")


def _cells(found: Loop) -> Sequence[str]:
    cost = found.cost
    counts = (f"{each:,.0f}" for each in (cost.instructions, found.code, cost.struct, cost.stack))
    return (*counts, *(f"{1e6 * each:.2g}" for each in (found.lost, found.largest, found.largest_fmu)))


if __name__ == "__main__":
    start(main)
