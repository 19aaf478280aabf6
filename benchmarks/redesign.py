"""What a heat path that was found is worth: a compensator designed anew, measured on the machine itself."""

from __future__ import annotations

import os
import runpy
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from shutil import copytree
from tempfile import TemporaryDirectory
from typing import Annotated

import numpy as np
import typer

from benchmarks.command import start
from benchmarks.own_systems import (
    CHAIN,
    CHAIN_WIRES,
    CHANNELS,
    INPUTS,
    chain,
    experiment,
    measured,
    system,
    with_values,
    write_csv,
)
from warmlink.orchestration.closed_loop.outcome import run
from warmlink.orchestration.console import answer
from warmlink.orchestration.diagnosis.answer.extension import extended_values, write_ssp_of
from warmlink.orchestration.diagnosis.causes.declared import read_causes
from warmlink.orchestration.diagnosis.diagnose import diagnose_experiment, read
from warmlink.orchestration.fmu_store import FmuStore
from warmlink.orchestration.machine.heat_paths import with_paths
from warmlink.orchestration.studies.design import design
from warmlink.orchestration.system.assemble import read_system
from warmlink.orchestration.system.model import Value
from warmlink.orchestration.system.write import write_ssp

EXAMPLE = Path(__file__).parents[1] / "examples" / "machine_tool"

FLANGE = """
[[cause]]
name = "flange"
sentence = "The tip of the first link heats the second link through the flange."
check = "Put a thermometer on the flange."
adds = { conductance = "W/K", from = "link1.tip_temperature", to = "link2.base_temperature", \
into = "link2.heat_flow", out_of = "link1.tip_heat_flow" }
between = ["0 W/K", "5 W/K"]
[[cause]]
name = "gears"
sentence = "Gears beside the second link heat it."
check = "Look at the gears."
adds = { heat = "W", into = "link2.heat_flow", course = "with:motor1.speed" }
between = [0, 10]
[[cause]]
name = "paint"
sentence = "The second link is painted."
check = "Look at it."
frees = ["link2.emissivity"]
between = [0, 1]
"""
SCENARIO = """
system = "system.ssp"
duty = "windshield_wiper"
stop_time = "40 min"
step_size = "2 s"
[roles]
score = "link1.elongation + link2.elongation - compensator.correction"
"""
LAW_WIRES = (
    ("duty.torque", "motor2.torque"),
    *((f"duty.{name}", f"compensator.{name}") for name in ("speed", "torque", "ambient_temperature")),
    *((f"link1.{end}_temperature", f"compensator.{end}_temperature") for end in ("base", "tip")),
    ("motor1.shaft_temperature", "compensator.shaft_temperature"),
)


@dataclass(frozen=True)
class Redesign:
    """Cause that was said, its value in SI; largest errors in um without a law, designed before, after."""

    said: str
    value: float
    none: float
    before: float
    after: float


def redesigned(folder: Path, name: str, scenario: str, law: str) -> Redesign:
    """Diagnose `experiment.toml` of a folder, extend the system there, and design a law for both.

    Parameters
    ----------
    folder : with `real.ssp`, the machine, on which both designs are measured
    name : of the system, without its ending
    scenario : text of a scenario of it
    law : as `warmlink design` takes it
    """
    found = diagnose_experiment(read([folder / "experiment.toml"]))
    problem, best = found.assessment.problem, found.adopted.fit
    values = extended_values(problem, best)
    write_ssp_of(problem.experiment.rig, values, folder / "extended.ssp", FmuStore("native"))
    errors = []
    for each in ("real", name, "extended"):
        file = folder / f"{each}.toml"
        file.write_text(scenario.replace(f"{name}.ssp", f"{each}.ssp"), "utf-8")
        if each != "real":
            design(file, law, ["shaft", "base", "tip"]).write(file.with_suffix(".ssv"))
            outcome = run(folder / "real.toml", law, parameters=file.with_suffix(".ssv"))
            errors.append(outcome.metrics.max_abs_um)
    value = float(best.theta[-1]) if best.items else 0.0
    said = f"{found.verdict} {best.name}".strip()
    return Redesign(said, value, outcome.uncompensated.max_abs_um, *errors)


def of_chain(folder: Path, conductance: float, seed: int) -> Redesign:
    """Two motors and links with an observer, and a flange between them that nobody knows, in W/K."""
    kinds = {**CHAIN, "compensator": "ObserverCompensator"}
    base = system("Chain", kinds, (*CHAIN_WIRES, *LAW_WIRES), {"duty": chain().components["duty"].values})
    columns = {**INPUTS, **CHANNELS}
    experiment(folder, base, columns, FLANGE)
    flange = read_causes(folder / "causes.toml").paths["flange"]
    truth = with_values(with_paths(base, {"flange": flange})[0], _strength("flange", conductance))
    write_csv(measured(truth, columns, 0.05, seed), folder / "run.csv")
    write_ssp(truth, folder / "real.ssp")
    return redesigned(folder, "system", SCENARIO, "observer")


def of_machine_tool(folder: Path, conductance: float) -> Redesign:
    """The machine tool of the examples, with a spindle that nobody knows, and lubricant, in W/K."""
    copytree(EXAMPLE, folder, dirs_exist_ok=True)
    before = Path.cwd()
    os.chdir(folder)
    try:
        runpy.run_path("machine.py")
        real = read_system(Path("real.ssp"), folder / "unpacked")
        write_ssp(with_values(real, _strength("lubricant", conductance)), Path("real.ssp"))
        runpy.run_path("record.py")
    finally:
        os.chdir(before)
    return redesigned(folder, "machine", (folder / "machine.toml").read_text("utf-8"), "regression")


def _strength(name: str, conductance: float) -> dict[str, dict[str, Value]]:
    return {name: {"conductance": conductance}}


KINDS: dict[str, tuple[float, Callable[[Path, float, int], Redesign]]] = {
    "two links": (0.3, of_chain),
    "machine tool": (0.6, lambda folder, conductance, seed: of_machine_tool(folder, conductance)),
}
"""Usual conductance of the hidden heat path in W/K, and the trial."""


def main(
    runs: Annotated[int, typer.Option(help="Runs of each system.")] = 10,
    seed: Annotated[int, typer.Option(help="Seed of all random choices.")] = 0,
) -> None:
    """Hide a heat path of random conductance, and measure what a compensator designed anew gains."""
    for kind, (usual, trial) in KINDS.items():
        for i in range(runs):
            hidden = usual * float(np.exp(np.random.default_rng([seed, i]).uniform(-1.0, 1.0)))
            with TemporaryDirectory() as folder:
                found = trial(Path(folder), hidden, seed + i)
            answer(
                f"{kind}, {hidden:.3f} W/K: {found.said} {found.value:.3f} W/K; off by {found.none:.1f} um, "
                f"law of before {found.before:.1f} um, of the extended model {found.after:.1f} um"
            )


if __name__ == "__main__":
    start(main)
