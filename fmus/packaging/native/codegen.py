"""From a component's declaration to C: its functions by CasADi, its variables as a table."""

from collections.abc import Iterator, Sequence
from itertools import accumulate
from typing import Any

from warmlink.fmus.component import FIELD, MOST_IN_A_STEP, Component, Input, Parameter, Scalar, limits
from warmlink.fmus.packaging.exchange import exchanged_states
from warmlink.fmus.packaging.native.casadi_code import (
    Expression,
    Symbols,
    beginning,
    function,
    functions_file,
    sampling,
)
from warmlink.fmus.packaging.native.joint_code import (
    running_parts,
    sample_glue,
    starting_glue,
    starting_parts,
)
from warmlink.fmus.packaging.native.micro_step import choice_of_step, stepping
from warmlink.fmus.packaging.native.output_groups import output_groups


def generate(component: Component, arrays: bool = False) -> dict[str, str]:
    """Write the generated C files of a component, all but `identity.h`.

    Parameters
    ----------
    component : the declaration
    arrays : an array is exchanged as a whole, by the value reference of its first element

    Returns
    -------
    dict
        Texts of `component.h` (sizes), of `starting.c` and `running.c` (by CasADi: what runs once and what
        runs all the time) and of `variables.c` (a table).
    """
    groups = output_groups(component)
    name = component.name
    starting = functions_file(f"{name}_starting", starting_functions(component))
    running = functions_file(f"{name}_running", running_functions(component, groups))
    if component.joint is not None:
        starting += starting_glue(component, component.joint)
        running += sample_glue(component, component.joint)
    if component.continuous.size:
        running += choice_of_step(component, ("x", "u", "later", "d", "time", "step"))
    return {
        "component.h": sizes_header(component, arrays),
        "starting.c": starting,
        "running.c": running
        + _dispatcher("outputs", "group", ("x", "u", "d", "time"), len(groups))
        + _dispatcher("sample", "clock", ("x", "u", "d", "time", "step"), len(component.clocks)),
        "variables.c": _variables_file(component, groups, arrays),
    }


def sizes_header(component: Component, arrays: bool) -> str:
    """Write `component.h`: sizes, and the prefix of the component's functions."""
    sizes = {
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
    }
    lines = [
        "/* Sizes of one component; generated. */",
        f"#define WL_PREFIX {component.name}_",
        f"#define WL_MICRO_STEP {float(component.micro_step)!r}",
        f"#define WL_MOST_IN_A_STEP {MOST_IN_A_STEP}",
        *(f"#define WL_{name} {value}" for name, value in sizes.items()),
    ]
    return "\n".join(lines) + "\n"


def identity_header(component: Component, token: str, state: str) -> str:
    """Write `identity.h`.

    Parameters
    ----------
    component : the declaration
    token : GUID or instantiation token that the FMU answers to
    state : what a serialised state must have been made by
    """
    lines = [
        "/* What one FMU is known by; generated. */",
        f"#define WL_NAME {_string(component.name)}",
        f"#define WL_TOKEN {_string(token)}",
        f"#define WL_STATE_ID {_string(state)}",
    ]
    return "\n".join(lines) + "\n"


def starting_functions(component: Component) -> Iterator[Any]:
    """Yield the CasADi functions that run once for each instance, as the C wrapper calls them."""
    import casadi

    s = Symbols.of(component)
    margins = [check.margin(component.p.read(s.p)) for check in component.checks]
    yield function("margins", [s.p], casadi.vertcat(*margins))
    if component.joint is not None:
        for part in starting_parts(component, component.joint, [s.x, s.u, s.d, s.time]):
            yield function(*part)
        return
    yield function("settle", [s.p], component.settled(s.p))
    for part in beginning(component):
        yield function(*part)


def running_functions(component: Component, groups: Sequence[Sequence[int]]) -> Iterator[Any]:
    """Yield the CasADi functions that run all the time, as the C wrapper calls them."""
    import casadi

    s = Symbols.of(component)
    now = [s.x, s.u, s.d, s.time]
    if component.joint is not None:
        for part in running_parts(component, component.joint, now):
            yield function(*part)
    else:
        for number in range(len(component.clocks)):
            yield function(*sampling(component, number))
    if component.continuous.size:
        later = _like(s.u)
        for part in stepping(component, s, later):
            yield function(*part)
        if not component.sampled:  # what samples gives no output derivatives
            yield from _with_tangent("rates", s, component.rates_of(*now))

    y = casadi.SX(component.outputs_of(*now))
    for number, group in enumerate(groups):
        yield function(f"outputs_{number}", now, y[group])
    yield list(_with_tangent("", s, y[: component.output_count]))[1]


