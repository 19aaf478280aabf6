"""The checks that load the FMU's library; each gives a verdict and a detail, or raises what it met."""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable
from pathlib import Path

from warmlink.orchestration.check.subject import Row, Subject, get, put, same, scale_of, start_of, within
from warmlink.orchestration.master.slaves.fmi import FmiSlave
from warmlink.orchestration.system.model import Variable

Outcome = tuple[str, str]
"""Verdict ("pass", "fail" or "skip") and detail."""

_LONGEST_EXPERIMENT = 10_000
_GROWTH_STEPS, _GROWTH_SECONDS = 1_000_000, 15.0
_GROWTH_ALLOWED = 1 << 20
"""Bytes; what a leak of one byte in each step adds up to in a million steps."""

_DERIVATIVE_TOLERANCE = 1e-4
_REACHES = (1e-4, 1e-6)
"""Steps to either side, as shares of an ordinary value of the input; the shorter one is for outputs that bend
sharply, as a norm does near 0."""
_POINTS = 4
"""Operating points at which outputs are perturbed."""


def default_experiment(subject: Subject) -> Outcome:
    """Every status is good and every output finite over the experiment that the FMU proposes."""
    planned = max(1, round((subject.stop_time - subject.start_time) / subject.step_size))
    count = min(planned, _LONGEST_EXPERIMENT)
    slave = subject.open()
    for index in range(count):
        slave.step(subject.start_time + index * subject.step_size, subject.step_size)
        for name, value in zip(subject.outputs, get(slave, subject.outputs), strict=True):
            if not math.isfinite(value):
                reached = subject.start_time + (index + 1) * subject.step_size
                return "fail", f"{name} is {value} at {reached:g} s"
    slave.terminate()
    part = "" if count == planned else f", the first {count} of {planned}"
    return "pass", f"{count * subject.step_size:g} s in steps of {subject.step_size:g} s{part}"


def state_restore(subject: Subject) -> Outcome:
    """What follows a restored state is bit for bit what followed it before, in a second instance too."""
    if not subject.info.capabilities.get_set_state:
        return "skip", "the FMU does not declare that it gets and sets its state"
    slave = subject.open()
    subject.run(slave, 0, 7)
    serializes = subject.info.capabilities.serialize_state
    state, copy = slave.state(), slave.serialize() if serializes else b""
    expected = subject.run(slave, 7, 20)
    slave.restore(state)
    if not _all_same(subject.run(slave, 7, 20), expected):
        return "fail", "20 steps after the restored state differ from those before"
    slave.free(state)
    if not serializes:
        return "pass", "20 steps after the restored state; serialisation is not declared"
    other = subject.open("restored")
    other.deserialize(copy)
    if not _all_same(subject.run(other, 7, 20), expected):
        return "fail", "20 steps of another instance, from the serialised state, differ"
    return "pass", "20 steps, also in another instance from the serialised state"


def dependencies(subject: Subject) -> Outcome:
    """No output moves with an input that it is not declared to depend on."""
    declared = _declared(subject)
    seen: set[tuple[str, str]] = set()
    slave = subject.open()
    for point in range(_POINTS):
        subject.run(slave, 5 * point, 5)
        values = subject.excitation(5 * point + 4)
        put(slave, values)
        before = get(slave, subject.outputs)
        for variable in subject.inputs:
            value = values.get(variable.name, start_of(variable))
            for moved in _moved(variable, value):
                put(slave, {variable.name: moved})
                after = get(slave, subject.outputs)
                seen |= {
                    (name, variable.name)
                    for name, a, b in zip(subject.outputs, before, after, strict=True)
                    if not same([a], [b])
                }
            put(slave, {variable.name: value})
    slave.terminate()
    open_to_all = [name for name, known in declared.items() if known is None]
    listed = {(name, each) for name, known in declared.items() for each in known or ()}
    hidden = sorted(pair for pair in seen - listed if pair[0] not in open_to_all)
    if hidden:
        output, known = hidden[0]
        return "fail", f"{output} moves with {known}, which it does not declare"
    text = f"{len(seen & listed)} of {len(listed)} declared pairs seen, none besides"
    if open_to_all:
        text += f"; {len(open_to_all)} outputs declare nothing, which means all"
    return "pass", text


def directional_derivatives(subject: Subject) -> Outcome:
    """Directional derivatives equal differences."""
    if not subject.info.capabilities.directional_derivatives:
        return "skip", "the FMU does not declare directional derivatives"
    declared = _declared(subject)
    slave = subject.open()
    compared, worst = 0, 0.0
    for point in range(_POINTS):
        subject.run(slave, 5 * point, 5)
        values = subject.excitation(5 * point + 4)
        put(slave, values)
        for variable in subject.inputs:
            if variable.name not in values:
                continue
            for output in subject.outputs:
                known = declared[output]
                if subject.info.variables[output].kind != "Real" or (
                    known is not None and variable.name not in known
                ):
                    continue
                given = slave.directional_derivative(output, variable.name)
                for reach in _REACHES:
                    slopes = _differences(slave, output, variable, values[variable.name], reach)
                    error = min(abs(given - slope) / max(abs(given), abs(slope), 1e-12) for slope in slopes)
                    if error <= _DERIVATIVE_TOLERANCE:
                        break
                if not error <= _DERIVATIVE_TOLERANCE:
                    what = f"d {output} / d {variable.name}"
                    return "fail", f"{what}: {given:g}, by differences {slopes[0]:g}"
                compared, worst = compared + 1, max(worst, error)
    slave.terminate()
    if not compared:
        return "pass", "no output depends directly on a real input"
    return "pass", f"{compared} compared with differences, to {worst:.1e}"


