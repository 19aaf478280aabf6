"""C of a joined component that goes through whole runs in one call.

Nothing is computed more often than it changes. Parts that nothing drives and that remember nothing, as a duty
cycle, become a table over time. Of what the others compute, that which depends on held values alone (the
factors of a micro step's matrix, say, as long as the duty stays the same) is kept until one of them changes.
"""

from collections.abc import Collection, Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from warmlink.fmus.component import Component, Input, Parameter
from warmlink.fmus.component.arithmetic import LARGEST
from warmlink.fmus.component.join import Joint, join
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
from warmlink.fmus.packaging.native.joint_code import places, running_parts
from warmlink.fmus.packaging.native.library import processor
from warmlink.fmus.packaging.native.micro_step import stepping
from warmlink.fmus.packaging.native.rollout import Rollout


def compiled(whole: Component, recorded: Sequence[str], side_by_side: bool = True) -> Rollout:
    """Compile a joined component of whose outputs and states some are recorded, for runs in lanes or for one.

    InputError if there is no compiler, it does not take what is computed, or a name is no output's.
    """
    assert whole.joint is not None
    unknown = [name for name in recorded if name not in whole.y.index and name not in whole.x.index]
    if unknown:
        raise InputError(f"{whole.name}: {unknown[0]} is no output of its parts")
    cell = _Cell(whole, whole.joint, recorded)
    most, level = processor()
    lanes = most if side_by_side else 1
    (compiler,) = compilers(platforms_named(None))
    options = ("-w", *(() if level is None else (f"-march={level}",)))
    sources = cell.texts(lanes)
    sources["run.c"] += cell.core()
    library = replace(compiler, flags=(*compiler.flags, *options)).library(sources, "rollout")
    layouts = zip((whole.p, whole.u), whole.start_values(), strict=True)
    parameters, inputs = (dict(zip(of.names, starts.tolist(), strict=True)) for of, starts in layouts)
    clocks, given = tuple(clock.sample_time for clock in cell.driven.clocks), tuple(cell.given)
    made = (library, level, lanes, cell.starting(), parameters, tuple(recorded), clocks)
    return Rollout(*made, cell.driven.micro_step, given, inputs)


class _Held(NamedTuple):
    """A function in two: what depends on held arguments alone, and the rest, which is given that last."""

    held: Function
    rest: Function

    @property
    def size(self) -> int:
        """How many numbers are held; no array of C has none."""
        return max(int(self.held[2].numel()), 1)


def _apart(
    results: list[Expression], held: list[Expression]
) -> tuple[list[Expression], Expression, Expression]:
    """Results that read from a new symbol what depends on held arguments alone; the symbol; what it holds.

    Every number stays the same double.
    """
    import casadi

    kind = type(results[0])
    with unsimplified():
        dense = [casadi.densify(each) for each in casadi.cse(results)]
        rest, symbols, found = casadi.extract_parametric(dense, held)
        whole = casadi.vertcat(kind(0, 1), *(casadi.vec(each) for each in found))
        kept, parts, first = kind.sym("kept", whole.numel()), [], 0
        for each in found:
            last = first + each.numel()
            parts.append(casadi.reshape(kept[first:last], *each.shape))
            first = last
        return casadi.substitute(rest, symbols, parts) if found else rest, kept, whole


def _split(given: Function, held: list[Expression]) -> _Held:
    name, arguments, result = given
    (rest,), kept, found = _apart([type(arguments[0])(result)], held)
    return _Held((f"{name}_held", held, found), (name, [*arguments, kept], rest))


