"""Heat in a slender link, and its growth: one-dimensional conduction with loss to the surroundings.

    rho c A dT/dt = d/dx(k A dT/dx) - P (h (T - T_a) + e s (T^4 - T_a^4)) + sources at base and tip

by finite volumes centred on nodes, two of which lie at base and tip position. Equation and loss terms:
J. P. Holman, *Heat Transfer*, 9th ed., McGraw-Hill 2002, chapters 2 and 4 (fins, transient conduction).
"""

from itertools import pairwise

from warmlink.fmus.component import Record, Values
from warmlink.fmus.component.arithmetic import (
    Number,
    absolute,
    clip,
    maximum,
    placed,
    sqrt,
    stack,
    total,
    where,
)

STEFAN_BOLTZMANN = 5.670374419e-8
"""W/(m2.K4), CODATA 2018."""

REFERENCE_TEMPERATURE = 295.15
"""K, at which materials that vary with temperature have their stated values."""

ORDINARY_RISE = 10.0
"""K over the surroundings, at which the coefficient of still air has its stated value."""

SENSORS = 8

SENSOR_SHARES = (0.0, 0.5, 1.0, *(i / (SENSORS - 2) for i in range(1, SENSORS - 2)))
"""Share of the way from base to tip at which each sensor sits by itself: at both, at the middle, between."""

SMALLEST_STRETCH = 1e-6
"""Least length of a stretch as a share of the link's; an overhang of no length keeps its nodes."""

TINY = 1e-30
"""(W/(m2.K))2 in place of 0, where a root has no slope."""


def derive(p: Record, cells: int) -> Values:
    """Values that follow from the parameters alone: conductances in W/K, capacities in J/K, areas in m2."""
    step = spacings(p, cells)
    places, width, section = positions(p, step), control_widths(step), cross_section(p)
    base, tip = stretches(cells)
    faces = placed(section, 0, cells) + placed(section, cells - 1, cells)
    carried = placed(p.hub_heat_capacity, base, cells) + placed(p.tip_heat_capacity, tip, cells)
    heat_capacity = p.density * p.specific_heat * section * width + carried
    return {
        "conductance": p.conductivity * section / step,
        "heat_capacity": heat_capacity,
        "rise_per_heat": 1 / heat_capacity,
        "surface_area": perimeter(p) * width + faces,
        "sensor_weight": stack(*(interpolation_weights(places, step, s) for s in sensor_positions(p))),
    }


def rates(x: Record, u: Record, p: Record, time: Number) -> Values:
    """Time derivatives of the states: temperatures in K/s, heat received in W."""
    cells = x.temperature.shape[0]
    base, tip = stretches(cells)
    flows = heat_flows(x, u, p, time)
    between = flows["conducted_heat_flow"]
    gain = (
        stack(0.0, between)
        - stack(between, 0.0)
        - flows["surface_heat_flow"]
        + placed(u.heat_flow - flows["hub_heat_flow"], base, cells)
        + placed(u.tip_heat_flow - flows["tip_sink_heat_flow"], tip, cells)
    )
    stores = 1 + p.specific_heat_temperature_coefficient * (x.temperature - REFERENCE_TEMPERATURE)
    return {"temperature": gain * p.rise_per_heat / stores, "heat_received": u.heat_flow}


def outputs(x: Record, u: Record, p: Record, time: Number) -> Values:
    """Temperatures in K, elongation in m, heat in W and J."""
    temperature, cells = x.temperature, x.temperature.shape[0]
    base, tip = stretches(cells)
    weights = [p.sensor_weight[i * cells : (i + 1) * cells] for i in range(SENSORS)]
    loss = surface_loss(temperature, u, p, ambient_temperature(u, p, time))
    return {
        "base_temperature": temperature[base],
        "tip_temperature": temperature[tip],
        "sensor_temperature": stack(*(total(weight * temperature) for weight in weights)),
        "elongation": elongation(temperature, p),
        "surface_heat_loss": total(loss),
        "heat_received": x.heat_received,
        "discretisation_error": discretisation_error(temperature, p),
    }


