"""Thermal links on any grid in steady state and after a time, and the fins that they are compared with."""

import math
from collections.abc import Mapping

import numpy as np

from warmlink.fmus.component.instance import Instance
from warmlink.fmus.component.integrator import ComplexStepJacobian
from warmlink.fmus.component.reference import Phase, integrate
from warmlink.fmus.thermal_link.component import thermal_link
from warmlink.fmus.thermal_link.equations import stretches

COLD = 295.15
SECTION, PERIMETER = 0.0254 * 0.00635, 2 * (0.0254 + 0.00635)
K, RHO, C, ALPHA = 167.0, 2713.0, 892.0, 23.6e-6
DIFFUSIVITY = K / (RHO * C)


def flat(instance: Instance) -> tuple[np.ndarray, np.ndarray]:
    """Settled parameters and inputs of an instance."""
    component = instance.component
    p = np.array([instance.get(name) for name in component.p.names])
    return component.settled(p), np.array([instance.get(name) for name in component.u.names])


def steady(cells: int, values: Mapping[str, float]) -> Mapping[str, float]:
    """Outputs in steady state; the equations are linear, so that one Newton step finds it."""
    component = thermal_link(cells)
    instance = Instance(component)
    instance.set(values)
    p, u = flat(instance)
    x = component.states_at_start(u, p)

    def temperatures(z: np.ndarray) -> np.ndarray:
        return component.rates_of(np.append(z, 0.0), u, p, 0.0)[:-1]

    jacobian = ComplexStepJacobian(np.ones((cells, cells), dtype=bool))(temperatures, x[:-1])
    solution = x[:-1] - np.linalg.solve(jacobian, temperatures(x[:-1]))
    return dict(
        zip(component.y.names, component.outputs_of(np.append(solution, 0.0), u, p, 0.0), strict=True)
    )


def transient(cells: int, parameters: Mapping[str, float], inputs: Mapping[str, float], time: float) -> dict:
    """Outputs at a time, with no error but the grid's."""
    names = (
        "base_temperature",
        "tip_temperature",
        "sensor_temperature[4]",
        "elongation",
        "discretisation_error",
        "heat_received",
    )
    found = integrate(thermal_link(cells), [Phase(time, inputs)], names, every=time, parameters=parameters)
    return {n: float(found.values[n][-1]) for n in names}


def cells_with(between: int) -> int:
    """Count of cells that puts so many intervals between base and tip."""
    parts = ((n, stretches(n)) for n in range(between, 2 * between))
    return next(n for n, (base, tip) in parts if tip - base == between)


def order(errors: list[float]) -> float:
    """Observed order of errors on grids or steps halved from one to the next."""
    return math.log2(abs(errors[0] / errors[-1])) / (len(errors) - 1)


def fin_admittance(length: float, h: float) -> float:
    """Heat flow a kelvin into a fin that loses heat at its tip too, Holman eq. (2-34)."""
    m = math.sqrt(h * PERIMETER / (K * SECTION))
    ratio = h / (m * K)
    s, c = math.sinh(m * length), math.cosh(m * length)
    return K * SECTION * m * (s + ratio * c) / (c + ratio * s)


def fin_share(x: float, length: float, h: float) -> float:
    """Temperature rise over that at the root, Holman eq. (2-33 b)."""
    m = math.sqrt(h * PERIMETER / (K * SECTION))
    ratio = h / (m * K)
    rest = m * (length - x)
    return (math.cosh(rest) + ratio * math.sinh(rest)) / (
        math.cosh(m * length) + ratio * math.sinh(m * length)
    )


def fin_exact(base: float, tip: float, length: float, h: float, heat_flow: float) -> dict[str, float]:
    rise = heat_flow / (fin_admittance(base, h) + fin_admittance(length - base, h))
    x = np.linspace(0, tip - base, 4001)
    shares = np.array([fin_share(each, length - base, h) for each in x])
    mean = float(np.trapezoid(shares, x))
    return {
        "base_temperature": COLD + rise,
        "tip_temperature": COLD + rise * shares[-1],
        "sensor_temperature[2]": COLD + rise * fin_share((tip - base) / 2, length - base, h),
        "elongation": ALPHA * rise * mean,
    }
