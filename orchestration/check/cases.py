"""The checks that load the FMU's library; each gives a verdict and a detail, or raises what it met."""

import itertools
import math
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from warmlink.orchestration.check.subject import CheckedInstance, Subject, scale, within
from warmlink.orchestration.master.slaves.slave import SlaveError
from warmlink.orchestration.system.model import FmuVariable

Outcome = tuple[str, str]
"""Verdict ("pass", "fail", "skip" or "remark") and detail."""

_LONGEST_EXPERIMENT = 10_000
_GROWTH_STEPS, _GROWTH_SECONDS = 1_000_000, 8.0
_ENOUGH = 200_000
"""Steps after which memory that has not grown at all is taken not to grow: a fiftieth of what is allowed
would show by then."""
_GROWTH_ALLOWED = 1 << 20
"""Bytes; what a leak of one byte in each step adds up to in a million steps."""

_DERIVATIVE_TOLERANCE = 1e-4
_REACHES = (1e-4, 1e-6)
"""Steps to either side, as shares of an ordinary value of the input; the shorter one is for outputs that bend
sharply, as a norm does near 0."""
_NOTHING_SHOWN = "skip", "the FMU has no output that is a number, by which to tell"
_POINTS = 4
"""Operating points at which outputs are perturbed."""


def default_experiment(subject: Subject) -> Outcome:
    """Every status is good and every output finite over the experiment that the FMU proposes."""
    size = subject.step_size
    planned = max(1, round((subject.stop_time - subject.start_time) / size))
    count = min(planned, _LONGEST_EXPERIMENT)
    instance, until = CheckedInstance(subject), time.monotonic() + subject.seconds
    for index in range(count):
        if time.monotonic() > until:
            count = index
            break
        try:
            instance.step(index)
        except SlaveError as fault:
            if not fault.asks_to_end_after(subject.start_time):
                raise
            return "pass", f"{index * size:g} s in steps of {size:g} s, where the FMU asks to end"
        for name, value in zip(subject.outputs, instance.outputs().tolist(), strict=True):
            if not math.isfinite(value):
                return "fail", f"{name} is {value} at {subject.time(index + 1):g} s"
    instance.slave.terminate()
    part = "" if count == planned else f", the first {count} of {planned}"
    return "pass", f"{count * size:g} s in steps of {size:g} s{part}"


def state_restore(subject: Subject) -> Outcome:
    """What follows a restored state is bit for bit what followed it before, in a second instance too."""
    if not subject.outputs:
        return _NOTHING_SHOWN
    if not subject.info.capabilities.get_set_state:
        return "skip", "the FMU does not declare that it gets and sets its state"
    instance = CheckedInstance(subject, goes_back=True)
    instance.run(0, 7)
    serializes = subject.info.capabilities.serialize_state and not subject.info.capabilities.once_per_process
    state, copy = instance.slave.state(), instance.slave.serialize() if serializes else b""
    expected = instance.run(7, 20)
    instance.slave.restore(state)
    if not _same(instance.run(7, 20), expected):
        return "fail", "20 steps after the restored state differ from those before"
    instance.slave.free(state)
    if not serializes:
        return "pass", "20 steps after the restored state; there is no other instance to serialise it to"
    other = CheckedInstance(subject, "restored", goes_back=True)
    other.slave.deserialize(copy)
    if not _same(other.run(7, 20), expected):
        return "fail", "20 steps of another instance, from the serialised state, differ"
    return "pass", "20 steps, also in another instance from the serialised state"


def dependencies(subject: Subject) -> Outcome:
    """No output moves with an input that it is not declared to depend on."""
    seen: set[tuple[str, str]] = set()
    if not (subject.inputs and subject.outputs):
        return "skip", "the FMU has no number as an input, or none as an output"
    instance = CheckedInstance(subject)
    for point in range(_POINTS):
        values = instance.arrive(point)
        before = instance.outputs()
        for variable in subject.inputs:
            value = values.get(variable.name, float(variable.start or 0))
            for moved in _moved(variable, value):
                instance.put({variable.name: moved})
                pairs = zip(subject.outputs, before, instance.outputs(), strict=True)
                seen |= {(name, variable.name) for name, a, b in pairs if not _same(a, b)}
            instance.put({variable.name: value})
    instance.slave.terminate()
    open_to_all = [name for name in subject.outputs if subject.info.dependencies.get(name) is None]
    limited = {name: subject.info.feedthrough(name) for name in subject.outputs if name not in open_to_all}
    listed = {(name, v.name) for name, known in limited.items() for v in subject.inputs if v.name in known}
    hidden = sorted(pair for pair in seen - listed if pair[0] in limited)
    if hidden:
        return "fail", "{} moves with {}, which it does not declare".format(*hidden[0])
    if not seen and (listed or open_to_all):
        return "remark", f"no output moved with any input: none of {len(listed)} declared pairs is proven"
    more = f"; {len(open_to_all)} outputs declare nothing, which means all" if open_to_all else ""
    return "pass", f"{len(seen & listed)} of {len(listed)} declared pairs seen, none besides{more}"


