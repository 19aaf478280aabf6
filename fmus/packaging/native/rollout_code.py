"""C of a joined component that goes through whole runs in one call.

Parts that nothing drives and that remember nothing, as a duty cycle, are computed once for each instant; the
others are joined without them.
"""

import re
from collections.abc import Collection, Iterable, Sequence
from dataclasses import replace

from warmlink.fmus.component import Component, Input, Parameter
from warmlink.fmus.component.arithmetic import LARGEST
from warmlink.fmus.component.join import Joint, join
from warmlink.fmus.component.limits import BOUND_TOLERANCE, ordinary_size
from warmlink.fmus.errors import InputError
from warmlink.fmus.packaging.native.casadi_code import Expression, Function, Symbols, function, functions_text
from warmlink.fmus.packaging.native.compile import compilers, platforms_named
from warmlink.fmus.packaging.native.joint_code import running_parts, sample_glue
from warmlink.fmus.packaging.native.lanes import in_lanes, processor
from warmlink.fmus.packaging.native.micro_step import choice_of_step, stepping
from warmlink.fmus.packaging.native.rollout import Rollout


def compiled(whole: Component, recorded: Sequence[str]) -> Rollout:
    """Compile a joined component of whose outputs some are recorded.

    Raises
    ------
    InputError
        If there is no compiler, it does not take what the component computes, or a name is no output's.
    """
    assert whole.joint is not None
    cell = _Cell(whole, whole.joint)
    unknown = [name for name in recorded if name not in whole.y.index]
    if unknown:
        raise InputError(f"{whole.name}: {unknown[0]} is no output of its parts")
    lanes, level = processor()
    (compiler,) = compilers(platforms_named(None))
    options = ("-w", *(() if level is None else (f"-march={level}",)))
    sources = {name: in_lanes(text, lanes) for name, text in cell.sources(recorded).items()}
    sources["run.c"] += _core(cell.driven, recorded)
    return Rollout(
        replace(compiler, flags=(*compiler.flags, *options)).library(sources, "rollout"),
        level,
        lanes,
        cell.starting(),
        dict(zip(whole.p.names, whole.start_values()[0].tolist(), strict=True)),
        tuple(recorded),
        tuple(clock.sample_time for clock in cell.driven.clocks),
        cell.driven.micro_step,
    )


class _Cell:
    """A joined component in two: what nothing drives, and what is driven."""

    def __init__(self, whole: Component, joint: Joint) -> None:
        import casadi

        self.whole = whole
        self._wires = joint.wires
        sources = {key: part for key, part in joint.parts.items() if not (part.inputs or part.states)}
        parts = {key: part for key, part in joint.parts.items() if key not in sources}
        among = [(a, b) for b, a in joint.wires.items() if a.rpartition(".")[0] in parts]
        self.driven = join(whole.name, parts, among)
        assert self.driven.joint is not None
        self.joint = self.driven.joint
        self.s = Symbols.of(self.driven)
        self._settled = casadi.SX.sym("settled", whole.d.size)
        self._given = dict[str, Expression]()
        for key, part in sources.items():
            d = self._settled[[whole.d.index[f"{key}.{name}"] for name in part.d.names]]
            values = casadi.SX(part.outputs_of(casadi.SX(0, 1), casadi.SX(0, 1), d, self.s.time))
            self._given |= {f"{key}.{name}": values[i] for name, i in part.y.index.items()}

    def sources(self, recorded: Sequence[str]) -> dict[str, str]:
        """C that the core calls, in files of which a similar system needs some as they are."""
        s, driven = self.s, self.driven
        now = [s.x, s.u, s.d, s.time]
        alone = {"advance": [*stepping(driven, s)]}
        together = [("demand", [self._settled, s.time], self._inputs())]
        for each in running_parts(driven, self.joint, now):
            if each[0].startswith("update_"):
                alone[each[0]] = [each]
            else:
                together.append(each)
        together.append(("record", [self._settled, *now], self._row(recorded, now)))
        texts = {f"{name}.c": _text(name, given, (name,)) for name, given in alone.items()}
        texts["advance.c"] += choice_of_step(driven, ("x", "u", "d", "time", "step"))
        declared = "".join(
            _DECLARED.format(name, ", ".join(["const double *"] * len(given[0][1])))
            for name, given in alone.items()
        )
        return {**texts, "run.c": declared + _text("run", together, ()) + sample_glue(driven, self.joint)}

    def _row(self, recorded: Sequence[str], now: Sequence[Expression]) -> Expression:
        """What is recorded, and how many of the parts' inputs are out of bounds."""
        import casadi

        outputs = casadi.SX(self.driven.outputs_of(*now))
        values = {name: outputs[i] for name, i in self.driven.y.index.items()} | self._given
        return casadi.vertcat(*(values[name] for name in recorded), self._out_of_bounds(now))

    def starting(self) -> str:
        """CasADi function from the whole's parameters to all that is settled, its driven part, and states.

        Its last result is how many of the parameters, and of the conditions across them, an FMU refuses.
        """
        import casadi

        p = casadi.SX.sym("p", self.whole.p.size)
        variables = [variable for variable in self.whole.parameters for _ in variable.scalar_names]
        refused = _refused(zip(variables, casadi.vertsplit(p), strict=True))
        for check in self.whole.checks:
            refused += casadi.if_else(check.margin(self.whole.p.read(p)) >= 0, 0, 1)
        settled, inputs = casadi.SX(self.whole.settled(p)), casadi.DM(self.whole.start_values()[1])
        part = settled[[self.whole.d.index[name] for name in self.driven.d.names]]
        states = casadi.SX(self.whole.states_at_start(casadi.SX(inputs), settled))
        return str(casadi.Function("starting", [p], [settled, part, states, refused]).serialize())

    def _inputs(self) -> Expression:
        """Inputs of what is driven: a source's, or at their start."""
        import casadi

        starts = dict(zip(self.whole.u.names, self.whole.start_values()[1].tolist(), strict=True))
        names = self.driven.u.names
        return casadi.vertcat(
            *(self._given[self._wires[name]] if name in self._wires else starts[name] for name in names)
        )

    def _out_of_bounds(self, now: Sequence[Expression]) -> Expression:
        """How many of the parts' inputs an FMU would refuse."""
        import casadi

        x, u, d, time = now
        records = (self.driven.x.read(x), self.driven.u.read(u), self.driven.d.read(d))
        count = casadi.SX(0)
        for key, part in self.joint.parts.items():
            values = casadi.vertsplit(casadi.SX(self.joint.inputs(key, *records, time)))
            variables = [variable for variable in part.inputs for _ in variable.scalar_names]
            count += _refused(zip(variables, values, strict=True))
        return count


