"""A measured run, simulated again and again: what the fits ask for, and what goes in: inputs and a start."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from warmlink.fmus.errors import InputError
from warmlink.fmus.motor_heat_source.equations import PAD_POWER, PAD_TEMPERATURE
from warmlink.fmus.thermal_link.equations import SENSORS, sensor_positions
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.data.measured import Run, over_steps
from warmlink.orchestration.diagnosis.data.start import at_start
from warmlink.orchestration.diagnosis.model.integrator import Courses
from warmlink.orchestration.machine.rig import SCALE, Rig

PAD_OFF = 0


class NotSimulatedError(InputError):
    """A run that ended early, as it may with values of parameters far from their usual ones."""


@dataclass(frozen=True)
class SimulatedRun:
    """True outputs at times, shape (times, outputs), before any instrument reads them, and their slopes.

    `by_slot` are derivatives, shape (times, outputs, wanted), or (times, outputs, 0) where there are none.
    """

    values: Array
    slopes: Array
    by_slot: Array


class Simulation(ABC):
    """Simulates one run with other and other values of what may be freed.

    Parameters
    ----------
    rig : the system
    slots : what may be freed, by full name
    run : the measured run: its times and inputs
    known : value in SI by parameter or input, as far as it differs from the system's
    """

    def __init__(self, rig: Rig, slots: Sequence[str], run: Run, known: Mapping[str, float]) -> None:
        self.rig, self.slots, self.run = rig, tuple(slots), run
        self._known, self._table = known, input_table(rig, run, known)

    @property
    @abstractmethod
    def time(self) -> Array:
        """Points between steps in s, rising."""

    @abstractmethod
    def __call__(self, z: Array, times: Array, wanted: Sequence[int] | None = None) -> SimulatedRun:
        """Simulate with values of the slots in SI, shape (slots,); times in s within the run, rising.

        Derivatives are by the slots `wanted`, without by all of them: the fewer, the faster.
        """

    @abstractmethod
    def responses(self, z: Array, times: Array, courses: Courses) -> Array:
        """Derivatives of the outputs by the courses' values at the nodes, shape (times, outputs, values)."""

    @abstractmethod
    def sooner(self, z: Array, times: Array, rows: NDArray[np.int64], parts: int) -> SimulatedRun:
        """What each part of the time before a row adds, if the inputs of the row act from then on.

        It stands in place of the derivatives by slot, shape (times, outputs, rows * parts); of the parts of a
        row's time the last, which ends at it, comes first.
        """

    @abstractmethod
    def refine(self, z: Array) -> None:
        """Take anew what holds near some values of the slots alone: derivatives, and the length of steps."""

    def start_values(self) -> Array:
        """Values of the slots as the experiment has them, shape (slots,)."""
        return start_values(self.rig, self.slots, self._known, self._table)

    def current(self, times: Array) -> Array:
        """Current in A of the first motor as logged at times in s, shape (times,); 0 without one of ours."""
        inputs = self.rig.externals
        driven = [motor for motor in self.rig.called("motor") if f"{motor}.current" in inputs]
        if self.rig.in_loop or not driven:
            return np.zeros(times.size)
        name = f"{driven[0]}.torque_constant"
        constant = self._known.get(name, self.rig.variables[name].start)
        current, torque = (self._table[inputs.index(f"{driven[0]}.{each}")] for each in ("current", "torque"))
        return np.asarray((current + torque / constant)[self.run.row_at(times)])

    def ambient(self, times: Array) -> Array:
        """Ambient temperature in K at times in s, about the stems of sensors, shape (times,)."""
        if self.run.ambient is not None:
            return self.run.ambient[self.run.row_at(times)]
        given = (v for name, v in self._known.items() if name.endswith(".ambient_temperature"))
        return np.full(times.size, next(given, 295.15))


def start_values(rig: Rig, slots: Sequence[str], known: Mapping[str, float], table: Array) -> Array:
    """Values of slots as a run begins, shape (slots,), by what is known and the table of its inputs."""
    held = {name: float(rig.variables[name].start or 0.0) for name in rig.parameters}
    held |= {**known, **dict(zip(rig.externals, table[:, 0].tolist(), strict=True))}
    return np.array([held.get(slot, float(slot.startswith(SCALE))) for slot in slots])


def parts_before(run: Run, rows: NDArray[np.int64], parts: int) -> Array:
    """Times in s that divide the time before each of some rows, rising, shape (parts + 1, rows).

    The last part is half of the usual time between rows, also after a gap of the log; the others are even.
    """
    begin, end = run.time[rows - 1], run.time[rows]
    usual = np.minimum(end - begin, np.median(np.diff(run.time)))
    return np.vstack([np.linspace(begin, end - usual / 2, parts), end])


def halved(time: Array) -> Array:
    """Times with another one in the middle of each step."""
    return np.interp(np.arange(2 * time.size - 1) / 2, np.arange(time.size), time)