def heat_flows(x: Record, u: Record, p: Record, time: Number) -> Values:
    """Heat flows in W inside the link and out of it."""
    temperature = x.temperature
    base, tip = stretches(temperature.shape[0])
    ambient = ambient_temperature(u, p, time)
    middle = (temperature[1:] + temperature[:-1]) / 2
    change = 1 + p.conductivity_temperature_coefficient * (middle - REFERENCE_TEMPERATURE)
    # The sink at tip position is wired to the same log as the surroundings.
    sink = u.tip_sink_temperature + (ambient - u.ambient_temperature)
    return {
        "conducted_heat_flow": p.conductance * change * (temperature[:-1] - temperature[1:]),
        "surface_heat_flow": surface_loss(temperature, u, p, ambient),
        "hub_heat_flow": p.hub_conductance * (temperature[base] - ambient),
        "tip_sink_heat_flow": p.tip_conductance * (temperature[tip] - sink),
    }


def begin(u: Record, p: Record, cells: int) -> Values:
    """States at the start: the initial temperature plus the initial rises given at the sensors."""
    rise = initial_rise(p, positions(p, spacings(p, cells)))
    return {"temperature": p.initial_temperature + rise, "heat_received": 0.0}


def stretches(cells: int) -> tuple[int, int]:
    """Nodes at base and tip position, which cut the grid of so many nodes into three stretches.

    The overhangs get about the share of the intervals that they have of the nominal link.
    """
    intervals = cells - 1
    before, after = max(2, round(0.08 * intervals)), max(2, round(0.05 * intervals))
    return before, intervals - after


def spacings(p: Record, cells: int) -> Number:
    """Distances in m between neighbouring nodes, shape (cells - 1,)."""
    smallest = SMALLEST_STRETCH * p.length
    base, tip = stretches(cells)
    lengths = (
        (maximum(p.base_position, smallest), base),
        (p.tip_position - p.base_position, tip - base),
        (maximum(p.length - p.tip_position, smallest), cells - 1 - tip),
    )
    return stack(*(length / count for length, count in lengths for _ in range(count)))


def control_widths(step: Number) -> Number:
    """Length in m of the link that belongs to each node, shape (cells,), from the distances."""
    return (stack(0.0, step) + stack(step, 0.0)) / 2


def positions(p: Record, step: Number) -> Number:
    """Distances in m of the nodes from the end nearer the base, shape (cells,), from those between them."""
    intervals = step.shape[0]
    base, _ = stretches(intervals + 1)
    places = [p.base_position]
    for i in range(base - 1, -1, -1):
        places.insert(0, places[0] - step[i])
    for i in range(base, intervals):
        places.append(places[-1] + step[i])
    return stack(*places)


def interpolation_weights(places: Number, step: Number, place: Number) -> Number:
    """Weights of the nodes, shape (cells,), that interpolate linearly to a place in m."""
    share = clip((place - places[:-1]) / step, 0.0, 1.0)
    return stack(1.0, share) - stack(share, 0.0)


def cross_section(p: Record) -> Number:
    """Cross-section in m2: the given value, or else width times thickness."""
    return where(p.cross_section > 0, p.cross_section, p.width * p.thickness)


def perimeter(p: Record) -> Number:
    """Perimeter in m: the given value, or else that of the rectangle."""
    return where(p.perimeter > 0, p.perimeter, 2 * (p.width + p.thickness))


def convection_coefficient(u: Record, p: Record, lever: Number) -> Number:
    """Convection coefficient in W/(m2.K): that in still air combined with that due to the link's mean speed.

    Both combine as the cube root of the sum of their cubes (F. P. Incropera et al., *Fundamentals of Heat and
    Mass Transfer*, 6th ed., Wiley 2007, eq. 9.64), which is taken by one step of Newton from a root of
    squares, to within 0.1 %. `lever` is the distance in m from the joint's axis at which air is met.
    """
    still, moving = p.convection_still, p.convection_per_speed * absolute(u.speed) * lever
    whole = still + moving
    near = maximum(whole**2 - 2.4 * still * moving, TINY)
    cubic = (2 * sqrt(near) + (still**3 + moving**3) / near) / 3
    return whole - p.convection_mixing * (whole - cubic)


def ambient_temperature(u: Record, p: Record, time: Number) -> Number:
    """Ambient temperature in K: the input plus its offset and drift."""
    return u.ambient_temperature + p.ambient_offset + p.ambient_drift * time


