"""A straight bar of one-dimensional elements as a reduced link."""

import numpy as np
from scipy.linalg import eigh

from warmlink.fmus.component import Component
from warmlink.fmus.reduced_link.component import reduced_link
from warmlink.fmus.reduced_link.equations import ReducedModel

LENGTH, SECTION, PERIMETER = 0.3302, 0.0254 * 0.00635, 2 * (0.0254 + 0.00635)
MATERIAL = {
    "conductivity": 167.0,
    "density": 2713.0,
    "specific_heat": 892.0,
    "expansion_coefficient": 23.6e-6,
}
ERROR_GAIN = np.array([[1e-3, 2e-3, 3e-5, 2e-5], [4e-3, 5e-3, 6e-5, 5e-5], [7.0, 8.0, 0.9, 0.8]])


def bar_model(order: int) -> ReducedModel:
    """Bar of linear elements; heat enters at one end, the tool sits on the other, all faces are cooled."""
    step = LENGTH / (order - 1)
    pair, stiff = np.array([[2.0, 1.0], [1.0, 2.0]]) * step / 6, np.array([[1.0, -1.0], [-1.0, 1.0]]) / step
    mass, stiffness = np.zeros((order, order)), np.zeros((order, order))
    for i in range(order - 1):
        mass[i : i + 2, i : i + 2] += pair
        stiffness[i : i + 2, i : i + 2] += stiff
    base, tip = np.eye(order)[0], np.eye(order)[-1]
    cooling = PERIMETER * mass + SECTION * (np.outer(base, base) + np.outer(tip, tip))
    # Patterns whose mean square over the bar is 1, with conduction in none but each of them.
    rates, patterns = eigh(stiffness, mass / LENGTH)
    patterns[:, 0] = np.abs(patterns[:, 0])
    growth = mass.sum(axis=0)
    places, nodes = np.array([0, 0.5, 1, 1 / 6, 2 / 6, 3 / 6, 4 / 6, 5 / 6]), np.linspace(0, 1, order)
    sensors = np.array([[np.interp(place, nodes, node) for node in np.eye(order)] for place in places])
    return ReducedModel(
        material=MATERIAL,
        volume=SECTION * LENGTH,
        conduction=SECTION * rates,
        cooling=(patterns.T @ cooling @ patterns)[None],
        loads=patterns.T @ np.column_stack([base, tip, cooling.sum(axis=0)]),
        outputs=np.vstack([growth, np.zeros((5, order)), sensors]) @ patterns,
        reach=np.array([LENGTH, 0.0, 0.0]),
        initial=np.outer(np.linalg.solve(patterns, np.ones(order)), np.full(8, 1 / 8)),
        error_gain=ERROR_GAIN,
        discretisation=1e-3,
        conductivity_range=(100.0, 250.0),
        convection_range=(1.0, 60.0),
    )


def bar_link(order: int = 41) -> Component:
    """Component of the bar."""
    return reduced_link("BarLink", bar_model(order))
