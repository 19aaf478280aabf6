"""From a component's declaration to C: its functions by CasADi, its variables as a table."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import lru_cache
from itertools import accumulate
from typing import Any

from warmlink.fmus.component import FIELD, MOST_IN_A_STEP, Component, Scalar, limits
from warmlink.fmus.component.table import Played
from warmlink.fmus.packaging.native import joint_code, joint_step
from warmlink.fmus.packaging.native.c_code import functions_text
from warmlink.fmus.packaging.native.casadi_code import (
    Expression,
    Function,
    Symbols,
    beginning,
    function,
    sampling,
)
from warmlink.fmus.packaging.native.groups import output_groups
from warmlink.fmus.packaging.native.micro_step import stepping
from warmlink.fmus.packaging.native.wired import WirePlan
from warmlink.fmus.packaging.views import exchanged_states

MOST_SHOWN = 8
"""Parameters that the sentence of a check may name, as `model.h` has it."""


@lru_cache(maxsize=64)
def generate(component: Component, arrays: bool = False) -> Mapping[str, str]:
    """Write the generated C files of a component, all but `identity.h`; texts by name.

    `component.h` holds its name and sizes; by CasADi `starting.c` what runs once, `running.c` what runs all
    the time, `deriving.c` what gives derivatives; `variables.c` a table. With `arrays` an array is exchanged
    as a whole, by the value reference of its first element.
    """
    plan = None if component.joint is None else WirePlan(component)
    groups, functions = _running(component, plan)
    header = '#include "model.h"\n' + ('#include "model_table.h"\n' if component.tables else "")
    starting = header + functions_text(_starting(component, plan))
    derivatives = [each for each in functions if each.name().endswith("tangent")]
    running = header + functions_text(each for each in functions if each not in derivatives)
    running += _dispatcher("outputs", "group", ("x", "u", "d", "time"), len(groups))
    running += _dispatcher("sample", "clock", ("x", "u", "d", "time", "step"), len(component.clocks))
    return {
        "component.h": _sizes_header(component, arrays),
        "starting.c": starting,
        "running.c": running,
        "deriving.c": header + functions_text(derivatives),
        "variables.c": _variables_file(component, groups, arrays),
    }


def _sizes_header(component: Component, arrays: bool) -> str:
    """Write `component.h`: the component's name, the prefix of its functions, and sizes."""
    sizes = {
        "NAME": _string(component.name),
        "PREFIX": f"{component.name}_",
        "MICRO_STEP": float(component.micro_step),
        "MOST_IN_A_STEP": MOST_IN_A_STEP,
        "PARAMETERS": component.p.size,
        "INPUTS": component.u.size,
        "OUTPUTS": component.output_count,
        "LOCALS": component.y.size - component.output_count,
        "STATES": component.x.size,
        "SETTLED": component.d.size,
        "CHECKS": len(component.checks),
        "CONTINUOUS": component.continuous.size,
        "CLOCKS": len(component.clocks),
        "ARRAYS": int(arrays),
        "EXCHANGES": int(bool(exchanged_states(component))),
        "TABLES": len(component.tables),
        "MOST_COLUMNS": max((len(each.columns) for each in component.tables), default=0),
    }
    return _header("Name and sizes of one component", sizes)


def identity_header(token: str, state: str) -> str:
    """Write `identity.h`: the token that the FMU answers to, and what must have made a serialised state."""
    known = {"TOKEN": token, "STATE_ID": state}
    return _header("What one FMU is known by", {name: _string(text) for name, text in known.items()})


def _header(about: str, values: Mapping[str, object]) -> str:
    lines = "".join(f"#define WL_{name} {value}\n" for name, value in values.items())
    return f"/* {about}; generated. */\n{lines}"


def _starting(component: Component, plan: WirePlan | None) -> Iterator[Any]:
    """Yield the CasADi functions that run once for each instance, as the C wrapper calls them."""
    import casadi

    if plan is not None:
        yield from (function(*part) for part in joint_code.starting(plan))
        return
    s = Symbols.of(component)
    margins = [check.margin(component.p.read(s.p)) for check in component.checks]
    yield function("margins", [s.p], casadi.vertcat(*margins))
    yield function("settle", [s.p], component.settled(s.p))
    yield from (function(*part) for part in beginning(component))


def _running(component: Component, plan: WirePlan | None) -> tuple[list[list[int]], list[Any]]:
    """Groups of outputs, and the CasADi functions that run all the time, as the C wrapper calls them.

    Where parts of a joined component recur, what they do is called; else all is written out.
    """
    if plan is None:
        parts = [sampling(component, number) for number in range(len(component.clocks))]
    else:
        parts = [*joint_code.samples(plan)]
    if plan is None or not plan.repeats:
        groups = output_groups(component)
        parts += written_out(component, groups)
    else:
        groups, outputs = joint_code.output_functions(plan)
        moving = component.continuous.size > 0
        parts += [*joint_step.stepping(plan)] if moving else []
        parts += [*joint_step.slopes(plan)] if moving and not component.sampled else []
        parts += outputs
    return groups, [function(*part) for part in parts]


def written_out(component: Component, groups: Sequence[Sequence[int]]) -> Iterator[Function]:
    """Yield what runs all the time, but for samples, with nothing called that could be written out."""
    import casadi

    s = Symbols.of(component)
    if component.continuous.size:
        yield from stepping(component, s, _like(s.u))
        if not component.sampled:  # what samples gives no output derivatives
            rates = casadi.SX(component.rates_of(*s.now))
            yield "rates", s.now, rates
            yield _tangent("rates_tangent", s, rates)
    y = casadi.SX(component.outputs_of(*s.now))
    for number, group in enumerate(groups):
        yield f"outputs_{number}", s.now, y[group]
    yield _tangent("tangent", s, y[: component.output_count])


