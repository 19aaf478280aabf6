"""The truth behind a made-up run by 3-D finite elements: the link of hexahedra, the motor of two lumps.

The link is the paper's without holes, heated over its whole section at the base position, as the 1-D link is,
so that a run differs from one of the other solver by width and thickness alone. Link and motor exchange the
heat that flows through the joint; each step is repeated until both agree on it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields, replace
from functools import partial
from typing import Any

import numpy as np

from warmlink.fmus.arguments import argument
from warmlink.fmus.errors import InputError
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.practice import hidden
from warmlink.orchestration.diagnosis.practice.effects import EFFECTS, effect_of
from warmlink.orchestration.diagnosis.practice.hidden_terms import HiddenTerm
from warmlink.orchestration.diagnosis.practice.hide import INFORMATIVE, WHITE, Noise, hide
from warmlink.orchestration.finite_elements.body import Body
from warmlink.orchestration.finite_elements.transient import JUST_BEFORE, Fea, HeatDrive, HeatStepper
from warmlink.orchestration.paper.data import GEOMETRY, MATERIALS
from warmlink.orchestration.paper.mesh import bare_link
from warmlink.orchestration.progress import Progress, unseen
from warmlink.orchestration.scenarios.duties.duty import Segment

CARRIED = {
    *("emissivity", "still", "per_speed", "draught"),
    *("conductivity", "capacity", "expansion"),
    *("hub_loss", "joint", "loosening"),
    *("resistance", "iron", "housing", "winding_path", "winding_capacity", "shaft_capacity"),
    *("friction", "coulomb", "viscous", "viscous_power", "friction_slope", "thinning", "drag"),
    *("standby", "shaft_heat"),
    *("ambient_offset", "ambient_drift", "room"),
}
"""Fields of `Truth` that this solver has a term for: link's surface and material, joint, motor, room."""

LONGEST = 5.0
"""s, the longest step."""

SETTLED = 1e-6
"""W, within which link and motor agree on the heat flow through the joint."""


def hide_with_fea(
    effects: Mapping[str, float],
    duty: Sequence[Segment] = INFORMATIVE,
    noise: Noise = WHITE,
    interval: float = 10.0,
    seed: int = 0,
    progress: Progress = unseen,
    terms: Sequence[HiddenTerm] = (),
) -> dict[str, Array]:
    """Make a run that hides effects, by 3-D finite elements; arguments and result as of `hide`.

    InputError is raised where an effect is not known, or the finite elements have no term for it, as for
    heat by an equation, and
    MissingExtraError where scikit-fem is not installed.
    """
    if terms:
        raise InputError(
            f"term: the finite elements hide no heat by an equation; leave {argument('solver', 'fea')} out"
        )
    for name in effects:
        effect_of(name)
        if not carried(name.partition(":")[0]):
            possible = ", ".join(each for each in EFFECTS if carried(each))
            raise InputError(
                f"effect: the finite elements have no term for {name!r}; they can hide {possible}"
            )
    return hide(effects, duty, noise, interval, seed, solver=partial(simulate, progress=progress))


def carried(name: str) -> bool:
    """Whether the finite elements can hide an effect of this name, without a channel.

    All that it changes of the truth must be among `CARRIED`; what acts on the readings is hidden after the
    fact, whatever solved for the truth.
    """
    effect = EFFECTS[name]
    if effect.on_truth is None:
        return True
    nominal, changed = hidden.Truth(), effect.on_truth(hidden.Truth(), effect.size, 1.0)
    different = {f.name for f in fields(hidden.Truth) if getattr(nominal, f.name) != getattr(changed, f.name)}
    return different <= CARRIED


def simulate(
    truth: hidden.Truth,
    duty: list[Segment],
    times: Array,
    refinement: int = 2,
    longest: float = LONGEST,
    progress: Progress = unseen,
) -> hidden.Course:
    """Integrate the cell through a duty cycle and give its true course at times in s, linear between steps.

    `refinement` is into how many parts each element of `bare_link` is divided along each direction,
    `longest` the longest step in s; each segment is cut into equal ones, of order 2 but where something
    jumps within a step.
    """
    cell = _Cell(_body(truth, refinement))
    clock, rows, whole = [0.0], [cell.seen()], sum(each.duration for each in duty)
    for segment in duty:
        cell.enter(truth, segment)
        count = int(np.ceil(segment.duration / longest - 1e-9))
        begin, size = clock[-1], segment.duration / count
        for i in range(count):
            now = begin + i * size
            progress(f"{now / 60:.0f} min of {whole / 60:.0f} min simulated", now / whole)
            cell.advance(now, size)
            clock.append(begin + (i + 1) * size)
            rows.append(cell.seen())
    return hidden.Course(times, *(np.interp(times, clock, row) for row in np.array(rows).T))


