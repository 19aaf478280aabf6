"""C of a joined component that goes through whole runs in one call.

Parts that nothing drives and that remember nothing, as a duty cycle, become a table over time. The others are
joined without them, and step and sample as in an FMU. What a step needs of its inputs and size alone, as the
factors of its matrix, is kept until they change; what samples and record need of the same states is shared.
"""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from warmlink.fmus.component import Component, Input, Parameter
from warmlink.fmus.component.arithmetic import LARGEST
from warmlink.fmus.component.join import join
from warmlink.fmus.component.limits import BOUND_TOLERANCE, ordinary_size
from warmlink.fmus.errors import InputError
from warmlink.fmus.packaging.native.c_code import functions_text
from warmlink.fmus.packaging.native.casadi_code import (
    Expression,
    Function,
    Symbols,
    apart,
    function,
    unsimplified,
)
from warmlink.fmus.packaging.native.compile import library_here
from warmlink.fmus.packaging.native.joint_code import sampled_parts, samples
from warmlink.fmus.packaging.native.library import processor
from warmlink.fmus.packaging.native.micro_step import stepping
from warmlink.fmus.packaging.native.rollout import Rollout
from warmlink.fmus.packaging.native.wired import WirePlan

_LOOP = Path(__file__).parent / "sources" / "rollout.c"
"""The loop over the tasks of a run."""


def compiled(whole: Component, recorded: Sequence[str], side_by_side: bool = True) -> Rollout:
    """Compile a joined component for batched (SIMD) or single runs, recording the variables that are named.

    InputError if there is no compiler, it does not take what is computed, or a name is no output's.
    """
    assert whole.joint is not None
    unknown = [name for name in recorded if name not in whole.y.index and name not in whole.x.index]
    if unknown:
        raise InputError(f"{whole.name}: {unknown[0]} is no output of its parts")
    parts = {key: part for key, part in whole.joint.parts.items() if part.inputs or part.states}
    wires = whole.joint.wires
    driven = join(whole.name, parts, [(a, b) for b, a in wires.items() if a.rpartition(".")[0] in parts])
    own = {*driven.x.names, *driven.y.names}
    used = (*(wires[name] for name in driven.u.names if name in wires), *recorded)
    given = tuple(dict.fromkeys(name for name in used if name not in own))
    most, level = processor()
    lanes = most if side_by_side else 1
    p, u = whole.start_values()
    starts = dict(zip(whole.u.names, u.tolist(), strict=True))
    # One lane is as fast with -O1, and compiled in three quarters of the time.
    flags = ("-w",) if lanes > 1 else ("-w", "-O1")
    sources = _sources(driven, _inputs(driven, starts, wires, given), given, recorded, lanes)
    starting, table = _starting(whole, driven, given, starts)
    return Rollout(
        library=library_here(sources, "rollout", *flags, level=level),
        level=level,
        lanes=lanes,
        starting=starting,
        table=table,
        parameters=dict(zip(whole.p.names, p.tolist(), strict=True)),
        recorded=tuple(recorded),
        sample_times=tuple(clock.sample_time for clock in driven.clocks),
        micro_step=driven.micro_step,
        given=given,
        inputs=starts,
    )


def _starting(
    whole: Component, driven: Component, given: Sequence[str], starts: Mapping[str, float]
) -> tuple[Any, Any]:
    """CasADi functions of what a run starts from, and of what the parts give then that nothing drives.

    The first one goes from the whole's parameters to what is settled, free and driven part, and states; its
    last result is how many of the parameters, and of the conditions across them, an FMU refuses. The second
    one goes from the free part and the time to what is given.
    """
    import casadi

    s = Symbols.of(whole)
    refused = _refused(whole.parameters, s.p)
    refused += [casadi.if_else(check.margin(whole.p.read(s.p)) >= 0, 0, 1) for check in whole.checks]
    settled, inputs = casadi.SX(whole.settled(s.p)), casadi.SX(casadi.DM([*starts.values()]))
    free = [place for name, place in whole.d.index.items() if name not in driven.d.index]
    own = settled[[whole.d.index[name] for name in driven.d.names]]
    results = [settled[free], own, whole.states_at_start(inputs, settled), sum(refused)]
    outputs = casadi.SX(whole.outputs_of(*s.now))[[whole.y.index[name] for name in given]]
    starting = casadi.Function("starting", [s.p], results)
    return starting, casadi.Function("table", [s.d[free], s.time], [outputs])