def input_table(rig: Rig, run: Run, known: Mapping[str, float]) -> Array:
    """Inputs that nothing in the rig feeds, held from row to row, shape (externals, rows).

    A room is not switched: in a gap of the log it has the mean of both ends.
    """
    begun = np.array([float(rig.variables[name].start or 0.0) for name in rig.externals])
    table = np.repeat(begun[:, None], run.time.size, axis=1)
    index = {name: i for i, name in enumerate(rig.externals)}
    given_here = given_inputs(rig, run, known)
    gaps = np.append(run.gaps, False)
    for name in index.keys() & known.keys():
        table[index[name]] = known[name]
    # A covariate is named without its instance.
    covariates = [(n, s) for c, s in run.covariates.items() for n in index if c in (n, n.rpartition(".")[2])]
    for name, signal in [*run.inputs.items(), *covariates]:
        for target in rig.fed_with(name, given_here):
            over_gaps = gaps & target.endswith("ambient_temperature")
            table[index[target]] = np.where(over_gaps, over_steps(signal), signal)
    for motor in rig.called("motor"):
        if f"{motor}.pad_temperature" in index:
            _switch_pad(motor, table, index, given_here, float(begun[index[f"{motor}.pad_temperature"]]))
    return table


def given_inputs(rig: Rig, run: Run, known: Mapping[str, float]) -> frozenset[str]:
    """Inputs with a column or a known value of their own."""
    return frozenset(run.inputs) | known.keys() & set(rig.externals)


def _switch_pad(
    motor: str, table: Array, index: Mapping[str, int], given_here: Collection[str], idle: float
) -> None:
    """Set the pad's mode from the given inputs of the pad, unless the mode itself is given.

    While it is off it has its `idle` temperature in K, which acts on nothing: one of 0 K would make the range
    of the input so large that no change of the pad's temperature counts as a leap.
    """
    pad, mode = f"{motor}.pad_temperature", f"{motor}.pad_mode"
    temperature = table[index[pad]]
    held = np.isfinite(temperature)
    if mode not in given_here and mode in index:
        by_power = PAD_POWER if f"{motor}.pad_power" in given_here else PAD_OFF
        table[index[mode]] = np.where(held & (pad in given_here), PAD_TEMPERATURE, by_power)
    table[index[pad]] = np.where(held, temperature, idle)


def initial_values(rig: Rig, run: Run, known: Mapping[str, float]) -> dict[str, float]:
    """Values of the parameters that set the initial temperatures, in SI.

    Along the link they are linear between the sensors; what was not measured takes the mean of what was.
    """
    read = {v: each for v, each in run.readings.items() if rig.unit(v) == "K" and v not in rig.sums}
    starts = {v: at_start(run.time, each) for v, each in read.items()}
    first = {variable: start for variable, start in starts.items() if start is not None}
    if not first:
        return {}
    mean = float(np.mean(list(first.values())))
    result: dict[str, float] = {}
    for motor in rig.called("motor"):
        shaft = first.get(f"{motor}.shaft_temperature", first.get(f"{motor}.winding_temperature", mean))
        result[f"{motor}.initial_shaft_temperature"] = shaft
        result[f"{motor}.initial_winding_temperature"] = first.get(f"{motor}.winding_temperature", shaft)
    at = {rig.on_link(variable): start for variable, start in first.items()}
    for link in rig.called("link"):
        here = {place[1]: start for place, start in at.items() if place and place[0] == link}
        result |= _along_link(rig, link, here, mean, known)
    for heater in rig.called("heater"):
        result[f"{heater}.initial_temperature"] = mean
    return result


def unread_starts(rig: Rig, run: Run) -> frozenset[str]:
    """Parameters that set temperatures at the start which no reading tells, as of a winding in its shaft."""
    return frozenset(
        f"{motor}.initial_{place}_temperature"
        for motor in rig.called("motor")
        for place in ("winding", "shaft")
        if f"{motor}.{place}_temperature" not in run.readings
    )


def _along_link(
    rig: Rig, link: str, measured: Mapping[int, float], mean: float, known: Mapping[str, float]
) -> dict[str, float]:
    component = rig.components[link]
    start = float(np.mean(list(measured.values()))) if measured else mean
    there = np.array([measured.get(i, start) for i in range(1, SENSORS + 1)])
    if measured and "sensor_position[1]" in component.p.index:  # a reduced link's are in its shape
        starts = [known.get(f"{link}.{n}", rig.variables[f"{link}.{n}"].start) for n in component.p.names]
        places = np.array(sensor_positions(component.p.read(np.array(starts, dtype=float))), dtype=float)
        order = sorted(measured, key=lambda i: places[i - 1])
        there = np.interp(places, [places[i - 1] for i in order], [measured[i] for i in order])
    rises = {f"{link}.initial_temperature_rise[{i}]": float(t - start) for i, t in enumerate(there, 1)}
    return {f"{link}.initial_temperature": start, **rises}
