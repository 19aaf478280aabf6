"""The truth behind a made-up run, by equations of its own: none of them is that of a shipped component.

Motor of two lumps on a rod by the method of lines: linear finite elements with lumped masses on a fine
mesh, integrated by LSODA with tight tolerances. Every effect that a run may hide is a field of `Truth`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np

from warmlink.fmus.errors import InputError
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.practice.hidden_terms import HiddenTerm
from warmlink.orchestration.scenarios.duties.duty import Segment

COLD = 295.15
"""K, at which a made-up run begins, and friction and the joint have their stated level."""


def _none(time: float) -> float:
    return 0.0


@dataclass(frozen=True)
class Truth:
    """A cell as it really is; the defaults are the nominal one. SI units.

    Functions of time stand for what changes during the run: `draught` multiplies the loss by one plus its
    value, `room` adds to the true ambient temperature, `bracket` takes heat in W from the middle of the
    link, `shaft_heat` gives heat in W to the shaft, `loosening` adds resistance in K/W to the joint.
    Viscous friction goes with the power `viscous_power` of the speed, and falls by `thinning`, an exponent
    in 1/K, as the shaft warms. `joint_slope` is that of the joint's conductance in 1/K; the link's air is
    warmer than the motor's by `air_gap` in K; `hub_capacity` in J/K sits at the base. By `mixing` free and
    forced convection combine as the cube root of cubes, not as their sum; the loss to still air goes with
    the power `free_exponent` of the rise over 10 K. `shift` moves the thermometers of base, middle and tip
    outward, in m. All begins at `start` in K; `terms` are heat by equations.
    """

    emissivity: float = 0.0
    still: float = 4.55
    per_speed: float = 6.4
    conductivity: float = 167.0
    conductivity_slope: float = 0.0
    capacity: float = 2713.0 * 892.0
    tip_capacity: float = 0.0
    tip_loss: float = 0.0
    hub_loss: float = 0.0
    flux: float = 0.0
    expansion: float = 23.6e-6
    resistance: float = 2.0
    iron: float = 0.15
    housing: float = 1.0
    winding_path: float = 0.8
    winding_capacity: float = 200.0
    shaft_capacity: float = 1500.0
    friction: float = 1.0
    coulomb: float = 1.5
    viscous: float = 0.6
    friction_slope: float = 0.0
    drag: float = 0.0
    standby: float = 0.0
    joint: float = 0.0
    ambient_offset: float = 0.0
    ambient_drift: float = 0.0
    draught: Callable[[float], float] = _none
    room: Callable[[float], float] = _none
    bracket: Callable[[float], float] = _none
    shaft_heat: Callable[[float], float] = _none
    loosening: Callable[[float], float] = _none
    thinning: float = 0.0
    viscous_power: float = 1.0
    joint_slope: float = 0.0
    air_gap: float = 0.0
    hub_capacity: float = 0.0
    mixing: float = 0.0
    free_exponent: float = 0.0
    shift: tuple[float, float, float] = (0.0, 0.0, 0.0)
    start: float = COLD
    terms: tuple[HiddenTerm, ...] = ()


LENGTH, WIDTH, THICKNESS = 0.3302, 0.0254, 0.00635
BASE, TIP = 0.0254, 0.3170
SECTION, PERIMETER = WIDTH * THICKNESS, 2 * (WIDTH + THICKNESS)
RADIATION = 5.670374419e-8


class Mesh:
    """Nodes of the rod, two of them at base and tip."""

    def __init__(self, elements: int = 120) -> None:
        parts = [(0.0, BASE), (BASE, TIP), (TIP, LENGTH)]
        counts = [max(3, round(elements * (b - a) / LENGTH)) for a, b in parts]
        pieces = [np.linspace(a, b, n + 1)[:-1] for (a, b), n in zip(parts, counts, strict=True)]
        self.x: Array = np.append(np.concatenate(pieces), LENGTH)
        self.size = np.diff(self.x)
        self.base, self.tip = counts[0], counts[0] + counts[1]
        self.share: Array = np.zeros(self.x.size)
        self.share[:-1] += self.size / 2
        self.share[1:] += self.size / 2
        self.area = PERIMETER * self.share
        self.area[[0, -1]] += SECTION
        self.middle = int(np.argmin(np.abs(self.x - (BASE + TIP) / 2)))

    def rise_integral(self, rise: Array) -> Array:
        """Integral from base to tip by Simpson's rule, shape (times,), of shape (times, nodes)."""
        from scipy.integrate import simpson

        span = slice(self.base, self.tip + 1)
        return np.asarray(simpson(rise[:, span], x=self.x[span], axis=1))

    def at(self, place: float, values: Array) -> Array:
        """Values at a place, linear between nodes, shape (times,)."""
        i = int(np.clip(np.searchsorted(self.x, place) - 1, 0, self.size.size - 1))
        s = (place - self.x[i]) / self.size[i]
        return (1 - s) * values[:, i] + s * values[:, i + 1]