def _refused(values: Iterable[tuple[Input | Parameter, Expression]]) -> Expression:
    """How many values are neither within their variable's bounds nor a rounding error off."""
    import casadi

    count = casadi.SX(0)
    for variable, value in values:
        margin = BOUND_TOLERANCE * ordinary_size(variable)
        low, high = variable.minimum, variable.maximum
        well = casadi.logic_and(
            value >= (-LARGEST if low is None else low - margin),
            value <= (LARGEST if high is None else high + margin),
        )
        if isinstance(variable, Input) and variable.accepts_nan:
            well = casadi.logic_or(well, value != value)
        if isinstance(variable, Parameter) and variable.positive:
            well = casadi.logic_and(well, value > 0)
        count += casadi.if_else(well, 0, 1)
    return count


_DECLARED = "void {0}_lanes({1}, double *);\n#define {0}_of {0}_lanes\n"


def _text(name: str, functions: Iterable[Function], declared: Collection[str]) -> str:
    """C of functions without CasADi's comments, which tell sizes that do not matter."""
    found = functions_text(f"rollout_{name}", (function(*each) for each in functions), declared)
    return "#define WL(name) name##_lanes\n" + re.sub(r"^/\*.*\*/\n", "", found, flags=re.MULTILINE)


def _core(driven: Component, recorded: Sequence[str]) -> str:
    """C function that does one task after another."""
    samples = "".join(
        f"        case {number + 2}:\n"
        f"            sample_{number}_of(x, u, d, &time, &step, next);\n"
        f"            memcpy(x + {driven.x.index[clock.layout.names[0]]}, next,"
        f" {clock.layout.size} * sizeof *x);\n            break;\n"
        for number, clock in enumerate(driven.clocks)
    )
    return f"""
__attribute__((visibility("default"))) void rollout(long count, const signed char *tasks, const double *times,
    const double *steps, const lanes *all, const lanes *d, lanes *x, lanes *row)
{{
    lanes u[{max(driven.u.size, 1)}], next[{driven.x.size}];
    double demanded = NAN;
    for (long i = 0; i < count; i++) {{
        lanes time = EACH(times[i]), step = EACH(steps[i]);
        if (times[i] != demanded)
            demand_of(all, &time, u);
        demanded = times[i];
        switch (tasks[i]) {{
        case 0:
            advance_of(x, u, d, &time, &step, next);
            memcpy(x, next, {driven.continuous.size} * sizeof *x);
            break;
        case 1:
            record_of(all, x, u, d, &time, row);
            row += {len(recorded) + 1};
            break;
{samples}        }}
    }}
}}
"""
