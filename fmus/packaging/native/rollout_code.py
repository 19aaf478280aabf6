"""C of a joined component that goes through whole runs in one call.

Nothing is computed more often than it changes. Parts that nothing drives and that remember nothing, as a duty
cycle, become a table over time. Of what the others compute, that which depends on held values alone (the
factors of a micro step's matrix, say, as long as the duty stays the same) is kept until one of them changes.
"""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import accumulate
from pathlib import Path

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
    function,
    unsimplified,
)
from warmlink.fmus.packaging.native.compile import compilers, platforms_named
from warmlink.fmus.packaging.native.joint_code import part_inputs, running_parts, sampled_parts
from warmlink.fmus.packaging.native.library import processor
from warmlink.fmus.packaging.native.micro_step import rare_places, stepping
from warmlink.fmus.packaging.native.rollout import Rollout

_LOOP = Path(__file__).parent / "sources" / "rollout.c"
"""The loop over the tasks of a run."""


def compiled(whole: Component, recorded: Sequence[str], side_by_side: bool = True) -> Rollout:
    """Compile a joined component of whose outputs and states some are recorded, for runs in lanes or for one.

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
    (compiler,) = compilers(platforms_named(None))
    options = ("-w", *(() if level is None else (f"-march={level}",)))
    sources = _sources(whole, driven, given, recorded, lanes)
    p, u = whole.start_values()
    return Rollout(
        library=replace(compiler, flags=(*compiler.flags, *options)).library(sources, "rollout"),
        level=level,
        lanes=lanes,
        starting=_starting(whole, driven),
        parameters=dict(zip(whole.p.names, p.tolist(), strict=True)),
        recorded=tuple(recorded),
        sample_times=tuple(clock.sample_time for clock in driven.clocks),
        micro_step=driven.micro_step,
        given=given,
        inputs=dict(zip(whole.u.names, u.tolist(), strict=True)),
    )


def _starting(whole: Component, driven: Component) -> str:
    """CasADi function from the whole's parameters to what is settled, free and driven part, and states.

    Its last result is how many of the parameters, and of the conditions across them, an FMU refuses.
    """
    import casadi

    p = casadi.SX.sym("p", whole.p.size)
    refused = _refused(whole.parameters, p)
    refused += [casadi.if_else(check.margin(whole.p.read(p)) >= 0, 0, 1) for check in whole.checks]
    settled, inputs = casadi.SX(whole.settled(p)), casadi.SX(casadi.DM(whole.start_values()[1]))
    free, own = settled[_free(whole, driven)], settled[[whole.d.index[name] for name in driven.d.names]]
    results = [free, own, whole.states_at_start(inputs, settled), sum(refused)]
    return str(casadi.Function("starting", [p], results).serialize())


def _free(whole: Component, driven: Component) -> list[int]:
    """Where among all settled values those of the parts lie that nothing drives."""
    return [place for name, place in whole.d.index.items() if name not in driven.d.index]


def _split(given: Function, held: Sequence[int]) -> list[Function]:
    """A change of states in two: what depends on some arguments alone, which are held, and the rest."""
    name, arguments, result = given
    _, u, d, _, step = arguments
    (rest,), kept, found = _apart([type(d)(result)], [arguments[i] for i in held])
    return [(f"{name}_held", [u, d, step], found), (name, [*arguments, kept], rest)]


def _apart(
    results: list[Expression], held: list[Expression]
) -> tuple[list[Expression], Expression, Expression]:
    """Results that read from new symbols what depends on held arguments alone; those; what they hold.

    Every number stays the same double.
    """
    import casadi

    none = type(results[0]).sym("none", 0)
    with unsimplified():
        dense = [casadi.densify(each) for each in casadi.cse(results)]
        rest, *both = casadi.extract_parametric(dense, held)
        kept, found = (casadi.vertcat(none, *map(casadi.vec, each)) for each in both)
    return rest, kept, found


def _sources(
    whole: Component, driven: Component, given: Sequence[str], recorded: Sequence[str], lanes: int
) -> dict[str, str]:
    """C files by name, of which a similar system needs some as they are."""
    assert driven.joint is not None
    s = Symbols.of(driven)
    running = {each[0]: each for each in running_parts(driven, driven.joint, s.now)}
    sampled = list(sampled_parts(driven, driven.joint))
    files = {"advance": [half for each in stepping(driven, s) for half in _split(each, (1, 2, 4))]}
    files |= {name: _split(each, (2, 4)) for name, each in running.items() if name.startswith("update")}
    halves = {each[0]: each for of in files.values() for each in of}
    usual, full = files["advance"][-1][0], files["advance"][1][0]
    changes = [(name, "0", 0, 0, driven.continuous.size) for name in (usual, full)]
    changes += [(update, f"{inputs}_of", x, d, part.x.size) for inputs, update, part, d, x in sampled]
    *kept, size = accumulate((halves[f"{name}_held"][2].numel() for name, *_ in changes), initial=0)
    seen = _seen(driven, s, given, recorded, [running[inputs] for inputs, *_ in sampled])
    widths = [part.u.size for _, _, part, *_ in sampled]
    defined = {
        "GIVEN": len(given),
        "KEPT": size,
        "LONGEST": max(driven.x.size, driven.u.size + len(given), seen[0][2].numel(), *widths),
        "RECORDED": len(recorded),
        "RARE": " || ".join(["0", *(f"any_of(d[{place}])" for place in rare_places(driven))]),
        "DECLARED": " ".join(f"DECLARE({name})" for name in dict.fromkeys(name for name, *_ in changes)),
        "CHANGES": ", ".join(
            f"CHANGE({', '.join(map(str, change))}, {first})"
            for change, first in zip(changes, kept, strict=True)
        ),
    }
    files["run"] = [*_given(whole, driven, given), *seen]
    texts = {
        f"{file}.c": functions_text((function(*each) for each in of), halves, lanes)
        for file, of in files.items()
    }
    texts["run.c"] += "".join(f"#define {name} {value}\n" for name, value in defined.items())
    texts["run.c"] += _LOOP.read_text("utf-8")
    return texts


def _given(whole: Component, driven: Component, given: Sequence[str]) -> list[Function]:
    """What the free parts give over time; and from that the inputs, or what they start at, and itself."""
    import casadi

    assert whole.joint is not None
    s, none, table = Symbols.of(whole), casadi.SX(0, 1), casadi.SX.sym("table", len(given))
    outputs, starts = casadi.SX(whole.outputs_of(*s.now)), whole.start_values()[1].tolist()
    held = dict(zip(whole.u.names, starts, strict=True)) | {name: table[i] for i, name in enumerate(given)}
    inputs = (held[whole.joint.wires.get(name, name)] for name in driven.u.names)
    free = casadi.vertcat(none, *(s.d[i] for i in _free(whole, driven)))
    return [
        ("given", [free, s.time], casadi.vertcat(none, *(outputs[whole.y.index[name]] for name in given))),
        ("inputs", [table], casadi.vertcat(none, *inputs, table)),
    ]


def _seen(
    driven: Component, s: Symbols, given: Sequence[str], recorded: Sequence[str], inputs: list[Function]
) -> list[Function]:
    """What is seen of the states: the view, the inputs of sampled parts, and what is recorded.

    The view is what these share, since it follows from the continuous states. The record ends with how many
    inputs of parts an FMU would refuse, of those that states move; `standing` counts the others.
    """
    import casadi

    assert driven.joint is not None
    counts = {True: casadi.SX(0), False: casadi.SX(0)}
    for key, part in driven.joint.parts.items():
        for each in _refused(part.inputs, casadi.SX(part_inputs(driven, driven.joint, key, s.now))):
            counts[casadi.depends_on(each, casadi.vertcat(s.x, s.time))] += each
    extra = casadi.SX.sym("extra", len(given))
    outputs = casadi.SX(driven.outputs_of(*s.now))
    values = {name: s.x[i] for name, i in driven.x.index.items()}
    values |= {name: outputs[i] for name, i in driven.y.index.items()}
    values |= {name: extra[i] for i, name in enumerate(given)}
    row = casadi.vertcat(*(values[name] for name in recorded), counts[True])
    together = [*inputs, ("record", s.now, row)]
    continuous = [s.x[: driven.continuous.size], s.u, s.d, s.time]
    rest, kept, view = _apart([casadi.SX(result) for *_, result in together], continuous)
    arguments = [s.x, casadi.vertcat(s.u, extra), s.d, s.time, kept]
    seen = [(name, arguments, each) for (name, *_), each in zip(together, rest, strict=True)]
    return [("view", s.now, view), ("standing", [s.u, s.d], counts[False]), *seen]


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
        if isinstance(variable, Input) and variable.accepts_nan:
            well = casadi.logic_or(well, value != value)
        if isinstance(variable, Parameter) and variable.positive:
            well = casadi.logic_and(well, value > 0)
        refused.append(casadi.if_else(well, 0, 1))
    return refused
