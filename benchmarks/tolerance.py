"""Whether steps that follow the error keep a tolerance, and what they save."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np
import typer

from benchmarks.command import start
from benchmarks.own_systems import CHAIN, CHAIN_WIRES, Values, system
from warmlink.orchestration.console import answer
from warmlink.orchestration.master.algorithms.algorithm import Algorithm
from warmlink.orchestration.master.algorithms.explicit import GaussSeidel
from warmlink.orchestration.master.error_budget import attempted
from warmlink.orchestration.master.recording.result import Result
from warmlink.orchestration.master.run import simulate
from warmlink.orchestration.simulation import largest_step
from warmlink.orchestration.system.model import System

STOP, SHOWN = 7200.0, 60.0
WATCHED = ("link1.elongation", "link2.elongation")
STEPS = (60.0, 30.0, 20.0, 12.0, 10.0, 6.0, 5.0, 4.0, 3.0, 2.0, 1.0, 0.5, 0.25, 0.1, 0.05, 0.025)
"""Fixed steps tried, in s."""


@dataclass(frozen=True)
class Trial:
    """A random system: what was asked for, the true error, and steps, here and with a fixed step.

    `communication` are communication steps, repeated ones included; an iterated one takes several `steps` of
    FMUs.
    """

    tolerance_um: float
    error_um: float
    bound_um: float
    communication: int
    steps: int
    fixed_step: float | None
    fixed_steps: int
    follows: bool


def random_system(random: np.random.Generator) -> System:
    """Two motors with links, of random joints and lengths, in a random duty cycle, read every 30 or 60 s."""
    duty: dict[str, float] = {}
    count = int(random.integers(2, 7))
    for i in range(1, count + 1):
        works = random.random() < 0.7
        duty[f"duration[{i}]"] = float(np.round(random.uniform(300.0, 1800.0), 1))
        duty[f"segment_speed[{i}]"] = float(works * random.uniform(0.5, 5.0))
        duty[f"segment_torque[{i}]"] = float(works * random.uniform(0.0, 4.0))
        duty[f"segment_ambient_temperature[{i}]"] = float(random.uniform(285.0, 305.0))
    values: dict[str, dict[str, float]] = {"duty": duty, "sensors": {}}
    for number in (1, 2):
        length = random.uniform(0.2, 0.8)
        values[f"motor{number}"] = {"joint_conductance": float(10 ** random.uniform(-0.5, 1.3))}
        values[f"link{number}"] = {"length": length, "tip_position": 0.96 * length}
    values["sensors"]["sample_time"] = float(random.choice([30.0, 60.0]))
    sensed = {"sensors": "TemperatureSensors"}
    wires = (*CHAIN_WIRES, ("link1.base_temperature", "sensors.temperature[1]"))
    given: Values = values
    return system("Random", CHAIN | sensed, wires, given)


def trial(seed: int) -> Trial:
    """Run one random system with a random tolerance, and find the largest fixed step that keeps it too."""
    random = np.random.default_rng([20, seed])
    of, tolerance = random_system(random), float(10 ** random.uniform(-8.0, -6.3))
    allowed = dict.fromkeys(WATCHED, tolerance)
    truth = _truth(of)
    step = largest_step(of, STOP, SHOWN)

    def once(by: Algorithm, half: bool) -> Result:
        return simulate(
            of, STOP, step / (1 + half), by, record=WATCHED, check_stability=False, statistics=not half
        )

    found = attempted(GaussSeidel(), allowed, WATCHED, once)
    result = found.result
    fixed, fixed_steps = None, 0
    for size in STEPS:
        plain = simulate(of, STOP, size, GaussSeidel(), record=WATCHED, check_stability=False)
        fixed_steps = plain.statistics.slave_steps
        if _error(plain, truth) <= tolerance:
            fixed = size
            break
    return Trial(
        1e6 * tolerance,
        1e6 * _error(result, truth),
        1e6 * max(found.bounds.values()),
        # The duty cycle is in no loop: it takes each communication step once.
        next(each.calls["step"].count for each in result.statistics.slaves if each.name == "duty"),
        result.statistics.slave_steps,
        fixed,
        fixed_steps,
        not isinstance(found.algorithm, GaussSeidel),
    )


def _truth(of: System) -> np.ndarray:
    """Elongations every minute, from two fine runs and what their difference leaves (Richardson)."""
    runs = [simulate(of, STOP, step, GaussSeidel(), record=WATCHED) for step in (0.1, 0.05)]
    coarse, fine = map(_shown, runs)
    return 2 * fine - coarse


def _shown(result: Result) -> np.ndarray:
    if result.status != "completed":
        return np.full((len(WATCHED), round(STOP / SHOWN) + 1), np.inf)
    every = round((len(result.times) - 1) * SHOWN / STOP)
    return np.array([result[name][::every] for name in WATCHED])


def _error(result: Result, truth: np.ndarray) -> float:
    return float(np.max(np.abs(_shown(result) - truth)))


def bench(count: Annotated[int, typer.Option(help="Number of random systems.")] = 100) -> None:
    """Print how many tolerances are kept, and the steps beside those of the largest fixed step that does."""
    found = []
    for seed in range(count):
        one = trial(seed)
        found.append(one)
        answer(
            f"{seed:3d}  asked {one.tolerance_um:.3f} µm, true {one.error_um:.4f}, bound {one.bound_um:.4f}; "
            f"{one.communication} communication steps, {one.steps} of FMUs; with steps of {one.fixed_step} s "
            f"{STOP / (one.fixed_step or np.nan):.0f} and {one.fixed_steps}"
        )
    kept = sum(each.error_um <= each.tolerance_um for each in found)
    follow = [each for each in found if each.follows and each.fixed_step]
    answer(f"{kept} of {count} tolerances kept; {len(follow)} with steps that follow the error")
    for what, ratios in (
        ("communication steps", [each.communication * (each.fixed_step or 0.0) / STOP for each in follow]),
        ("steps of FMUs", [each.steps / each.fixed_steps for each in follow]),
    ):
        half = sum(ratio <= 0.5 for ratio in ratios)
        answer(
            f"{what}, as a share of those with the largest fixed step that keeps the tolerance: median "
            f"{np.median(ratios):.2f}, largest {max(ratios):.2f}, at most half in {half} systems"
        )


if __name__ == "__main__":
    start(bench)
