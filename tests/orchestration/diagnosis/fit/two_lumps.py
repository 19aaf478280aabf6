"""Logs of a motor on a bench that is two lumps of heat, of which all numbers are known."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
from scipy.linalg import expm

WINDING, SHAFT, BETWEEN, OUT = 60.0, 400.0, 2.0, 0.6
"""Heat capacities in J/K, conductances between the lumps and to the surroundings in W/K."""

NOISE = 0.05

_CHANNELS = """
[channels]
"wind" = "motor.winding_temperature"
"body" = "motor.shaft_temperature"
"ambient" = "motor.ambient_temperature"
[known]
"motor.joint_conductance" = "0 W/K"
"motor.winding_resistance" = "1 Ohm"
"motor.winding_temperature_coefficient" = "0 1/K"
"""

BOUNDS = {
    "motor.winding_heat_capacity": "5, 2000, 100 J/K",
    "motor.shaft_heat_capacity": "20, 9000, 600 J/K",
    "motor.winding_conductance": "0.01, 50, 1 W/K",
    "motor.housing_conductance": "0.001, 20, 1 W/K",
}
"""Least, largest and first value of what is calibrated."""


def log(duration: float = 3600.0, half: float = 600.0, step: float = 5.0) -> pd.DataFrame:
    """A run heated by 20 W for every other stretch of `half` s, from 22 degC on; solved exactly."""
    time = np.arange(0.0, duration, step)
    power = np.where(time % (2 * half) < half, 20.0, 0.0)
    rates = np.array([[-BETWEEN / WINDING, BETWEEN / WINDING], [BETWEEN / SHAFT, -(BETWEEN + OUT) / SHAFT]])
    decay = expm(rates * step)
    steady = np.linalg.solve(rates, np.array([1 / WINDING, 0.0]))
    rise = np.zeros((time.size, 2))
    for k in range(time.size - 1):
        aim = -steady * power[k]
        rise[k + 1] = aim + decay @ (rise[k] - aim)
    read = 22.0 + rise + np.random.default_rng(1).normal(0, NOISE, rise.shape)
    return pd.DataFrame(
        {
            "time [s]": time,
            "current [A]": np.sqrt(power),
            "ambient [degC]": 22.0,
            "wind [degC]": read[:, 0].round(3),
            "body [degC]": read[:, 1].round(3),
        }
    )


def experiment(folder: Path, table: pd.DataFrame, bounds: dict[str, str], more: str = "") -> Path:
    """Write a log and an experiment that calibrates some numbers on it."""
    table.to_csv(folder / "run.csv", index=False)
    lines = ['system = "BenchMotor"', 'initial = "nominal"', '[[run]]\ndata = "run.csv"', _CHANNELS, more]
    lines.append("[calibrate]")
    for name, text in bounds.items():
        numbers, unit = text.rsplit(" ", 1)
        least, most, start = (f'"{each.strip()} {unit}"' for each in numbers.split(","))
        lines.append(f'"{name}" = {{ min = {least}, max = {most}, start = {start} }}')
    path = folder / "bench.toml"
    path.write_text("\n".join(lines) + "\n")
    return path
