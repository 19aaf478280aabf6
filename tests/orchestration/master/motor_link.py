"""Motor and link of DESIGN §3 as two slaves with exact sub-solvers, and as one system solved exactly.

Both are affine in their states while duty and ambient are constant, so that a step with inputs of degree
two in time is one multiplication with a matrix exponential.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from scipy.linalg import expm

from warmlink.orchestration.master.assembly import Assembly
from warmlink.orchestration.system.description import Capabilities

from .mock import ABLE, Inputs, MockSlave, real
from .pairs import wire

AMBIENT = 295.15
SPEED, TORQUE = 3.43, 2.5


def link_grid() -> tuple[np.ndarray, int, int]:
    base, tip, length = 0.0254, 0.3170, 0.3302
    x = np.concatenate(
        [np.linspace(0, base, 4), np.linspace(base, tip, 35)[1:], np.linspace(tip, length, 4)[1:]]
    )
    return x, 3, 37


def link_matrices() -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Give A, B (heat flow), c and the row of elongation; the last state is the heat received."""
    width, thickness, k, rho, c, alpha = 0.0254, 0.00635, 167.0, 2713.0, 892.0, 23.6e-6
    x, base, tip = link_grid()
    area, perimeter = width * thickness, 2 * (width + thickness)
    h = 4.55 + 6.4 * SPEED * (x[tip] - x[base]) / 2
    faces = np.concatenate([[x[0]], (x[1:] + x[:-1]) / 2, [x[-1]]])
    capacity = rho * c * area * np.diff(faces)
    loss = h * perimeter * np.diff(faces)
    loss[0] += h * area
    loss[-1] += h * area
    n = len(x)
    A = np.zeros((n + 1, n + 1))
    for i, conductance in enumerate(k * area / np.diff(x)):
        A[i, i] -= conductance / capacity[i]
        A[i, i + 1] += conductance / capacity[i]
        A[i + 1, i + 1] -= conductance / capacity[i + 1]
        A[i + 1, i] += conductance / capacity[i + 1]
    A[range(n), range(n)] -= loss / capacity
    B, offset = np.zeros(n + 1), np.zeros(n + 1)
    B[base], B[n] = 1 / capacity[base], 1.0
    offset[:n] = loss * AMBIENT / capacity
    row = np.zeros(n + 1)
    d = np.diff(x)[base:tip]
    row[base:tip] += alpha * d / 2
    row[base + 1 : tip + 1] += alpha * d / 2
    return A, B, offset, row


def motor_matrices(joint: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Give A, B (link base temperature) and c; states: winding, shaft, heat delivered."""
    cw, cs, gws, gsh, r, a = 200.0, 1500.0, 0.8, 1.0, 2.0, 0.0039
    current = (TORQUE / 1.2) ** 2
    iron, friction = 0.15 * SPEED**2, (1.5 + 0.6 * SPEED) * SPEED
    A = np.zeros((3, 3))
    A[0] = [(r * a * current - gws) / cw, gws / cw, 0]
    A[1] = [gws / cs, -(gws + gsh + joint) / cs, 0]
    A[2] = [0, joint, 0]
    B = np.array([0.0, joint / cs, -joint])
    c = np.array([(r * current * (1 - a * 293.15) + iron) / cw, (friction + gsh * AMBIENT) / cs, 0.0])
    return A, B, c


class Exact:
    """x' = A x + B u + c for u of degree two in time."""

    def __init__(self, A: np.ndarray, B: np.ndarray, c: np.ndarray) -> None:
        n = len(A)
        M = np.zeros((n + 4, n + 4))
        M[:n, :n], M[:n, n], M[:n, n + 1] = A, c, B
        M[n + 1, n + 2] = M[n + 2, n + 3] = 1.0
        self.M, self.n = M, n
        self.flow = lru_cache(maxsize=64)(lambda h: expm(M * h))

    def __call__(self, x: np.ndarray, u: tuple[float, float, float], h: float) -> np.ndarray:
        return self.flow(h)[: self.n] @ np.concatenate([x, [1.0], u])


@lru_cache(maxsize=64)
def flows(joint: float) -> tuple[Exact, Exact, np.ndarray]:
    """Give the sub-solvers, whose matrix exponentials are kept, and the row of elongation."""
    A, B, c, row = link_matrices()
    return Exact(*motor_matrices(joint)), Exact(A, B, c), row


def motor_link(
    joint: float = 1.0, capabilities: tuple[Capabilities, Capabilities] = (ABLE, ABLE)
) -> Assembly:
    motor_flow, link_flow, elongation = flows(joint)
    base = link_grid()[1]
    n = link_flow.n - 1

    def advance_motor(x: np.ndarray, u: Inputs, t: float, h: float) -> Any:
        return motor_flow(x, u.coefficients("link_base_temperature"), h)

    def advance_link(x: np.ndarray, u: Inputs, t: float, h: float) -> Any:
        return link_flow(x, u.coefficients("heat_flow"), h)

    motor = MockSlave(
        "motor",
        inputs={"link_base_temperature": AMBIENT},
        outputs={
            "heat_flow": lambda x, u, t: float(joint * (x[1] - u["link_base_temperature"])),
            "shaft_temperature": lambda x, u, t: float(x[1]),
            "heat_delivered": lambda x, u, t: float(x[2]),
        },
        feedthrough={"heat_flow": ["link_base_temperature"]},
        state=np.array([AMBIENT, AMBIENT, 0.0]),
        advance=advance_motor,
        variables=[
            real("link_base_temperature", "input", unit="K", nominal=300.0),
            real("heat_flow", "output", unit="W", nominal=5.0),
        ],
        capabilities=capabilities[0],
    )
    link = MockSlave(
        "link",
        inputs={"heat_flow": 0.0},
        outputs={
            "base_temperature": lambda x, u, t: float(x[base]),
            "elongation": lambda x, u, t: float(elongation[:n] @ (x[:n] - AMBIENT)),
            "heat_received": lambda x, u, t: float(x[n]),
        },
        state=np.concatenate([np.full(n, AMBIENT), [0.0]]),
        advance=advance_link,
        variables=[
            real("heat_flow", "input", unit="W", nominal=5.0),
            real("base_temperature", "output", unit="K", nominal=300.0),
            real("elongation", "output", unit="m", nominal=50e-6),
        ],
        capabilities=capabilities[1],
    )
    wires = (
        wire("motor.heat_flow -> link.heat_flow"),
        wire("link.base_temperature -> motor.link_base_temperature"),
    )
    return Assembly([motor, link], wires)


@lru_cache(maxsize=8)
def monolithic(joint: float, stop_time: float, step: float) -> np.ndarray:
    """Give the elongation in m at every multiple of `step`, exact in time."""
    Am, Bm, cm = motor_matrices(joint)
    Al, Bl, cl, row = link_matrices()
    base = link_grid()[1]
    n = len(Al) - 1
    A = np.zeros((2 + n, 2 + n))
    A[:2, :2], A[2:, 2:] = Am[:2, :2], Al[:n, :n]
    A[:2, 2 + base] += Bm[:2]
    A[2:, 1] += Bl[:n] * joint
    A[2:, 2 + base] -= Bl[:n] * joint
    flow = Exact(A, np.zeros(2 + n), np.concatenate([cm[:2], cl[:n]]))
    x = np.full(2 + n, AMBIENT)
    found = [0.0]
    for _ in range(round(stop_time / step)):
        x = flow(x, (0.0, 0.0, 0.0), step)
        found.append(float(row[:n] @ (x[2:] - AMBIENT)))
    return np.array(found)
