"""Whether a reduced link keeps the bounds that it states, in random runs beside the full elements."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import numpy as np
import typer
from numpy.typing import NDArray

from benchmarks.command import start
from warmlink.fmus.component.instance import Instance
from warmlink.fmus.component.integrator import GAMMA
from warmlink.fmus.reduced_link.component import reduced_link
from warmlink.fmus.thermal_link.equations import STEFAN_BOLTZMANN
from warmlink.orchestration.console import answer
from warmlink.orchestration.progress import progress_bar

if TYPE_CHECKING:
    from warmlink.orchestration.reduction.part import Part

Array = NDArray[np.float64]

COLD = 295.15
AFTER_CHANGES = ((16, 1 / 16), (16, 1 / 8), (12, 1 / 4), (8, 1 / 2))
"""Number and size in s of the steps after each change of inputs; 10 s together, then steps of 1 s.

What 1 s after a jump is left of fast modes would otherwise be the integration's error, not the reduction's.
"""

FROM = 1.0
"""s after a change, from which on the bounds are meant, and compared at every step."""

NEUTRAL = ("emissivity", "hub_conductance", "tip_conductance", "hub_heat_capacity", "tip_heat_capacity")
"""Parameters that are 0 where nothing is said of them."""

BOUNDS = ("displacement", "rotation", "temperature")


@dataclass(frozen=True)
class Run:
    """Parameters of a run and its duty: for each segment its duration in s and the inputs."""

    parameters: Mapping[str, float]
    segments: tuple[tuple[int, Mapping[str, float]], ...]


@dataclass(frozen=True)
class Kept:
    """Largest errors of a run, m, rad and K, and the bounds stated at its end."""

    errors: Array
    bounds: Array

    @property
    def held(self) -> bool:
        """Whether every error is within its bound."""
        return bool(np.all(self.errors <= self.bounds))


def random_run(part: Part, seed: Sequence[int], seconds: int) -> Run:
    """Parameters within the range that a part was reduced for, and a duty of so many seconds."""
    random = np.random.default_rng(seed)
    within = part.within
    low, high = within.convection
    emissivity = random.uniform(0, 0.9)
    radiation = 4 * emissivity * STEFAN_BOLTZMANN * COLD**3
    top = high - radiation
    still = max(low - radiation, 0.1) + random.uniform() ** 2 * (top - low) / 2
    lever = float(np.linalg.norm(part.elements.heat.reach)) / 2
    parameters = {
        "conductivity": random.uniform(*within.conductivity),
        "density": within.material["density"] * random.uniform(0.8, 1.2),
        "expansion_coefficient": within.material["expansion_coefficient"] * random.uniform(0.8, 1.2),
        "convection_still": still,
        "convection_per_speed": random.uniform(0, top - still) / (4.0 * lever),
        "emissivity": emissivity,
        "hub_conductance": random.uniform() ** 4,
        "tip_conductance": random.uniform() ** 4,
        "hub_heat_capacity": 60 * random.uniform() ** 4,
        "tip_heat_capacity": 60 * random.uniform() ** 4,
        "reference_temperature": COLD,
    }
    segments = []
    while seconds > 0:
        length = min(seconds, int(random.integers(30, 400)))
        if seconds - length < 30:
            length = seconds
        seconds -= length
        inputs = {
            "heat_flow": 20 * random.uniform() * (random.uniform() > 0.3),
            "tip_heat_flow": random.uniform(-5, 5) * (random.uniform() > 0.5),
            "ambient_temperature": COLD + random.uniform(-8, 8),
            "tip_sink_temperature": COLD,
            "speed": random.uniform(0, 4) * (random.uniform() > 0.3),
        }
        segments.append((length, inputs))
    return Run(parameters, tuple(segments))


def compared(part: Part, run: Run) -> Kept:
    """Run the component and the full elements side by side, both by ROS2 in the same steps."""
    instance = Instance(reduced_link("Reduced", part.model))
    instance.set({**run.parameters, **run.segments[0][1]})
    instance.initialize()
    full = FullElements(part, run.parameters)
    largest, time = np.zeros(3), 0.0
    for seconds, inputs in run.segments:
        instance.set(inputs)
        full.drive(inputs)
        changed = time
        for count, size in (*AFTER_CHANGES, (seconds - 10, 1.0)):
            for _ in range(count):
                full.step(inputs["heat_flow"], size)
                instance.step(time, size)
                time += size
                if time >= changed + FROM:
                    largest = np.maximum(largest, _errors(part, run, instance, full.rise))
    return Kept(largest, np.array([instance.get(f"{kind}_error_bound") for kind in BOUNDS]))


class FullElements:
    """All temperatures of a part above 295.15 K, in the steps that a reduced link takes.

    These are of ROS2 with what `equations.solve` has in its matrix, so that what differs is the reduction's.

    Parameters
    ----------
    part : reduced
    values : parameters; what is not said of hub, tip and radiation is 0
    """

    def __init__(self, part: Part, values: Mapping[str, float]) -> None:
        heat = part.elements.heat
        self.rise = np.zeros(heat.integrals.size)
        self._loads = heat.loads
        self._solvers: dict[float, Callable[[Array], Array]] = {}
        self._values = values = {**dict.fromkeys(NEUTRAL, 0.0), **values}
        self._lever = float(np.linalg.norm(heat.reach)) / 2
        self._mass = values["density"] * part.within.material["specific_heat"] * heat.mass.tocsr()
        self._conduction = values["conductivity"] * heat.conduction.tocsr()
        self._cooling = sum(heat.cooling).tocsr()
        self._ends = heat.loads[:, :2]
        self._carried = np.array([values["hub_heat_capacity"], values["tip_heat_capacity"]])
        self._lost = np.array([values["hub_conductance"], values["tip_conductance"]])

    def drive(self, inputs: Mapping[str, float]) -> None:
        """Hold inputs from now on."""
        values = self._values
        h = values["convection_still"] + values["convection_per_speed"] * inputs["speed"] * self._lever
        h += 4 * values["emissivity"] * STEFAN_BOLTZMANN * COLD**3
        warmer = inputs["ambient_temperature"] - COLD
        self._decay = self._conduction + h * self._cooling
        self._inflow = h * warmer * self._loads[:, 2:].sum(axis=1) + self._ends @ [
            self._lost[0] * warmer,
            inputs.get("tip_heat_flow", 0.0)
            + self._lost[1] * (inputs.get("tip_sink_temperature", COLD) - COLD),
        ]

    def step(self, heat_flow: float, size: float) -> None:
        """Take a step of `size` in s with a heat flow in W."""
        solve = self._solver(size)
        # With the capacity matrix on both sides: ros2 solves for its product with the rates.
        gain = self._inflow + self._ends[:, 0] * heat_flow
        first = solve(gain - self._lose(self.rise))
        stored = self._mass @ first + self._ends @ (self._carried * (self._ends.T @ first))
        second = solve(gain - self._lose(self.rise + size * first) - 2 * stored)
        self.rise = self.rise + size * (1.5 * first + 0.5 * second)

    def _lose(self, rise: Array) -> Array:
        return np.asarray(self._decay @ rise + self._ends @ (self._lost * (self._ends.T @ rise)))

    def _solver(self, size: float) -> Callable[[Array], Array]:
        """Hub and tip, dense blocks of rank one, by Woodbury's formula."""
        from warmlink.orchestration.finite_elements.body import symmetric_factor

        if size not in self._solvers:
            factor = symmetric_factor(self._mass + GAMMA * size * self._conduction)
            columns = factor.solve(np.ascontiguousarray(self._ends))
            weights = (self._carried + GAMMA * size * self._lost)[:, None]
            small = np.linalg.solve(np.eye(2) + weights * (self._ends.T @ columns), weights * self._ends.T)

            def solve(right: Array) -> Array:
                plain = factor.solve(right)
                return np.asarray(plain - columns @ (small @ plain))

            self._solvers[size] = solve
        return self._solvers[size]