def _with_tangent(name: str, s: Symbols, expression: Expression) -> Iterator[Any]:
    """Yield a function of the present, and its derivative along a direction of states, inputs and time."""
    import casadi

    moving = [s.x, s.u, s.time]
    along = [_like(each) for each in moving]
    expression = casadi.SX(expression)
    slope = casadi.jtimes(expression, casadi.vertcat(*moving), casadi.vertcat(*along))
    now = [s.x, s.u, s.d, s.time]
    yield function(name or "values", now, expression)
    yield function(f"{name}_tangent".lstrip("_"), [*now, *along], slope)


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
    rows = "".join(
        f"    {_row(scalar, arrays, place.get(scalar.reference, (0, 0)))},\n"
        for scalar in component.scalars()
    )
    sentences = "".join(
        f"    {_string(_numbered(component, check.sentence))},\n" for check in component.checks
    )
    states = "".join(
        f"    {{{_string(name)}, {int(state.accepts_nan)}}},\n"
        for state in component.states
        for name in state.scalar_names
    )
    starts = ", ".join(map(str, accumulate(map(len, groups[:-1]), initial=0)))
    clocks, first = "", component.continuous.size
    for clock in component.clocks:
        clocks += f"    {{{component.p.index[clock.sample_time]}, {first}, {clock.layout.size}}},\n"
        first += clock.layout.size
    nominals = ", ".join(repr(state.nominal) for state in exchanged_states(component)) or "0"
    return (
        "/* Variables of one component in the order of their value references; generated. */\n"
        '#include "model.h"\n\n'
        f"const Variable WL(variables)[] = {{\n{rows}}};\n\n"
        f"const StateVariable WL(state_variables)[] = {{\n{states}    {{0, 0}}\n}};\n\n"
        f"const char *const WL(sentences)[] = {{\n{sentences}    0\n}};\n\n"
        f"const double WL(nominals)[] = {{{nominals}}};\n\n"
        f"const int WL(group_starts)[] = {{{starts}}};\n\n"
        f"const Clock WL(clocks)[] = {{\n{clocks}    {{0, 0, 0}}\n}};\n"
    )


def _row(scalar: Scalar, arrays: bool, place: tuple[int, int]) -> str:
    variable = scalar.variable
    count = 1 if not arrays else 0 if scalar.element else variable.count
    bounds = [variable.minimum, variable.maximum]
    flags = [
        name
        for name, holds in (
            ("HAS_MINIMUM", variable.minimum is not None),
            ("HAS_MAXIMUM", variable.maximum is not None),
            ("POSITIVE", isinstance(variable, Parameter) and variable.positive),
            ("TUNABLE", isinstance(variable, Parameter) and variable.tunable),
            ("ACCEPTS_NAN", isinstance(variable, Input) and variable.accepts_nan),
        )
        if holds
    ]
    numbers = ", ".join(
        repr(float(value or 0)) for value in (scalar.start, *bounds, limits.ordinary_size(variable))
    )
    unit = "" if variable.unit == "1" else f" {variable.unit}"
    kind = variable.type.upper() if variable.choice is None else "ENUMERATION"
    return (
        f"{{{_string(scalar.name)}, {_string(unit)}, {numbers}, "
        f"{kind}, {' | '.join(flags) or 0}, {count}, {place[0]}, {place[1]}}}"
    )


def _numbered(component: Component, sentence: str) -> str:
    """Sentence whose `{length}` and `{sensor_position[1]}` are given by value reference: `{0}`."""
    return FIELD.sub(lambda field: f"{{{component.p.index[field[1]]}}}", sentence)


def _string(text: str) -> str:
    """C string literal; what lies outside ASCII as octal escapes of its UTF-8."""
    plain = {ord("\\"): "\\\\", ord('"'): '\\"', ord("\n"): "\\n"}
    encoded = "".join(
        plain.get(byte, chr(byte) if 32 <= byte < 127 else f"\\{byte:03o}") for byte in text.encode()
    )
    return f'"{encoded}"'