@dataclass(frozen=True)
class Course:
    """What truly happened, at times in s: temperatures in K and elongation in m, shape (times,) each."""

    time: Array
    shaft: Array
    winding: Array
    base: Array
    middle: Array
    tip: Array
    elongation: Array


def simulate(truth: Truth, duty: list[Segment], times: Array, elements: int = 120) -> Course:
    """Integrate the cell through a duty cycle and give its true course at times in s."""
    from scipy.integrate import solve_ivp

    mesh = Mesh(elements)
    lags = sum(term.law.lag_count for term in truth.terms)
    state = np.full(mesh.x.size + 2 + lags, truth.start)
    state[mesh.base : mesh.base + lags] = 0.0
    found = np.empty((times.size, state.size))
    found[times <= 0] = state
    how: dict[str, Any] = {
        "method": "LSODA",
        "rtol": 1e-7,
        "atol": 1e-6,
        "lband": 3 + lags,
        "uband": 3 + lags,
    }
    how |= {"max_step": 120.0}
    start = 0.0
    for segment in duty:
        end = start + segment.duration
        inside = (times > start) & (times <= end + 1e-9)
        asked = np.minimum(times[inside], end)
        rates, at = _rates(truth, segment, mesh), np.union1d(asked, [end])
        with np.errstate(all="ignore"):
            first = min(1e-3, end - start)
            result = solve_ivp(rates, (start, end), state, t_eval=at, first_step=first, **how)
        if not result.success or not np.isfinite(result.y).all():
            raise InputError(
                f"effects: between {start:g} and {end:g} s the cell's temperatures grow beyond all bounds; "
                "give weaker effects, or of the other sign"
            )
        found[inside] = result.y.T[: asked.size]
        start, state = end, result.y[:, -1]
    motor = mesh.base + lags
    nodes = np.delete(found, np.s_[mesh.base : motor + 2], axis=1)
    base, middle, tip = (
        mesh.at(place + shift, nodes)
        for place, shift in zip((BASE, (BASE + TIP) / 2, TIP), truth.shift, strict=True)
    )
    growth = truth.expansion * mesh.rise_integral(nodes - truth.start)
    return Course(times, found[:, motor + 1], found[:, motor], base, middle, tip, growth)


def surroundings(truth: Truth, duty: Segment, time: float) -> float:
    """True ambient temperature in K at a time in s."""
    return duty.ambient_temperature + truth.ambient_offset + truth.ambient_drift * time + truth.room(time)


def convection(truth: Truth, duty: Segment) -> float:
    """Heat transfer coefficient of the link in W/(m2.K), before a draught."""
    return truth.still + truth.per_speed * duty.speed * (TIP - BASE) / 2


def combined(truth: Truth, duty: Segment, rise: Array) -> Array:
    """The same at rises in K, shape (nodes,), as free and forced convection combine."""
    free = truth.still * (np.abs(rise) / 10) ** truth.free_exponent
    forced = convection(truth, duty) - truth.still
    cubic = (free**3 + forced**3) ** (1 / 3)
    return np.asarray((1 - truth.mixing) * (free + forced) + truth.mixing * cubic)