def _errors(part: Part, run: Run, instance: Instance, rise: Array) -> Array:
    """Distance of displacements [m] and rotations [rad], largest difference of temperatures [K]."""
    heat = part.elements.heat
    exact = np.concatenate([heat.outputs @ rise, heat.loads[:, :2].T @ rise])
    expansion = run.parameters["expansion_coefficient"]

    def vector(name: str, size: int) -> Array:
        return np.array([instance.get(f"{name}[{i}]") for i in range(1, size + 1)])

    temperatures = [
        *vector("sensor_temperature", 8),
        instance.get("base_temperature"),
        instance.get("tip_temperature"),
    ]
    return np.array(
        [
            np.linalg.norm(vector("displacement", 3) - expansion * exact[:3]),
            np.linalg.norm(vector("rotation", 3) - expansion * exact[3:6]),
            np.abs(np.array(temperatures) - COLD - exact[6:]).max(),
        ]
    )


def example_part(size: float | None = None, order: int | None = None) -> Part:
    """The example part, reduced for aluminium at the command's defaults; elements of a size in m."""
    from warmlink.orchestration.reduction.elements import Use
    from warmlink.orchestration.reduction.order import range_of
    from warmlink.orchestration.reduction.part import reduce_part
    from warmlink.orchestration.reduction.solid import HEAT_FACE, TOOL_POINT, ribbed_link

    with tempfile.TemporaryDirectory() as work:
        path = Path(work) / "link.step"
        ribbed_link(path)
        use = Use([HEAT_FACE], TOOL_POINT)
        return reduce_part(path, use, range_of("aluminium_6061"), size=size, order=order)


def main(
    runs: Annotated[int, typer.Option(help="Random parameter sets and duties.")] = 200,
    seed: Annotated[int, typer.Option(help="Of all random choices.")] = 1,
    seconds: Annotated[int, typer.Option(help="Length of a run in s, at least 30.")] = 1800,
    mesh_size: Annotated[float | None, typer.Option(help="Of the elements in mm.")] = None,
) -> None:
    """Compare bounds of the reduced example part with its errors in random runs of the full elements."""
    part = example_part(None if mesh_size is None else mesh_size / 1e3)
    kept = []
    with progress_bar("runs") as progress:
        for i in range(runs):
            kept.append(compared(part, random_run(part, [seed, i], seconds)))
            progress((i + 1) / runs)
    answer(
        f"order {part.model.order}, {len(part.patterns)} temperatures, {runs} runs of {seconds} s, "
        f"seed {seed}"
    )
    for i, name in enumerate(BOUNDS):
        ratios = np.array([each.bounds[i] / each.errors[i] for each in kept])
        answer(
            f"{name:13} held in {int((ratios >= 1).sum())} of {runs}; "
            f"bound over error: least {ratios.min():.3g}, median {np.median(ratios):.3g}, "
            f"largest {ratios.max():.3g}; largest error {max(each.errors[i] for each in kept):.3g}"
        )


if __name__ == "__main__":
    start(main)