def directional_derivatives(subject: Subject) -> Outcome:
    """Directional derivatives equal differences."""
    if not subject.info.capabilities.directional_derivatives:
        return "skip", "the FMU does not declare directional derivatives"
    instance = CheckedInstance(subject)
    errors: list[float] = []
    pairs = [
        (variable, output)
        for variable in subject.inputs
        for output in subject.outputs
        if variable.kind == subject.info.variables[output].kind == "Real"
        and within(variable, -math.inf) < within(variable, math.inf)  # one that is held has no slope
        and variable.name in subject.info.feedthrough(output)
    ]
    for point in range(_POINTS):
        values = instance.arrive(point)
        for variable, output in pairs:
            given = instance.slave.directional_derivative(output, variable.name)
            for reach in _REACHES:
                slopes = _differences(instance, output, variable, values[variable.name], reach)
                error = min(abs(given - slope) / max(abs(given), abs(slope), 1e-12) for slope in slopes)
                if error <= _DERIVATIVE_TOLERANCE:
                    break
            else:
                return "fail", f"d {output} / d {variable.name}: {given:g}, by differences {slopes[0]:g}"
            errors.append(error)
    instance.slave.terminate()
    if not errors:
        return "skip", "no output depends directly on a real input"
    return "pass", f"{len(errors)} compared with differences, to {max(errors):.1e}"


def second_instance(subject: Subject) -> Outcome:
    """An instance gives the same whether or not another runs beside it."""
    if not subject.outputs:
        return _NOTHING_SHOWN
    if subject.info.capabilities.once_per_process:
        return "skip", "the FMU declares that a process holds one instance"
    alone = CheckedInstance(subject, "alone")
    expected = alone.run(0, 20)
    alone.slave.terminate()
    first, second = CheckedInstance(subject, "first"), _another(subject)
    for index, row in enumerate(expected):
        if not _same(first.run(index, 1)[0], row):
            return "fail", "an instance differs when another runs beside it"
        # The other one moves along other inputs, with other parameters.
        second.put(subject.excitation(index + 100))
        second.step(index)
    second.slave.terminate()
    first.slave.terminate()
    return "pass", "20 steps beside another instance equal those alone"


def _another(subject: Subject) -> CheckedInstance:
    """A second instance, with other parameters where the FMU takes them."""
    try:
        return CheckedInstance(subject, "second", parameters=subject.other_parameters())
    except SlaveError:
        return CheckedInstance(subject, "second")


def memory_growth(subject: Subject) -> Outcome:
    """Memory does not grow with the number of steps."""
    if not sys.platform.startswith("linux"):
        return "skip", "the process's memory is read where Linux shows it"
    instance = CheckedInstance(subject)
    steps = itertools.count()
    warm = time.monotonic() + subject.seconds
    for _ in range(2000):
        if time.monotonic() > warm:
            return "remark", f"{next(steps)} steps took {subject.seconds:g} s, too few to see it grow"
        instance.step(next(steps))
    before, began, count, planned = _resident(), time.process_time(), 0, _GROWTH_STEPS
    until = time.monotonic() + subject.seconds
    while count < planned and time.process_time() - began < _GROWTH_SECONDS and time.monotonic() < until:
        for _ in range(1000):
            instance.step(next(steps))
        count += 1000
        if count == _ENOUGH and _resident() <= before:
            planned = count
    grown = _resident() - before
    instance.slave.terminate()
    short = "" if count == planned else ", as many as the time allowed"
    detail = f"{grown / 1024:.0f} KiB over {count} steps{short}"
    return ("pass" if grown <= _GROWTH_ALLOWED else "fail"), detail


def reproducible(subject: Subject) -> Outcome:
    """Two fresh instances on the same inputs give the same bits."""
    if not subject.outputs:
        return _NOTHING_SHOWN
    if subject.info.capabilities.once_per_process:
        return "skip", "the FMU declares that a process holds one instance"
    instances, runs = [], []
    for _ in range(2):
        instances.append(CheckedInstance(subject, "once"))
        runs.append(instances[-1].run(0, 50))
    for instance in instances:
        instance.slave.terminate()  # not before: the library is unloaded with its last instance
    if not _same(*runs):
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


def _moved(variable: FmuVariable, value: float) -> list[float]:
    """Other values of an input: a little to both sides, whole numbers beside it, or each other item."""
    if variable.kind == "Boolean":
        return [1.0 - value]
    if variable.items:
        return [float(item) for item in variable.items.values() if item != value]
    parts, size = ((-0.01, 0.01, 0.5), scale(variable)) if variable.kind == "Real" else ((-1, 1, 2), 1)
    return [within(variable, value + part * size) for part in parts]


def _differences(
    instance: CheckedInstance, output: str, variable: FmuVariable, value: float, reach: float
) -> list[float]:
    """Central, forward and backward difference; a derivative at a kink equals one of them."""
    step = reach * scale(variable)
    places = [within(variable, place) for place in (value - step, value, value + step)]
    found = []
    for place in places:
        instance.put({variable.name: place})
        found.append(float(instance.slave.get((output,))[0]))
    instance.put({variable.name: value})
    pairs = ((0, 2), (1, 2), (0, 1))
    return [(found[b] - found[a]) / (places[b] - places[a]) for a, b in pairs if places[b] > places[a]]


def _same(a: Any, b: Any) -> bool:
    """Whether values are the same, NaN being itself."""
    return bool(np.array_equal(a, b, equal_nan=True))


def _resident() -> int:
    """Bytes of memory that the process holds."""
    import resource

    return int(Path("/proc/self/statm").read_text().split()[1]) * resource.getpagesize()