def surface_loss(temperature: Number, u: Record, p: Record, ambient: Number) -> Number:
    """Heat flow in W that each node loses through its surface, shape (cells,)."""
    lever = (p.tip_position - p.base_position) / 2
    rise = temperature - ambient
    flux = (
        (convection_coefficient(u, p, lever) + p.convection_still * buoyancy(rise, p)) * rise
        + p.emissivity * STEFAN_BOLTZMANN * (temperature**4 - ambient**4)
        - p.absorbed_flux
    )
    return p.surface_area * flux


def buoyancy(rise: Number, p: Record) -> Number:
    """By how much the coefficient of still air is larger than at the ordinary rise, relative to that.

    Free convection goes with a power n of the rise (Holman, chapter 7). Of (rise / 10 K)^n this is the Pade
    approximant [3/3] about 10 K, for n up to 1/2 within 2.1 % from 1 to 60 K, without a power for each node.
    """
    n, x = p.convection_rise_exponent, absolute(rise) / ORDINARY_RISE
    inner = 3 * (9 - n**2)
    difference = (11 + n**2) * (x**3 - 1) + inner * (x**2 - x)
    outer = (1 - n) * (2 - n) * (3 - n) * x**3 + (1 + n) * (2 + n) * (3 + n)
    return 2 * n * difference / (outer + inner * ((2 - n) * x**2 + (2 + n) * x))


def elongation(temperature: Number, p: Record) -> Number:
    """Growth in m between base and tip position: expansion times the integral of what the rise counts.

    The trapezoidal rule with Gregory's first end correction, so that the integral is of third order in
    the node distance.
    """
    rise, last, step = _rise_between(temperature, p)
    inner = total(rise) - (rise[0] + rise[last]) / 2
    ends = (rise[1] - rise[0]) - (rise[last] - rise[last - 1])
    return p.expansion_coefficient * step * (inner + ends / 12)


def discretisation_error(temperature: Number, p: Record) -> Number:
    """Estimate in m of the elongation's error due to the grid.

    The size of the end correction: what the trapezoidal rule alone would miss, which bounds the error of
    the corrected rule and of the second-order temperatures.
    """
    rise, last, step = _rise_between(temperature, p)
    ends = absolute(rise[1] - rise[0]) + absolute(rise[last] - rise[last - 1])
    return p.expansion_coefficient * step * ends / 12


def sensor_positions(p: Record) -> list[Number]:
    """Places of the sensors in m; where -1 is given, those by `SENSOR_SHARES`."""
    span = p.tip_position - p.base_position
    return [
        where(p.sensor_position[i] < 0, p.base_position + share * span, p.sensor_position[i])
        for i, share in enumerate(SENSOR_SHARES)
    ]


def initial_rise(p: Record, places: Number) -> Number:
    """Rise in K above the initial temperature at places in m, linear between the sensors."""
    at = sensor_positions(p)
    known = _sorted_pairs([(place, p.initial_temperature_rise[i]) for i, place in enumerate(at)])
    rise = known[0][1]
    for (left, low), (right, high) in pairwise(known):
        share = (places - left) / maximum(right - left, 1e-12)
        rise = rise + clip(share, 0.0, 1.0) * (high - low)
    return rise


def _rise_between(temperature: Number, p: Record) -> tuple[Number, int, Number]:
    """Rise in K above the reference at the nodes from base to tip, the last one's index, their distance.

    Where expansion varies with temperature, a rise counts as much as the coefficient is larger over it.
    """
    base, tip = stretches(temperature.shape[0])
    reference = where(p.reference_temperature > 0, p.reference_temperature, p.initial_temperature)
    inside, last = temperature[base : tip + 1], tip - base
    middle = (inside + reference) / 2 - REFERENCE_TEMPERATURE
    rise = (inside - reference) * (1 + p.expansion_temperature_coefficient * middle)
    return rise, last, (p.tip_position - p.base_position) / last


def _sorted_pairs(pairs: list[tuple[Number, Number]]) -> list[tuple[Number, Number]]:
    """Pairs by rising first member, by a network of comparisons that expressions can pass through."""
    result = list(pairs)
    for end in range(len(result) - 1, 0, -1):
        for i in range(end):
            (a, low), (b, high) = result[i], result[i + 1]
            swap = a > b
            result[i] = (where(swap, b, a), where(swap, high, low))
            result[i + 1] = (where(swap, a, b), where(swap, low, high))
    return result
