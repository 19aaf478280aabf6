"""Logs of made-up machines of other structure than warmlink's plant, a day in well under a second.

Nothing here is shared with the plant that the laws were designed for. Winding, rotor, gearbox, brake, tool
and flange are lumps between and around a plate of cells that conducts along and across and bends where its
two sides differ. The gearbox grows too, the joint has play, lubricant thins with warmth, a draught cools one
side, hot workpieces warm the tool. Parameters are drawn within 10 % of nominal values; thermometers have
noise, offset, lag and steps; the room's reading is biased.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

if TYPE_CHECKING:
    import pandas as pd

Array = NDArray[np.float64]

STEP = 5.0
"""s of an implicit Euler step; the log has a row for each second."""

COLUMNS, ROWS = 24, 3
"""Cells along the plate and across it."""

LUMPS = ("winding", "rotor", "gearbox", "brake", "flange", "tool")

STEFAN_BOLTZMANN = 5.67e-8

_NOMINAL: Mapping[str, float] = MappingProxyType(
    {
        "length": 0.2916,  # m
        "width": 0.0254,  # m
        "thickness": 0.00635,  # m
        "conductivity": 167.0,  # W/(m.K)
        "heat_capacity": 2.42e6,  # J/(m3.K)
        "expansion": 23.6e-6,  # 1/K
        "still_air": 4.55,  # W/(m2.K), each side
        "moving_air": 1.0,  # W.s/(m2.K.rad)
        "emissivity": 0.1,
        "copper_loss": 1.39,  # W/(N.m)2
        "coulomb": 1.5,  # N.m, friction in the gearbox
        "viscous": 0.6,  # N.m.s/rad
        "thinning": 0.011,  # 1/K
        "brake_power": 3.5,  # W while the brake is held open
        "winding_rotor": 0.8,  # W/K
        "rotor_gearbox": 4.0,
        "gearbox_flange": 4.0,
        "flange_plate": 2.0,
        "brake_rotor": 0.4,
        "rotor_room": 0.7,
        "gearbox_room": 0.3,
        "plate_tool": 0.3,
        "tool_room": 0.05,
        "winding_capacity": 200.0,  # J/K
        "rotor_capacity": 700.0,
        "gearbox_capacity": 800.0,
        "brake_capacity": 150.0,
        "flange_capacity": 60.0,
        "tool_capacity": 60.0,
        "gearbox_growth": 0.28e-6,  # m/K
        "tool_growth": 0.35e-6,  # m/K
        "bending_lever": 0.01,  # m
        "play": 0.25e-6,  # m to either side
    }
)


@dataclass(frozen=True)
class Demand:
    """What happens for some time: duration in s, speed in rad/s, torque in N.m, and what is around."""

    duration: float
    speed: float = 0.0
    torque: float = 0.0
    draught: float = 0.0  # W/(m2.K) on one side of the plate
    workpiece: float = 0.0  # W/K to a part at 60 degC in the gripper


@dataclass(frozen=True)
class Room:
    """Air around a machine: mean and daily swing in degC, drift in K/h, and how it wanders (1 sigma in K)."""

    mean: float = 22.0
    swing: float = 0.0
    drift: float = 0.0
    wander: float = 0.15

    def course(self, count: int, draw: np.random.Generator) -> Array:
        """Temperature in degC at each of so many steps."""
        hours = STEP * np.arange(count) / 3600
        share = np.exp(-STEP / 1800)
        noise = draw.normal(0.0, self.wander * np.sqrt(1 - share**2), count)
        daily = self.swing * np.sin(2 * np.pi * hours / 24)
        return self.mean + daily + self.drift * hours + lfilter([1.0], [1.0, -share], noise)


class Machine:
    """One machine: parameters drawn by a seed, within a share of the nominal ones."""

    def __init__(self, seed: int, share: float = 0.1) -> None:
        draw, self.seed = np.random.default_rng([seed, 45]), seed
        drawn = {name: value * (1 + share * draw.uniform(-1, 1)) for name, value in _NOMINAL.items()}
        drawn["expansion"] = _NOMINAL["expansion"] * (1 + 0.15 * share * draw.uniform(-1, 1))
        self.p: Mapping[str, float] = drawn
        self.offsets = draw.uniform(-0.1, 0.1, 5)
        self.lags = draw.uniform(2.0, 15.0, 5)
        self.stems = draw.uniform(0.0, 0.02, 5)
        self.air_bias = float(draw.uniform(-0.4, 0.4))
        self.duty_scale = 1 + draw.uniform(-0.02, 0.02, 2)
        cells = np.arange(len(LUMPS), len(LUMPS) + COLUMNS * ROWS)
        self.cells = cells.reshape(COLUMNS, ROWS)
        self.size = len(LUMPS) + cells.size
        capacity = [self.p[f"{name}_capacity"] for name in LUMPS]
        volume = self.p["length"] * self.p["width"] * self.p["thickness"] / cells.size
        self.capacity = np.append(capacity, np.full(cells.size, self.p["heat_capacity"] * volume))
        self.join()

    def join(self) -> None:
        """Take the parameters as they are now: what conducts between the nodes."""
        self._inside = self._conduction()
        self._solver: Callable[[float, float, float], tuple[Array, Array, Array]] = lru_cache(maxsize=256)(
            self._solved
        )

    def _conduction(self) -> Array:
        """Conductances in W/K between all nodes, as a matrix that gives heat flows in W by temperatures."""
        p, matrix = self.p, np.zeros((self.size, self.size))

        def joined(i: int, j: int, conductance: float) -> None:
            matrix[[i, j], [i, j]] -= conductance
            matrix[[i, j], [j, i]] += conductance

        at = {name: i for i, name in enumerate(LUMPS)}
        joined(at["winding"], at["rotor"], p["winding_rotor"])
        joined(at["rotor"], at["gearbox"], p["rotor_gearbox"])
        joined(at["rotor"], at["brake"], p["brake_rotor"])
        joined(at["gearbox"], at["flange"], p["gearbox_flange"])
        long, across = p["length"] / COLUMNS, p["width"] / ROWS
        for i in range(COLUMNS):
            for j in range(ROWS):
                if i + 1 < COLUMNS:
                    between = p["conductivity"] * across * p["thickness"] / long
                    joined(self.cells[i, j], self.cells[i + 1, j], between)
                if j + 1 < ROWS:
                    between = p["conductivity"] * long * p["thickness"] / across
                    joined(self.cells[i, j], self.cells[i, j + 1], between)
        weights = np.linspace(1.4, 0.6, ROWS) / ROWS  # the flange touches one side better: the plate bends
        for j in range(ROWS):
            joined(at["flange"], self.cells[0, j], p["flange_plate"] * weights[j])
            joined(at["tool"], self.cells[-1, j], p["plate_tool"] / ROWS)
        return matrix

    def _solved(self, speed: float, draught: float, workpiece: float) -> tuple[Array, Array, Array]:
        """Inverse of an implicit step's matrix, and conductances to the room and to a workpiece, in W/K."""
        p, room = self.p, np.zeros(self.size)
        room[LUMPS.index("rotor")] = p["rotor_room"] * (1 + 0.08 * speed)
        room[LUMPS.index("gearbox")] = p["gearbox_room"]
        room[LUMPS.index("tool")] = p["tool_room"] * (1 + 0.1 * speed)
        area = 2 * p["length"] * (p["width"] + p["thickness"]) / self.cells.size
        radiation = 4 * p["emissivity"] * STEFAN_BOLTZMANN * 300.0**3
        along = np.linspace(0.3, 1.7, COLUMNS)  # what is far from the joint moves faster
        for j in range(ROWS):
            film = p["still_air"] + radiation + p["moving_air"] * speed * along + draught * (j == 0)
            room[self.cells[:, j]] = film * area
        piece = np.zeros(self.size)
        piece[LUMPS.index("tool")] = workpiece
        matrix = np.diag(self.capacity / STEP + room + piece) - self._inside
        return np.asarray(np.linalg.inv(matrix)), room, piece

    def run(
        self, demands: list[Demand], seed: int, room: Room | None = None, since: Run | None = None
    ) -> Run:
        """Temperatures and growth through demands, from a cold start in the room's air, or on from a run.

        After a run the air goes on as `room` has it from there.
        """
        draw = np.random.default_rng([seed, 46])
        rows = [each for each in demands for _ in range(max(1, round(each.duration / STEP)))]
        before = 0 if since is None else since.steps
        air = (room or Room()).course(before + len(rows), draw)[before:]
        p, temperature = self.p, np.full(self.size, air[0]) if since is None else since.history[-1]
        history = np.empty((len(rows) + 1, self.size))
        history[0] = temperature
        winding, rotor, gearbox, brake = (LUMPS.index(n) for n in ("winding", "rotor", "gearbox", "brake"))
        for k, each in enumerate(rows):
            speed = abs(each.speed)
            inverse, to_room, to_piece = self._solver(speed, each.draught, each.workpiece)
            heat = self.capacity / STEP * temperature + to_room * air[k] + to_piece * 60.0
            copper = p["copper_loss"] * each.torque**2 * (1 + 0.0039 * (temperature[winding] - 20.0))
            thin = np.exp(-p["thinning"] * (temperature[gearbox] - 22.0))
            friction = (p["coulomb"] + p["viscous"] * thin * speed) * speed
            heat[winding] += copper
            heat[rotor] += 0.4 * friction
            heat[gearbox] += 0.6 * friction
            heat[brake] += p["brake_power"] * (speed > 0)
            temperature = inverse @ heat
            history[k + 1] = temperature
        return Run(self, rows, air, history, draw, before + len(rows))

    def growth(self, history: Array, torque: Array) -> Array:
        """Growth in m: of plate, gearbox and tool, by bending, and by play under load."""
        p, rise = self.p, history - 22.0
        plate = rise[:, self.cells]
        along = p["expansion"] * p["length"] * plate.mean(axis=(1, 2))
        slope = (plate[:, :, 0] - plate[:, :, -1]).mean(axis=1) / p["width"]
        bent = p["expansion"] * slope * p["length"] * p["bending_lever"]
        lumps = p["gearbox_growth"] * rise[:, LUMPS.index("gearbox")]
        lumps = lumps + p["tool_growth"] * rise[:, LUMPS.index("tool")]
        return np.asarray(along + bent + lumps + p["play"] * np.tanh(4 * (torque - 1.0)))


