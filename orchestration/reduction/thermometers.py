"""Where two thermometers tell most of the tool point: by the covariance of an observer that reads them.

The observer is the steady Kalman filter of motor and reduced link at rest, which does not know the heat that
a design of a controller takes for unknown (`Unknown`).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.linalg import solve_continuous_are

from warmlink.controllers.design.gains import Unknown
from warmlink.controllers.design.plant import INPUTS, Plant, plant_model
from warmlink.fmus.component.join import join
from warmlink.fmus.motor_heat_source.component import COMPONENT as MOTOR
from warmlink.fmus.plant import WIRES
from warmlink.fmus.reduced_link.component import reduced_link
from warmlink.fmus.reduced_link.model import ReducedModel
from warmlink.orchestration.arrays import Array

NOISE, SAMPLE_TIME = 0.1, 1.0
"""K (1 sigma) and s, of a reading."""

MODES = 12
"""Slowest modes of motor and link, which the filter is made of."""


def tool_error(model: ReducedModel) -> Callable[[Array], float]:
    """Error of the tool point in m (1 sigma) by rows that give, from a link's patterns, what is read in K."""
    joined = join("Plant", {"motor": MOTOR, "link": reduced_link("Link", model)}, WIRES)
    plant = plant_model(Plant(joined, {}, ("motor",), ("link",), {}, {"link.elongation": 1.0}))
    root = np.sqrt(plant.heat_capacity)
    rates, modes = np.linalg.eigh(root[:, None] * plant.A / root)
    slowest = np.argsort(-rates)[:MODES]
    rates, modes = rates[slowest], modes[:, slowest]
    heat = Unknown()
    size = np.array([heat.shaft_heat, heat.link_heat])
    time = np.array([heat.shaft_heat_time, heat.link_heat_time])
    heats = plant.B[:, [INPUTS.index("shaft_heat"), INPUTS.index("link_heat")]]
    state = np.diag([*rates, *(-1 / time)])
    state[:-2, -2:] = (modes.T * root) @ heats
    driven = np.diag([*np.zeros(len(rates)), *(2 * size**2 / time)])
    # From the link's patterns to the modes, and to the unknown heat that no row sees.
    link = np.pad((modes / root[:, None])[-model.order :], ((0, 0), (0, 2)))
    tool = model.material["expansion_coefficient"] * model.outputs[:3] @ link

    def error(rows: Array) -> float:
        noise = NOISE**2 * SAMPLE_TIME * np.eye(len(rows))
        covariance = solve_continuous_are(state.T, (rows @ link).T, driven, noise)
        return float(np.sqrt(np.trace(tool @ covariance @ tool.T)))

    return error


def best_pair(error: Callable[[Array], float], rows: Array) -> tuple[list[int], float]:
    """Numbers of the two places with the least error, and that error, one exchanged until none helps.

    `error` is as of `tool_error`, `rows` are for each place where a thermometer may sit, shape (n, order).
    """
    chosen, least = [0, 0], np.inf
    while True:
        before = least
        for i in range(2):
            errors = [error(rows[[chosen[1 - i], k]]) for k in range(len(rows))]
            chosen[i], least = int(np.argmin(errors)), min(errors)
        if least > 0.999 * before:
            return chosen, least