def _body(truth: hidden.Truth, refinement: int) -> Body:
    """The link of a cell, on a mesh."""
    size: dict[str, Any] = {"length": hidden.LENGTH, "width": hidden.WIDTH, "thickness": hidden.THICKNESS}
    geometry = replace(GEOMETRY, **size, shaft_centre=hidden.BASE, diode_centre=hidden.TIP)
    link = replace(
        MATERIALS["link"],
        conductivity=truth.conductivity,
        specific_heat=truth.capacity / MATERIALS["link"].density,
        expansion_coefficient=truth.expansion,
        emissivity=truth.emissivity,
    )
    return bare_link(refinement, geometry, link)


class _Cell:
    """Link and motor at one time, and how they go on."""

    def __init__(self, body: Body) -> None:
        fea = Fea(body, displacement_order=1)
        self._model = fea.heat
        probes = [body.probes[name] for name in ("base", "middle", "tip")]
        self._observed = np.array([*probes, fea.elasticity.elongation_row])
        self._base = self._observed[0]
        self._field = np.full(self._model.size, hidden.COLD)
        self._motor = np.full(2, hidden.COLD)
        self._begin, self._size, self._first, self._last = 0.0, 1.0, 0.0, 0.0
        # Change of the flow that link and motor call for per change of the flow that is tried, W/W; it hardly
        # differs from step to step.
        self._answer = 0.0

    def enter(self, truth: hidden.Truth, segment: Segment) -> None:
        """Begin a segment of the duty cycle."""
        self._truth, self._segment = truth, segment
        steady = hidden.convection(truth, segment)
        drive = HeatDrive(
            lambda time: steady * (1 + truth.draught(time)),
            lambda time: hidden.surroundings(truth, segment, time),
            heat_flow=self._through_joint,
            radiation=truth.emissivity > 0,
        )
        self._stepper = HeatStepper(self._model, drive)

    def seen(self) -> Array:
        """Shaft, winding, base, middle and tip temperature in K, elongation in m, shape (6,)."""
        *temperatures, _ = self._observed @ self._field
        elongation = self._observed[3] @ (self._field - hidden.COLD)
        return np.array([self._motor[1], self._motor[0], *temperatures, elongation])

    def advance(self, time: float, size: float) -> None:
        """Step by `size` from `time`, both in s."""
        base = float(self._base @ self._field)
        self._begin, self._size = time, size
        self._first = self._flow(time, self._motor, base)
        tried: tuple[float, float] | None = None
        for _ in range(30):
            field = self._stepper.step(self._field, time, size)
            warmed = float(self._base @ field)
            motor = self._motor_after(time, size, base, warmed)
            surplus = self._flow(time + JUST_BEFORE * size, motor, warmed) - self._last
            if abs(surplus) < SETTLED:
                break
            if tried is not None and abs(self._last - tried[0]) > 100 * SETTLED:
                self._answer = 1 + (surplus - tried[1]) / (self._last - tried[0])
            tried = self._last, surplus
            self._last += surplus / (1 - self._answer)
        else:
            raise InputError(f"joint: link and motor do not agree at {time:g} s; take shorter steps")
        self._field, self._motor = field, motor

    def _through_joint(self, time: float) -> float:
        """Heat flow in W into the link, which runs straight from first to last over a step."""
        return self._first + (time - self._begin) / self._size * (self._last - self._first)

    def _flow(self, time: float, motor: Array, base: float) -> float:
        """Heat flow in W into the link at its base, what the hub loses there taken off."""
        _, through = self._motor_at(time, motor, base)
        air = hidden.surroundings(self._truth, self._segment, time)
        return through - self._truth.hub_loss * (base - air)

    def _motor_at(self, time: float, motor: Array, base: float) -> tuple[tuple[float, float], float]:
        """Rates of winding and shaft in K/s, and the heat flow in W through the joint."""
        air = hidden.surroundings(self._truth, self._segment, time)
        return hidden.motor_rates(self._truth, self._segment, time, motor[0], motor[1], base, air)

    def _motor_after(self, time: float, size: float, first: float, last: float) -> Array:
        """Winding and shaft after a step in which the base warms from `first` to `last` K: Runge-Kutta 4."""

        def rates(fraction: float, state: Array) -> Array:
            base = first + fraction * (last - first)
            return np.array(self._motor_at(time + min(fraction, JUST_BEFORE) * size, state, base)[0])

        y = self._motor
        k_1 = rates(0.0, y)
        k_2 = rates(0.5, y + size / 2 * k_1)
        k_3 = rates(0.5, y + size / 2 * k_2)
        k_4 = rates(1.0, y + size * k_3)
        return np.asarray(y + size / 6 * (k_1 + 2 * k_2 + 2 * k_3 + k_4))