def motor_rates(
    truth: Truth,
    duty: Segment,
    time: float,
    winding: float,
    shaft: float,
    base: float,
    air: float,
    added: Mapping[str, float] = MappingProxyType({}),
) -> tuple[tuple[float, float], float]:
    """Rates of winding and shaft in K/s, and the heat flow in W through the joint; temperatures in K.

    `added` is further heat in W by place, `shaft` or `winding`.
    """
    conductance = (1 + truth.joint_slope * (shaft - COLD)) / (1 + truth.joint + truth.loosening(time))
    into_link = conductance * (shaft - base)
    current = duty.torque / 1.2
    copper = truth.resistance * (1 + 0.0039 * (winding - 293.15)) * current**2
    iron = truth.iron * duty.speed**2
    level = truth.friction * (1 - truth.friction_slope * (shaft - COLD))
    viscous = truth.viscous * np.exp(-truth.thinning * (shaft - COLD)) * duty.speed**truth.viscous_power
    rubbing = level * (truth.coulomb + viscous) * duty.speed + truth.drag * duty.speed**3
    pad = 0.0 if np.isnan(duty.pad) else min(max(20 * (duty.pad - shaft), 0.0), 60.0)
    inward = truth.winding_path * (winding - shaft)
    warming = inward + rubbing + pad + truth.standby + truth.shaft_heat(time) + added.get("shaft", 0.0)
    copper += added.get("winding", 0.0)
    outward = truth.housing * (shaft - air) + into_link
    rates = (copper + iron - inward) / truth.winding_capacity, (warming - outward) / truth.shaft_capacity
    return rates, into_link


def _rates(truth: Truth, duty: Segment, mesh: Mesh) -> Callable[[float, Array], Array]:
    """Right-hand side for one segment; lags, winding and shaft stand before the base, to keep it banded."""
    b, places = mesh.base, {"base": mesh.base, "tip": mesh.tip}
    m = b + sum(term.law.lag_count for term in truth.terms)
    stored = truth.capacity * SECTION * mesh.share
    stored[mesh.tip] += truth.tip_capacity
    stored[b] += truth.hub_capacity

    def rates(time: float, state: Array) -> Array:
        winding, shaft = state[m], state[m + 1]
        rod = np.concatenate([state[:b], state[m + 2 :]])
        air = surroundings(truth, duty, time)
        seen = {
            **{"speed": duty.speed, "torque": duty.torque, "ambient_temperature": air},
            **{"shaft_temperature": shaft, "winding_temperature": winding, "base_temperature": rod[b]},
            **{"middle_temperature": rod[mesh.middle], "tip_temperature": rod[mesh.tip]},
        }
        added, lagging = _heat_of_terms(truth, seen, state[b:m], time)
        rise = rod - air - truth.air_gap
        middle = (rod[1:] + rod[:-1]) / 2 - COLD
        conductivity = truth.conductivity * (1 + truth.conductivity_slope * middle)
        flow = conductivity * SECTION * np.diff(rod) / mesh.size
        lost = combined(truth, duty, rise) * (1 + truth.draught(time)) * rise - truth.flux
        lost += truth.emissivity * RADIATION * (rod**4 - (air + truth.air_gap) ** 4)
        gain = -mesh.area * lost
        gain[:-1] += flow
        gain[1:] -= flow
        motor, into_link = motor_rates(truth, duty, time, winding, shaft, rod[b], air, added)
        for place, node in places.items():
            gain[node] += added.get(place, 0.0)
        gain[b] += into_link - truth.hub_loss * rise[b]
        gain[mesh.tip] -= truth.tip_loss * rise[mesh.tip]
        gain[mesh.middle] -= truth.bracket(time)
        slopes = gain / stored
        return np.concatenate([slopes[:b], lagging, motor, slopes[b:]])

    return rates


def _heat_of_terms(
    truth: Truth, seen: Mapping[str, float], lagged: Array, time: float
) -> tuple[dict[str, float], list[float]]:
    """Heat in W of hidden terms by place, and the time derivatives of their lags."""
    added: dict[str, float] = {}
    rates: list[float] = []
    for term in truth.terms:
        own = lagged[len(rates) : len(rates) + term.law.lag_count].tolist()
        added[term.into] = added.get(term.into, 0.0) + term.heat(seen, own, time)
        rates += term.lag_rates(seen, own, time)
    return added, rates