def _tangent(name: str, s: Symbols, expression: Expression) -> Function:
    """Derivative of an expression along a direction of states, inputs and time."""
    import casadi

    moving = [s.x, s.u, s.time]
    along = [_like(each) for each in moving]
    slope = casadi.jtimes(expression, casadi.vertcat(*moving), casadi.vertcat(*along))
    return name, [*s.now, *along], slope


def _like(symbols: Expression) -> Expression:
    import casadi

    return casadi.SX.sym("also", symbols.numel())


def _dispatcher(name: str, chosen: str, arguments: Sequence[str], count: int) -> str:
    """C function that calls one of several by its number."""
    if count == 0:
        return ""
    given = ", ".join(arguments)
    cases = "".join(f"    case {i}: {name}_{i}_of({given}, result); break;\n" for i in range(count))
    declared = ", ".join(f"const double *{argument}" for argument in arguments)
    return (
        f"\nvoid WL({name})(int {chosen}, {declared}, double *result)\n{{\n"
        f"    switch ({chosen}) {{\n{cases}    }}\n}}\n"
    )


def _variables_file(component: Component, groups: Sequence[Sequence[int]], arrays: bool) -> str:
    first_output = component.p.size + component.u.size
    grouped = [(number, output) for number, group in enumerate(groups) for output in group]
    place = {first_output + output: (number, i) for i, (number, output) in enumerate(grouped)}
    states = [(name, state) for state in component.states for name in state.scalar_names]
    firsts = accumulate((clock.layout.size for clock in component.clocks), initial=component.continuous.size)
    clocks = [
        f"{{{component.p.index[clock.sample_time]}, {first}, {clock.layout.size}}}"
        for clock, first in zip(component.clocks, firsts, strict=False)
    ]
    tables = (
        ("Variable", "variables", [_row(s, arrays, place.get(s.reference)) for s in component.scalars()]),
        ("StateVariable", "state_variables", [f"{{{_string(n)}, {int(s.accepts_nan)}}}" for n, s in states]),
        ("Sentence", "sentences", [_sentence(component, check.sentence) for check in component.checks]),
        ("double", "nominals", [repr(each.state.variable.nominal) for each in exchanged_states(component)]),
        ("int", "group_starts", accumulate(map(len, groups[:-1]), initial=0)),
        ("Clock", "clocks", clocks),
        ("Played", "played", [_played(component, each) for each in component.tables]),
    )
    about = "/* Variables of one component in the order of their value references; generated. */\n"
    return about + '#include "model.h"\n' + "".join(_table(*table) for table in tables)


def _table(kind: str, name: str, rows: Iterable[object]) -> str:
    """C table; what would be empty has one row of zeros, since no array of C may be empty."""
    listed = ",\n    ".join(map(str, rows)) or ("{0}" if kind[0].isupper() else "0")
    return f"\nconst {kind} WL({name})[] = {{\n    {listed},\n}};\n"


def _row(scalar: Scalar, arrays: bool, place: tuple[int, int] | None) -> str:
    variable = scalar.variable
    count = 1 if not arrays else 0 if scalar.element else variable.count
    flags = {"HAS_MINIMUM": variable.minimum is not None, "HAS_MAXIMUM": variable.maximum is not None}
    flags |= {name.upper(): getattr(variable, name, False) for name in ("positive", "tunable", "accepts_nan")}
    values = (scalar.start, variable.minimum, variable.maximum, limits.ordinary_size(variable))
    texts = (scalar.name, "" if variable.unit == "1" else f" {variable.unit}")
    kind = variable.type.upper() if variable.choice is None else "ENUMERATION"
    flagged = " | ".join(name for name, holds in flags.items() if holds) or 0
    numbers = (float(value or 0) for value in values)
    cells = [*map(_string, texts), *numbers, kind, flagged, count, *(place or (0, 0))]
    return f"{{{', '.join(map(str, cells))}}}"


def _played(component: Component, played: Played) -> str:
    part = played.name.rpartition(".")[0]
    texts = (played.file, played.head.decode(), part and f".{part}")
    cells = [*map(_string, texts), component.d.index[played.name], len(played.columns)]
    return f"{{{', '.join(map(str, cells))}}}"


def _sentence(component: Component, sentence: str) -> str:
    """Sentence of a check as a format, and the value references of the parameters that stand in it."""
    shown = [str(component.p.index[name]) for name in FIELD.findall(sentence)]
    if len(shown) > MOST_SHOWN:
        raise ValueError(f"{component.name}: name at most {MOST_SHOWN} parameters in '{sentence}'")
    text = "%.9g".join(FIELD.sub("\0", sentence).replace("%", "%%").split("\0"))
    return f"{{{_string(f'.{text}')}, {{{', '.join(shown) or 0}}}}}"


_ESCAPED = [chr(byte) if 32 <= byte < 127 else f"\\{byte:03o}" for byte in range(256)]
_ESCAPED[ord("\\")], _ESCAPED[ord('"')], _ESCAPED[ord("\n")] = "\\\\", '\\"', "\\n"
"""How each byte of a text stands in a string literal of C."""


def _string(text: str) -> str:
    """C string literal; what lies outside ASCII as octal escapes of its UTF-8."""
    return f'"{"".join(map(_ESCAPED.__getitem__, text.encode()))}"'
