"""Closed-loop trials of a law: wrong models, failing instruments, and what is to be said of each run."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks.rollout import DEMANDS, Cell, Record, demand_table, library
from warmlink.controllers.design.plant import Plant, cell_plant
from warmlink.controllers.interface import SENSED
from warmlink.fmus import faults
from warmlink.fmus.motor_heat_source.component import COMPONENT as MOTOR
from warmlink.fmus.temperature_sensors.component import CHANNELS
from warmlink.fmus.thermal_link.component import COMPONENT as LINK
from warmlink.orchestration.scenarios.duties.duty import Duty

THERMAL: Mapping[str, tuple[str, ...]] = {
    "motor": (
        "winding_heat_capacity",
        "shaft_heat_capacity",
        "winding_conductance",
        "housing_conductance",
        "joint_conductance",
        "winding_resistance",
        "iron_loss_coefficient",
        "coulomb_friction",
        "viscous_friction",
    ),
    "link": ("conductivity", "specific_heat", "convection_still", "convection_per_speed"),
}
"""Parameters that a mismatch changes, besides the expansion coefficient."""

AS_MODELLED: Mapping[str, float] = {f"coefficient_spread[{i}]": 0.0 for i in range(1, 16)}
"""Start values of a law whose owner knows that the machine has the structure of the model."""

FILTER_ALONE: Mapping[str, float] = {**AS_MODELLED, "learnt": 1.0, "relative_std": 0.0, "duty_std": 1.0}
"""Start values with which an observer states its filter's error only, without what no thermometer shows."""

LONGEST = 3 * 3600.0
"""s of a duty cycle that a trial with a fault runs through at most."""

Values = dict[str, dict[str, float]]
"""Parameters by instance and name."""


def told_of_their_heat() -> list[Duty]:
    """Duty cycles whose heat the laws are told of; with a pad they are not, and say less on purpose."""
    pad = DEMANDS.index("pad_mode")
    return [duty for duty in library() if not demand_table(duty, 60.0)[:, pad].any()]


def mismatched(seed: int, share: float = 0.2, expansion_share: float = 0.03) -> Plant:
    """A plant whose thermal parameters are off by up to a share, and its expansion coefficient by another.

    Even seeds push every parameter to one end or the other, odd ones draw evenly in between; 0 is nominal.
    """
    if seed == 0:
        return cell_plant()
    draw = np.random.default_rng(seed)

    def factor(extent: float) -> float:
        end = float(draw.choice((-1.0, 1.0)))
        return 1 + extent * (end if seed % 2 == 0 else float(draw.uniform(-1, 1)))

    values: Values = {"motor": {}, "link": {}}
    for instance, component in (("motor", MOTOR), ("link", LINK)):
        starts = {parameter.name: parameter.start for parameter in component.parameters}
        for name in THERMAL[instance]:
            values[instance][name] = starts[name] * factor(share)
        if instance == "link":
            name = "expansion_coefficient"
            values[instance][name] = starts[name] * factor(expansion_share)
    return cell_plant(values["motor"], values["link"])


def instruments(seed: int, noise: float = 0.1) -> Values:
    """Parameters of sensors and camera: a noise in K, and seeds of their own."""
    sensors = {f"noise[{i}]": noise for i in range(1, CHANNELS + 1)}
    return {"sensors": {**sensors, "seed": float(seed)}, "camera": {"seed": float(seed)}}


@dataclass(frozen=True)
class Fault:
    """A fault of one instrument.

    Attributes
    ----------
    instrument : name of a temperature, or "camera"
    kind : as in `warmlink.fmus.faults`
    time : in s
    size, rate : of a jump, and of a drift a second, in K or m
    """

    instrument: str
    kind: int
    time: float
    size: float
    rate: float

    def applied(self, values: Values) -> Values:
        """Parameters with the fault added."""
        if self.instrument == "camera":
            instance, suffix = "camera", ""
        else:
            instance, suffix = "sensors", f"[{SENSED.index(self.instrument) + 1}]"
        added = {
            f"fault_kind{suffix}": float(self.kind),
            f"fault_time{suffix}": self.time,
            f"fault_size{suffix}": self.size,
            f"fault_rate{suffix}": self.rate,
        }
        return {**values, instance: {**values.get(instance, {}), **added}}


def random_fault(seed: int, duration: float, instruments: tuple[str, ...]) -> Fault:
    """A fault of any kind of one of the instruments, within the first four fifths of a duration in s.

    Jumps are from 0.5 to 20 K either way, drifts from 0.5 to 20 K an hour; the camera's 2 um for each kelvin.
    """
    draw = np.random.default_rng([seed, 1])
    instrument = str(draw.choice(instruments))
    unit = 2e-6 if instrument == "camera" else 1.0
    size, rate = (float(draw.choice((-1, 1)) * 10 ** draw.uniform(-0.3, 1.3)) for _ in range(2))
    kind = int(draw.integers(faults.STUCK, faults.DROPOUT + 1))
    return Fault(
        instrument, kind, float(round(draw.uniform(0, 0.8 * duration))), size * unit, rate * unit / 3600
    )


@dataclass(frozen=True)
class FaultRun:
    """One run with a fault, and what came of it.

    Attributes
    ----------
    worse_by : by how much in m the error was ever larger than the elongation itself, at one and the same time
    delay : time in s from the fault until the law distrusted a signal; None if it never did
    """

    seed: int
    duty: str
    fault: Fault
    worse_by: float
    delay: float | None


def fault_runs(
    cell: Cell, duties: Sequence[Duty], seeds: Iterable[int], with_camera: bool
) -> Iterator[FaultRun]:
    """Run a cell with one random fault a seed, in a duty cycle drawn for each.

    The fault falls on an instrument that the law goes by: the sensors it uses by default, and the camera if
    `with_camera`.
    """
    stds = {v.name: v.starts for v in cell.law.parameters}["sensor_std"]
    assert stds is not None
    used = tuple(name for name, std in zip(SENSED, stds, strict=True) if std > 0)
    if with_camera:
        used = (*used, "camera")
    for seed in seeds:
        duty = duties[int(np.random.default_rng([seed, 0]).integers(len(duties)))]
        duration = min(duty.stop_time, LONGEST)
        fault = random_fault(seed, duration, used)
        record = cell.run(demand_table(duty, cell.step, duration), fault.applied(instruments(seed + 1)))
        said = np.flatnonzero(record["distrusted"][round(fault.time / cell.step) :] > 0)
        delay = float(said[0] * cell.step) if said.size else None
        yield FaultRun(seed, duty.name, fault, worse_by(record), delay)


def removed_percent(record: Record) -> float:
    """Share in % of the largest elongation that the correction took out of the largest error."""
    return float(100 * (1 - np.abs(record.error).max() / np.abs(record["elongation"]).max()))


def worse_by(record: Record) -> float:
    """Largest excess in m of the error over the elongation at the same time; infinite for NaN."""
    excess = np.abs(record.error) - np.abs(record["elongation"])
    return float(excess.max()) if np.isfinite(excess).all() else float("inf")


def coverage(record: Record, sigmas: float = 2.0) -> float:
    """Share of the communication points at which the error lies within so many standard deviations."""
    return float(np.mean(np.abs(record.error) <= sigmas * record["correction_std"]))