def _sources(
    driven: Component, inputs: Function, given: Sequence[str], recorded: Sequence[str], lanes: int
) -> dict[str, str]:
    """C files by name; with another law the micro step stays as it is."""
    s, plan = Symbols.of(driven), WirePlan(driven)
    (held, advance), seen = stepping(driven, s), _seen(plan, s, given, recorded)
    clocks = enumerate(sampled_parts(plan))
    changes = [("WL(advance)", 0, driven.continuous.size)]
    changes += [(f"sample_{clock}_of", x, part.x.size) for clock, (_, part, x) in clocks]
    defined = {
        "GIVEN": len(given),
        "LONGEST": max(driven.x.size, *(result.numel() for *_, result in (inputs, held, seen[0]))),
        "RECORDED": len(recorded),
        "CHANGES": ", ".join(f"{{{', '.join(map(str, change))}}}" for change in changes),
    }
    step = functions_text((function(*each) for each in (held, advance)), ("held", "advance"), lanes)
    running = functions_text((function(*each) for each in (inputs, *seen)), (), lanes)
    running += "".join(f"#define {name} {value}\n" for name, value in defined.items())
    return {"advance.c": step, "rollout.c": running + _LOOP.read_text("utf-8")}


def _inputs(
    driven: Component, starts: Mapping[str, float], wires: Mapping[str, str], given: Sequence[str]
) -> Function:
    """Inputs from what is given, or what they start at; after them what is given itself."""
    import casadi

    table = casadi.SX.sym("table", len(given))
    held: dict[str, Any] = {**starts, **{name: table[i] for i, name in enumerate(given)}}
    inputs = (held[wires.get(name, name)] for name in driven.u.names)
    return "inputs", [table], casadi.vertcat(casadi.SX(0, 1), *inputs, table)


def _seen(plan: WirePlan, s: Symbols, given: Sequence[str], recorded: Sequence[str]) -> list[Function]:
    """The view, which is what the others need of the continuous states, the record, and the samples.

    After what is recorded stands how many inputs of parts an FMU would refuse.
    """
    import casadi

    driven, extra = plan.component, casadi.SX.sym("extra", len(given))
    outputs = casadi.SX(driven.outputs_of(*s.now))
    values = {name: s.x[i] for name, i in driven.x.index.items()}
    values |= {name: outputs[i] for name, i in driven.y.index.items()}
    values |= {name: extra[i] for i, name in enumerate(given)}
    read = driven.x.read(s.x), driven.u.read(s.u), driven.d.read(s.d), s.time
    refused = [
        each
        for key, part in plan.joint.parts.items()
        for each in _refused(part.inputs, casadi.SX(plan.joint.inputs(key, *read)))
    ]
    row = casadi.vertcat(*(values[name] for name in recorded), sum(refused))
    clocks = [function(*each) for each in samples(plan)]
    with unsimplified():
        sampled = [each(*s.now, s.step) for each in clocks]
    (row, *sampled), known, view = apart([row, *sampled], s.x[: driven.continuous.size], s.u, s.d, s.time)
    now = [s.x, casadi.vertcat(s.u, extra), known, s.d, s.time]
    changes = ((f"sample_{clock}", [*now, s.step], each) for clock, each in enumerate(sampled))
    return [("view", s.now, view), ("record", now, row), *changes]


def _refused(variables: Iterable[Input | Parameter], values: Expression) -> list[Expression]:
    """For each scalar 1 where its value is neither within its bounds nor a rounding error off, else 0."""
    import casadi

    refused = []
    for i, variable in enumerate(each for each in variables for _ in each.scalar_names):
        value = values[i]
        margin = BOUND_TOLERANCE * ordinary_size(variable)
        low = -LARGEST if variable.minimum is None else variable.minimum - margin
        high = LARGEST if variable.maximum is None else variable.maximum + margin
        well = casadi.logic_and(value >= low, value <= high)
        if isinstance(variable, Input) and variable.accepts_nan:  # which is on neither side of a bound
            well = casadi.logic_not(casadi.logic_or(value < low, value > high))
        if isinstance(variable, Parameter) and variable.positive:
            well = casadi.logic_and(well, value > 0)
        refused.append(casadi.if_else(well, 0, 1))
    return refused