def second_instance(subject: Subject) -> Outcome:
    """An instance gives the same whether or not another runs beside it."""
    if subject.info.capabilities.once_per_process:
        return "skip", "the FMU declares that a process holds one instance"
    alone = subject.open("alone")
    expected = subject.run(alone, 0, 20)
    alone.terminate()
    first, second = subject.open("first"), subject.open("second")
    rows = []
    for index in range(20):
        rows += subject.run(first, index, 1)
        # The other one moves along other inputs.
        put(second, subject.excitation(index + 100))
        second.step(subject.start_time + index * subject.step_size, subject.step_size)
    second.terminate()
    if not _all_same(rows, expected):
        return "fail", "an instance differs when another runs beside it"
    first.terminate()
    return "pass", "20 steps beside another instance equal those alone"


def memory_growth(subject: Subject) -> Outcome:
    """Memory does not grow with the number of steps."""
    if not sys.platform.startswith("linux"):
        return "skip", "the process's memory is read where Linux shows it"
    slave = subject.open()
    size, start = subject.step_size, subject.start_time
    warm = 2000
    for index in range(warm):
        slave.step(start + index * size, size)
    before, began, count = _resident(), time.process_time(), 0
    while count < _GROWTH_STEPS and time.process_time() - began < _GROWTH_SECONDS:
        for index in range(warm + count, warm + count + 1000):
            slave.step(start + index * size, size)
        count += 1000
    grown = _resident() - before
    slave.terminate()
    short = "" if count == _GROWTH_STEPS else f", as many as {_GROWTH_SECONDS:g} s of the processor allowed"
    detail = f"{grown / 1024:.0f} KiB over {count} steps{short}"
    return ("pass" if grown <= _GROWTH_ALLOWED else "fail"), detail


def reproducible(subject: Subject) -> Outcome:
    """Two fresh instances on the same inputs give the same bits."""
    runs, slaves = [], []
    for name in ("once", "once"):
        slaves.append(subject.open(name))
        runs.append(subject.run(slaves[-1], 0, 50))
    for slave in slaves:
        slave.terminate()  # not before: the library is unloaded with its last instance
    if not _all_same(*runs):
        return "fail", "two runs of 50 steps on the same inputs differ"
    return "pass", "two runs of 50 steps on the same inputs are the same to the last bit"


CASES: dict[str, Callable[[Subject], Outcome]] = {
    "runs its default experiment": default_experiment,
    "state restore is bit-identical": state_restore,
    "dependencies proven by perturbation": dependencies,
    "directional derivatives": directional_derivatives,
    "second instance": second_instance,
    "memory growth": memory_growth,
    "reproducible": reproducible,
}
"""The checks by name, in the order in which they are made."""


def _declared(subject: Subject) -> dict[str, set[str] | None]:
    """Names of the inputs that each output declares to depend on; None where it says nothing."""
    known = {name: subject.info.dependencies.get(name) for name in subject.outputs}
    inputs = {variable.name for variable in subject.inputs}
    return {name: None if of is None else inputs.intersection(of) for name, of in known.items()}


def _moved(variable: Variable, value: float) -> list[float]:
    """Other values of an input: a little to both sides, or each other whole number."""
    if variable.kind == "Real":
        return [within(variable, value + part * scale_of(variable)) for part in (-0.01, 0.01, 0.5)]
    if variable.kind == "Boolean":
        return [1.0 - value]
    return [within(variable, value + change) for change in (-1, 1, 2)]


def _differences(slave: FmiSlave, output: str, variable: Variable, value: float, reach: float) -> list[float]:
    """Central, forward and backward difference, of which a derivative at a kink equals one."""
    step = reach * scale_of(variable)
    places = [within(variable, place) for place in (value - step, value, value + step)]
    found = []
    for place in places:
        put(slave, {variable.name: place})
        found.append(get(slave, (output,))[0])
    put(slave, {variable.name: value})
    pairs = ((0, 2), (1, 2), (0, 1))
    return [(found[b] - found[a]) / (places[b] - places[a]) for a, b in pairs if places[b] > places[a]]


def _all_same(rows: list[Row], others: list[Row]) -> bool:
    return all(same(a, b) for a, b in zip(rows, others, strict=True))


def _resident() -> int:
    """Bytes of memory that the process holds."""
    import resource

    return int(Path("/proc/self/statm").read_text().split()[1]) * resource.getpagesize()