class _Cell:
    """A joined component in two: what nothing drives, and what is driven."""

    def __init__(self, whole: Component, joint: Joint, recorded: Sequence[str]) -> None:
        import casadi

        self.whole, self.recorded = whole, recorded
        free = {key: part for key, part in joint.parts.items() if not (part.inputs or part.states)}
        parts = {key: part for key, part in joint.parts.items() if key not in free}
        among = [(a, b) for b, a in joint.wires.items() if a.rpartition(".")[0] in parts]
        self.driven = join(whole.name, parts, among)
        assert self.driven.joint is not None
        self.joint = self.driven.joint
        self.s = s = Symbols.of(self.driven)
        self._free = [f"{key}.{name}" for key, part in free.items() for name in part.d.names]
        self._settled = casadi.SX.sym("settled", len(self._free))
        values, first = dict[str, Expression](), 0
        for key, part in free.items():
            d, first = self._settled[first : first + part.d.size], first + part.d.size
            outputs = casadi.SX(part.outputs_of(casadi.SX(0, 1), casadi.SX(0, 1), d, s.time))
            values |= {f"{key}.{name}": outputs[i] for name, i in part.y.index.items()}
        self._wires = {name: joint.wires[name] for name in self.driven.u.names if name in joint.wires}
        used = dict.fromkeys([*self._wires.values(), *(name for name in recorded if name in values)])
        self.given = {name: values[name] for name in used}
        """What the free parts give to the driven ones or to the record, by name."""
        self._table = casadi.SX.sym("table", len(used))
        self._steps = [_split(each, [s.u, s.d, s.step]) for each in stepping(self.driven, s)]
        self._updates: dict[str, _Held] = {}
        self._seen: list[Function] = []
        now = [s.x, s.u, s.d, s.time]
        for each in running_parts(self.driven, self.joint, now):
            if each[0].startswith("update_"):
                self._updates[each[0]] = _split(each, [each[1][2], each[1][4]])
            else:
                self._seen.append(each)
        moving, standing = self._refused(now)
        self._standing: Function = ("standing", [s.u, s.d], standing)
        self._seen.append(("record", [self._table, *now], self._row(now, moving)))
        # What the parts read and what is recorded share what follows from the continuous states.
        continuous = [s.x[: self.driven.continuous.size], s.u, s.d, s.time]
        rest, kept, view = _apart([casadi.SX(result) for *_, result in self._seen], continuous)
        self._seen = [(n, [*a, kept], r) for (n, a, _), r in zip(self._seen, rest, strict=True)]
        self._view: Function = ("view", now, view)

    def texts(self, lanes: int) -> dict[str, str]:
        """C that the core calls, in files of which a similar system needs some as they are."""
        alone = {"advance": self._steps, **{name: [each] for name, each in self._updates.items()}}
        apart = {name: [half for each in of for half in each] for name, of in alone.items()}
        texts = {f"{name}.c": _text(of, [each[0] for each in of], lanes) for name, of in apart.items()}
        declared = "".join(
            _DECLARED.format(name, ", ".join(["const lanes *"] * len(arguments)))
            for of in apart.values()
            for name, arguments, _ in of
        )
        together = [*self._demands(), self._standing, self._view, *self._seen]
        return {**texts, "run.c": _text(together, (), lanes) + declared}

    def core(self) -> str:
        """C that does one task after another: sizes, what each clock does, and the hand-written loop."""
        driven, cases, held = self.driven, "", 0
        for clock, (key, part) in enumerate(each for each in self.joint.parts.items() if each[1].sampled):
            _, d, x = places(driven, key, part)
            update, layout = f"update_{part.name}_0", driven.clocks[clock].layout
            inputs = f"inputs_{list(self.joint.parts).index(key)}_of"
            place = driven.x.index[layout.names[0]]
            cases += _SAMPLE.format(**locals(), size=layout.size)
            held += self._updates[update].size
        sizes = {
            "GIVEN": len(self.given),
            "INPUTS": max(driven.u.size, *(part.u.size for part in self.joint.parts.values()), 1),
            "STATES": driven.x.size,
            "CONTINUOUS": driven.continuous.size,
            "CLOCKS": max(len(driven.clocks), 1),
            "VIEW": max(int(self._view[2].numel()), 1),
            "HELD": max(each.size for each in self._steps),
            "SAMPLED": max(held, 1),
            "RECORDED": len(self.recorded),
        }
        rare = (f" || any_of(d[{driven.d.index[each.name]}])" for each in driven.parameters if each.rare)
        steps = zip(("FULL", "USUAL"), (self._steps[0], self._steps[-1]), strict=True)
        defined = {**sizes, "RARE": "".join(["0", *rare]), **{name: each.rest[0] for name, each in steps}}
        lines = "".join(f"#define {name} {value}\n" for name, value in defined.items())
        return lines + _SAMPLES.format(cases=cases) + _LOOP.read_text("utf-8")

    def starting(self) -> str:
        """CasADi function from the whole's parameters to what is settled, free and driven part, and states.

        Its last result is how many of the parameters, and of the conditions across them, an FMU refuses.
        """
        import casadi

        p = casadi.SX.sym("p", self.whole.p.size)
        variables = [variable for variable in self.whole.parameters for _ in variable.scalar_names]
        refused = _refused(zip(variables, casadi.vertsplit(p), strict=True))
        for check in self.whole.checks:
            refused += casadi.if_else(check.margin(self.whole.p.read(p)) >= 0, 0, 1)
        settled, inputs = casadi.SX(self.whole.settled(p)), casadi.DM(self.whole.start_values()[1])
        free, driven = (
            settled[[self.whole.d.index[name] for name in names]]
            for names in (self._free, self.driven.d.names)
        )
        states = casadi.SX(self.whole.states_at_start(casadi.SX(inputs), settled))
        return str(casadi.Function("starting", [p], [free, driven, states, refused]).serialize())

    def _demands(self) -> list[Function]:
        """What the free parts give, and the inputs of what is driven: that, or what they start at."""
        import casadi

        starts = dict(zip(self.whole.u.names, self.whole.start_values()[1].tolist(), strict=True))
        held = {name: self._table[i] for i, name in enumerate(self.given)}
        inputs = (
            held[self._wires[name]] if name in self._wires else casadi.SX(starts[name])
            for name in self.driven.u.names
        )
        none = casadi.SX(0, 1)
        return [
            ("given", [self._settled, self.s.time], casadi.vertcat(none, *self.given.values())),
            ("inputs", [self._table], casadi.vertcat(none, *inputs)),
        ]

    def _row(self, now: Sequence[Expression], refused: Expression) -> Expression:
        """What is recorded, and how many inputs are refused."""
        import casadi

        outputs = casadi.SX(self.driven.outputs_of(*now))
        values = {name: now[0][i] for name, i in self.driven.x.index.items()}
        values |= {name: outputs[i] for name, i in self.driven.y.index.items()}
        values |= {name: self._table[i] for i, name in enumerate(self.given)}
        return casadi.vertcat(*(values[name] for name in self.recorded), refused)

    def _refused(self, now: Sequence[Expression]) -> tuple[Expression, Expression]:
        """How many of the parts' inputs an FMU would refuse: of those that states move, and of the others."""
        import casadi

        x, u, d, time = now
        records = (self.driven.x.read(x), self.driven.u.read(u), self.driven.d.read(d))
        moving: list[tuple[Input, Expression]] = []
        standing: list[tuple[Input, Expression]] = []
        for key, part in self.joint.parts.items():
            values = casadi.vertsplit(casadi.SX(self.joint.inputs(key, *records, time)))
            variables = [variable for variable in part.inputs for _ in variable.scalar_names]
            for variable, value in zip(variables, values, strict=True):
                moves = casadi.depends_on(value, casadi.vertcat(x, time))
                (moving if moves else standing).append((variable, value))
        return _refused(moving), _refused(standing)


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


_LOOP = Path(__file__).parent / "sources" / "rollout.c"
"""The loop over the tasks of a run."""

_DECLARED = "void {0}_lanes({1}, lanes *);\n#define {0}_of {0}_lanes\n"


def _text(functions: Iterable[Function], declared: Collection[str], lanes: int) -> str:
    text = functions_text((function(*each) for each in functions), declared, lanes)
    return "#define WL(name) name##_lanes\n" + text


_SAMPLE = """    case {clock}:
        if (anew)
            {update}_held_of(d + {d}, step, held + {held});
        {inputs}(x, u, d, time, view, v);
        {update}_of(x + {x}, v, d + {d}, time, step, held + {held}, next);
        memcpy(x + {place}, next, {size} * sizeof *x);
        break;
"""

_SAMPLES = """
static void sample(int clock, int anew, lanes *x, const lanes *u, const lanes *d, const lanes *time,
    const lanes *step, const lanes *view, lanes *held)
{{
    lanes v[INPUTS], next[STATES];
    switch (clock) {{
{cases}    }}
}}
"""
