"""Runs unlike those that the diagnosis was made for, and what is right to say of each.

Every run has a duty cycle of its own, room temperatures that are logged row by row, and a fault drawn afresh:
rooms that wander beside their log, wrong logs, clocks and places, physics outside the catalogue. The truth is
computed by the solver in `practice/hidden.py`, which shares no equation with the fitted model.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warmlink.orchestration.diagnosis.practice.effects import CHANNELS, EFFECTS
from warmlink.orchestration.diagnosis.practice.hidden import COLD, Truth, simulate
from warmlink.orchestration.scenarios.duties.duty import Segment, demands_at, length
from warmlink.orchestration.system.units import ZERO_CELSIUS

Vector = NDArray[np.float64]
Table = dict[str, Vector]

LINK = ("base_temperature", "middle_temperature", "tip_temperature", "elongation")
TWINS = ("expansion_coefficient", "elongation_scale")


@dataclass(frozen=True)
class Hidden:
    """One run's secret.

    Attributes
    ----------
    truth : the cell as it really is
    names : right answers, each a set of causes written `a+b`; empty where no cause of the catalogue is right
    wander : standard deviation in K of the room's temperature about the logged one
    late : s by channel
    drift : of the recording's clock, relative
    mislogged : changes what was logged or read, in SI units
    """

    truth: Truth = field(default_factory=Truth)
    names: tuple[str, ...] = ()
    wander: float = 0.0
    late: Mapping[str, float] = field(default_factory=dict)
    drift: float = 0.0
    mislogged: Callable[[Table], None] = lambda table: None


Draw = Callable[[np.random.Generator], Hidden]


def _sign(random: np.random.Generator) -> float:
    return float(random.choice([-1.0, 1.0]))


def _changed(name: str, change: Callable[[Vector], Vector]) -> Callable[[Table], None]:
    return lambda table: table.update({name: change(table[name])})


def _known(random: np.random.Generator, count: int, weakest: float = 0.3) -> Hidden:
    """Effects of the catalogue, each of a strength drawn over about a decade."""
    pool = [n for n, e in EFFECTS.items() if not e.about]
    names = list(random.choice(pool, count, replace=False))
    if set(TWINS) <= set(names):
        names.remove(TWINS[0])
    truth, titles, late, on_readings = Truth(), [], {}, []
    for name in names:
        effect = EFFECTS[name]
        sign = _sign(random) if effect.both_signs else 1.0
        factor = np.exp(random.uniform(np.log(weakest), np.log(2.0)))
        size = effect.neutral + (effect.size - effect.neutral) * sign * factor
        channel = str(random.choice(CHANNELS)) if effect.per_channel else ""
        titles.append(f"{name}:{channel}" if channel else name)
        if effect.on_truth is not None:
            truth = effect.on_truth(truth, size, 7200.0)
        if effect.on_readings is not None:
            on_readings.append(partial(_on_readings, effect.on_readings, size, channel))
        if name == "clock_offset":
            late = dict.fromkeys((*CHANNELS, "elongation"), float(size))

    def mislogged(table: Table) -> None:
        for each in on_readings:
            each(table)

    alternatives = [titles, [TWINS[1 - TWINS.index(t)] if t in TWINS else t for t in titles]]
    right = tuple(dict.fromkeys("+".join(sorted(each)) for each in alternatives))
    return Hidden(truth, right, late=late, mislogged=mislogged)


def _on_readings(
    change: Callable[[Vector, Table, float, str], Vector], size: float, channel: str, table: Table
) -> None:
    table[channel or "elongation"] = change(table["time"], table, size, channel or "elongation")


def _of_effect(name: str) -> Draw:
    """An effect outside the catalogue."""
    effect = EFFECTS[name]

    def draw(random: np.random.Generator) -> Hidden:
        size = effect.size * random.uniform(0.5, 1.5)
        channel = str(random.choice(CHANNELS)) if effect.per_channel else ""
        if effect.on_truth is not None:
            return Hidden(effect.on_truth(Truth(), size, 7200.0))
        assert effect.on_readings is not None
        return Hidden(mislogged=partial(_on_readings, effect.on_readings, size, channel))

    return draw


def _joint(random: np.random.Generator) -> Hidden:
    return Hidden(
        Truth(joint=random.uniform(0.1, 0.6)), ("joint_resistance",), wander=random.uniform(0.05, 0.15)
    )


def _late_logger(random: np.random.Generator) -> Hidden:
    late = random.uniform(15, 60)
    return Hidden(late=dict.fromkeys(LINK[:3], late), names=("clock_offset:link",))


def _moved_sensors(random: np.random.Generator) -> Hidden:
    by = random.uniform(3e-3, 8e-3) * _sign(random)
    which = random.random(3) < 0.6
    which[random.integers(3)] = True
    names = "+".join(sorted(f"sensor_position:{c}" for c, w in zip(LINK[:3], which, strict=True) if w))
    base, middle, tip = (float(by * w) for w in which)
    return Hidden(Truth(shift=(base, middle, tip)), (names,))


def _scaled(name: str) -> Draw:
    def draw(random: np.random.Generator) -> Hidden:
        factor = 1 + random.uniform(0.03, 0.08) * _sign(random)
        return Hidden(names=(f"input_scale:{name}",), mislogged=_changed(name, lambda v: v * factor))

    return draw


def _crosstalk(random: np.random.Generator) -> Hidden:
    channel, size = str(random.choice(CHANNELS)), random.uniform(0.3, 1.0) * _sign(random)

    def mislogged(table: Table) -> None:
        table[channel] = table[channel] + size * table["torque"] / 1.2

    return Hidden(names=(f"crosstalk:{channel}",), mislogged=mislogged)


def _sticking_camera(random: np.random.Generator) -> Hidden:
    step = random.uniform(3e-6, 8e-6)

    def stick(values: Vector) -> Vector:
        held, out = values[0], values.copy()
        for i, value in enumerate(values):
            held = value if abs(value - held) > step else held
            out[i] = held
        return out

    return Hidden(mislogged=_changed("elongation", stick))


def _one_way_speed(random: np.random.Generator) -> Hidden:
    """A speed sensor that reads wrong in one direction, which the joint takes in some of its segments.

    Taken in all of them, it would be a speed log of another scale.
    """
    factor = 1 + random.uniform(0.1, 0.3) * _sign(random)

    def change(speed: Vector) -> Vector:
        segment = np.cumsum(np.diff(speed, prepend=speed[0]) != 0)
        moving = random.permutation(np.unique(segment[speed != 0]))
        wrong = moving[: random.integers(1, max(moving.size, 2))]
        return np.where(np.isin(segment, wrong), speed * factor, speed)

    return Hidden(mislogged=_changed("speed", change))


def _truth(names: tuple[str, ...], **ranges: tuple[float, float]) -> Draw:
    """Fields of the cell within ranges."""

    def draw(random: np.random.Generator) -> Hidden:
        drawn: dict[str, Any] = {name: random.uniform(*limits) for name, limits in ranges.items()}
        return Hidden(replace(Truth(), **drawn), names)

    return draw


LINES: dict[str, Draw] = {
    "nothing": lambda random: Hidden(),
    "room 0.05 to 0.15 K": lambda random: Hidden(wander=random.uniform(0.05, 0.15)),
    "joint_resistance and room": _joint,
    "link's logger late": _late_logger,
    "sensors moved 3 to 8 mm": _moved_sensors,
    "mixed convection": lambda random: Hidden(Truth(mixing=1.0), ("mixed_convection",)),
    "lubricant warms": _truth(("lubricant_thinning",), thinning=(0.01, 0.03)),
    # Over the speeds of a duty cycle a power is told by Coulomb and viscous friction, both unlike assumed.
    "viscous friction of a power": _truth(("coulomb_friction+viscous_friction",), viscous_power=(0.5, 0.8)),
    "torque log 3 to 8 %": _scaled("torque"),
    "speed log 3 to 8 %": _scaled("speed"),
    "clock drift": lambda random: Hidden(
        drift=random.uniform(0.003, 0.01) * _sign(random), names=("clock_drift",)
    ),
    "link's air warmer": _truth(("link_air_offset",), air_gap=(0.5, 2.0)),
    "current crosstalk": _crosstalk,
    "joint depends on temperature": _truth(("joint_temperature_dependence",), joint_slope=(0.008, 0.02)),
    "free convection": _truth(("free_convection",), free_exponent=(0.2, 0.33)),
    "one cause": lambda random: _known(random, 1),
    "two causes": lambda random: _known(random, 2, 0.6),
    "joint loosens": _of_effect("loosening_joint"),
    "draught": _of_effect("draught"),
    "bracket": _of_effect("bracket"),
    "brake heat": _of_effect("brake_heat"),
    "creep": _of_effect("creep"),
    "curved sensor": _of_effect("curved_sensor"),
    "gearbox mass": _truth(("hub_heat_capacity",), hub_capacity=(50, 150)),
    "camera sticks": _sticking_camera,
    "speed wrong one way": _one_way_speed,
}


def duty(random: np.random.Generator, lasts: float = 7200.0) -> tuple[Segment, ...]:
    """Work, rest and sometimes a pad, of random lengths."""
    parts = random.uniform(0.4, 1.6, int(random.integers(7, 13)))
    segments = []
    for part in np.round(parts * lasts / parts.sum()):
        rest = random.random() < 0.25
        speed = 0.0 if rest else round(float(random.uniform(0.5, 4.2)), 3)
        torque = 0.0 if rest and random.random() < 0.5 else round(float(random.uniform(0.3, 4.5)), 3)
        if random.random() < 0.1:
            segments.append(Segment.with_pad(part, COLD + float(random.uniform(10, 25)), speed, torque))
        else:
            segments.append(Segment(part, speed, torque))
    return tuple(segments)


def measured(hidden: Hidden, random: np.random.Generator, lasts: float = 7200.0) -> Table:
    """Columns of a run as a logger writes them, whose rows do not know when the duty cycle changes."""
    cycle = duty(random, lasts)
    lasts = length(cycle)
    step = float(random.choice([10.0, 15.0, 20.0]))
    rows = np.arange(0.0, lasts + 1e-6, step)
    if random.random() < 0.4:
        rows[1:-1] += random.uniform(-0.25, 0.25, rows.size - 2) * step
    grid = np.arange(0.0, lasts + 120.0, 30.0)
    swing, period = random.uniform(0.1, 1.0), random.uniform(4000, 12000)
    logged = swing * np.sin(2 * np.pi * grid / period) + random.uniform(-1, 1) * grid / lasts
    memory = np.exp(-30.0 / 600.0)
    wander = np.empty(grid.size)
    wander[0] = random.standard_normal()
    for i in range(1, grid.size):
        wander[i] = memory * wander[i - 1] + np.sqrt(1 - memory**2) * random.standard_normal()
    wander = hidden.wander * wander
    before = hidden.truth.room

    def room(at: float) -> float:
        return float(np.interp(at, grid, logged + wander)) + before(at)

    seen = {name: np.clip(rows * (1 + hidden.drift) - hidden.late.get(name, 0.0), 0, lasts) for name in ALL}
    times = np.unique(np.concatenate(list(seen.values())))
    course = simulate(replace(hidden.truth, room=room), list(cycle), times)
    true = dict(zip(ALL, (course.shaft, course.winding, *_of(course)), strict=True))
    demands = demands_at(cycle, rows)
    ambient = demands["ambient_temperature"] + np.interp(rows, grid, logged)
    table = {"time": rows, **demands, "ambient_temperature": ambient, "ambient": ambient}
    table |= {name: true[name][np.searchsorted(times, seen[name])] for name in ALL}
    hidden.mislogged(table)
    for name in ALL:
        sigma = 0.4e-6 if name == "elongation" else 0.08
        table[name] = table[name] + sigma * random.standard_normal(rows.size)
    return _as_columns(table)


ALL = (*CHANNELS, "elongation")


def _of(course: object) -> tuple[Vector, ...]:
    return tuple(getattr(course, name) for name in ("base", "middle", "tip", "elongation"))


def _as_columns(table: Table) -> Table:
    columns = {
        "time [s]": table["time"],
        "speed [rad/s]": table["speed"],
        "torque [N.m]": table["torque"],
        "pad_temperature [degC]": table["pad_temperature"] - ZERO_CELSIUS,
        "ambient_temperature [degC]": np.round(table["ambient_temperature"] - ZERO_CELSIUS, 3),
    }
    if np.isnan(columns["pad_temperature [degC]"]).all():
        del columns["pad_temperature [degC]"]
    columns |= {f"{name} [degC]": table[name] - ZERO_CELSIUS for name in CHANNELS}
    return columns | {"elongation [um]": table["elongation"] * 1e6}