@dataclass(frozen=True)
class Run:
    """A run: demand and air of each step, temperatures in degC from the start, steps since a cold start."""

    machine: Machine
    rows: list[Demand]
    air: Array
    history: Array
    draw: np.random.Generator
    steps: int

    def log(self) -> pd.DataFrame:
        """What a logger would write each second; `growth` is the truth, `elongation` a probe's reading."""
        import pandas as pd

        machine, per = self.machine, round(STEP)
        count = len(self.rows) * per
        steps, seconds = per * np.arange(len(self.rows) + 1), np.arange(1, count + 1)
        torque = np.array([each.torque for each in self.rows])
        grown = machine.growth(self.history, np.append(torque[:1], torque))
        growth = 1e6 * np.interp(seconds, steps, grown)
        logged: dict[str, Any] = {"time [s]": seconds.astype(float)}
        for name, unit, scale in (("speed", "rad/s", 0), ("torque", "N.m", 1)):
            values = np.repeat([getattr(each, name) for each in self.rows], per)
            logged[f"{name} [{unit}]"] = (values * machine.duty_scale[scale]).round(4)
        air = np.interp(seconds, steps[1:], self.air)
        noise = self.draw.normal(0.0, 0.02, count)
        logged["ambient_temperature [degC]"] = (air + machine.air_bias + noise).round(3)
        for i, (name, true) in enumerate(self.places().items()):
            share = np.exp(-1.0 / machine.lags[i])
            exact = np.interp(seconds, steps, true)
            late = lfilter([1 - share], [1, -share], exact, zi=[share * exact[0]])[0]
            read = late - machine.stems[i] * (late - air) + machine.offsets[i]
            noisy = read + self.draw.normal(0.0, 0.1, count)
            logged[f"{name}_temperature [degC]"] = (16 * noisy).round() / 16
        logged["growth [um]"] = growth.round(4)
        probe = growth + self.draw.normal(0.0, 0.5, count)
        logged["elongation [um]"] = np.where(seconds % 60 == 1, probe.round(3), np.nan)
        return pd.DataFrame(logged)

    def places(self) -> dict[str, Array]:
        """True temperatures in degC where thermometers are, at each step."""
        plate = self.history[:, self.machine.cells].mean(axis=2)
        return {
            "shaft": self.history[:, LUMPS.index("rotor")],
            "winding": self.history[:, LUMPS.index("winding")],
            "base": plate[:, 1],
            "middle": plate[:, COLUMNS // 2],
            "tip": plate[:, -2],
        }


def _batches(work: float, pause: float, times: int, speed: float, torque: float) -> list[Demand]:
    return [each for _ in range(times) for each in (Demand(work, speed, torque), Demand(pause))]


def training() -> list[Demand]:
    """What an owner would run to learn a law: 2.5 h of work, 1 h of rest, 1.5 h of stop and go."""
    return [Demand(9000, 3.4, 2.5), Demand(3600), *_batches(600, 300, 6, 3.4, 2.5)]


def duty_cycles(seed: int) -> dict[str, tuple[list[Demand], Room]]:
    """Duty cycles that a law is judged on, each with the air around it."""
    draw = np.random.default_rng([seed, 47])
    random = [
        Demand(float(draw.uniform(120, 1500)), *draw.uniform((0, 0.2), (4.4, 3.6)) * (draw.uniform() > 0.25))
        for _ in range(30)
    ]
    shift = [
        Demand(7200, 3.4, 2.6),
        Demand(900),
        Demand(7200, 3.4, 2.6),
        Demand(1800),
        Demand(5400, 3.4, 2.6),
    ]
    windy = [replace(each, draught=25.0 * (i % 2)) for i, each in enumerate([Demand(2400, 3.0, 2.4)] * 8)]
    hot = [replace(each, workpiece=0.06) for each in _batches(1500, 120, 10, 2.6, 2.2)]
    return {
        "continuous": ([Demand(14400, 3.4, 2.5)], Room()),
        "start_stop": (_batches(60, 60, 120, 3.4, 2.8), Room()),
        "fast_light": ([Demand(14400, 4.4, 0.8)], Room()),
        "slow_heavy": ([Demand(14400, 1.0, 3.7)], Room()),
        "holding": ([Demand(7200, 0.0, 3.0), Demand(7200, 3.4, 1.5)], Room()),
        "heavy_shift": (shift, Room()),
        "small_batches": (_batches(420, 900, 14, 3.0, 2.4), Room()),
        "random_shift": (random, Room(drift=0.3)),
        "draught": (windy, Room()),
        "hot_workpieces": (hot, Room()),
        "summer": (shift, Room(mean=29.0, drift=0.4)),
        "winter": (shift, Room(mean=16.0, drift=0.5)),
        "overnight": ([*shift, Demand(36000), *shift], Room(swing=2.0)),
    }


def logs(seed: int) -> Iterator[tuple[str, pd.DataFrame]]:
    """The log to learn from, `training`, and those to be judged on, of the machine of a seed."""
    machine = Machine(seed)
    yield "training", machine.run(training(), 1000 * seed).log()
    for i, (name, (demands, room)) in enumerate(duty_cycles(seed).items(), 1):
        yield name, machine.run(demands, 1000 * seed + i, room).log()
