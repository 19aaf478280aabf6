"""From a component's declaration to C: its functions by CasADi, its variables as a table."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from warmlink.fmus.packaging.component import MOST_IN_A_STEP, Component, Input, Parameter, Scalar
from warmlink.fmus.packaging.elimination import Factorisation
from warmlink.fmus.packaging.integrator import GAMMA
from warmlink.fmus.packaging.output_groups import output_groups

Expression = Any
"""A CasADi SX."""


@dataclass(frozen=True)
class Symbols:
    """What the functions of a component depend on, flat, as CasADi symbols."""

    x: Expression
    u: Expression
    p: Expression
    d: Expression
    time: Expression
    step: Expression

    @classmethod
    def of(cls, component: Component) -> Symbols:
        """Fresh symbols for a component; `d` are the parameters and what they settle."""
        import casadi

        sizes = {"x": component.x.size, "u": component.u.size, "p": component.p.size, "d": component.d.size}
        vectors = {name: casadi.SX.sym(name, size) for name, size in sizes.items()}
        return cls(**vectors, time=casadi.SX.sym("time"), step=casadi.SX.sym("step"))


def generate(component: Component) -> dict[str, str]:
    """Write the generated C files of a component, all but `identity.h`.

    Returns
    -------
    dict
        Texts of `component.h` (sizes), of `starting.c` and `running.c` (by CasADi: what runs once and what
        runs all the time) and of `variables.c` (a table).
    """
    groups = output_groups(component)
    name = component.name
    running = _functions_file(f"{name}_running", running_functions(component, groups))
    return {
        "component.h": sizes_header(component),
        "starting.c": _functions_file(f"{name}_starting", starting_functions(component)),
        "running.c": running + _output_dispatcher(len(groups)),
        "variables.c": _variables_file(component, groups),
    }


def sizes_header(component: Component) -> str:
    """Write `component.h`: sizes, and the prefix of the component's functions."""
    groups = output_groups(component)
    sizes = {
        "PARAMETERS": component.p.size,
        "INPUTS": component.u.size,
        "OUTPUTS": component.y.size,
        "STATES": component.x.size,
        "SETTLED": component.d.size,
        "CHECKS": len(component.checks),
        "GROUPS": len(groups),
        "LARGEST_GROUP": max(map(len, groups), default=0),
        "SAMPLED": int(component.sampled),
        "SAMPLE_TIME": component.p.index["sample_time"] if component.sampled else -1,
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
    """Yield the CasADi functions that run once an instance, as the C wrapper calls them."""
    import casadi

    s = Symbols.of(component)
    yield _function("settle", [s.p], component.settled(s.p))
    margins = [check.margin(component.p.read(s.p)) for check in component.checks]
    yield _function("margins", [s.p], casadi.vertcat(*margins))
    if component.states:
        begun = component.states_at_start(s.u, s.d)
        yield _function("begin", [s.u, s.d], begun)
        yield _function("begin_tangent", [s.u, s.d, along := _like(s.u)], casadi.jtimes(begun, s.u, along))


def running_functions(component: Component, groups: Sequence[Sequence[int]]) -> Iterator[Any]:
    """Yield the CasADi functions that run all the time, as the C wrapper calls them."""
    import casadi

    s = Symbols.of(component)
    now = [s.x, s.u, s.d, s.time]
    if component.sampled:
        updated = component.updated(s.x, s.u, s.d, s.time, s.step)
        yield _function("advance", [*now, s.step], updated)
    elif component.states:
        later = _like(s.u)
        yield _function("advance", [s.x, s.u, later, s.d, s.time, s.step], micro_step(component, s, later))
        yield _function("rates", now, component.rates_of(*now))

    y = casadi.SX(component.outputs_of(*now))
    for number, group in enumerate(groups):
        yield _function(f"outputs_{number}", now, y[group])
    moving = [s.x, s.u, s.time]
    along = [_like(each) for each in moving]
    slope = casadi.jtimes(y, casadi.vertcat(*moving), casadi.vertcat(*along))
    yield _function("tangent", [*now, *along], slope)


def micro_step(component: Component, s: Symbols, later: Expression) -> Expression:
    """State after one step of ROS2, the method of the Python form, as expressions.

    Parameters
    ----------
    component : a component with rates
    s : its symbols, the inputs being those at the start of the step
    later : inputs at the end of the step, shape (u.size,)
    """
    import casadi

    slope = component.rates_of(s.x, s.u, s.d, s.time)
    system = Factorisation(casadi.SX.eye(s.x.numel()) - GAMMA * s.step * casadi.jacobian(slope, s.x))
    first = system.solve(slope)
    ahead = component.rates_of(s.x + s.step * first, later, s.d, s.time + s.step)
    second = system.solve(ahead - 2 * first)
    return s.x + s.step * (1.5 * first + 0.5 * second)


def _like(symbols: Expression) -> Expression:
    import casadi

    return casadi.SX.sym("also", symbols.numel())


def _function(name: str, arguments: list[Expression], result: Expression) -> Any:
    import casadi

    return casadi.Function(name, arguments, [casadi.cse(casadi.densify(casadi.SX(result)))])


def _functions_file(prefix: str, functions: Iterable[Any]) -> str:
    import casadi

    # CasADi takes the names of its helper functions from the file's.
    generator = casadi.CodeGenerator(f"{prefix}.c", {"with_header": False, "verbose": False})
    wrappers = []
    for function in functions:
        generator.add(function, False)
        wrappers.append(_wrapper(function.name(), function.n_in()))
    head = '#include "model.h"\n\n#define CASADI_SYMBOL_EXPORT static\n\n'
    return head + generator.dump() + "".join(wrappers)


def _wrapper(name: str, inputs: int) -> str:
    parameters = ", ".join(f"const double *a{i}" for i in range(inputs))
    listed = ", ".join(f"a{i}" for i in range(inputs))
    linkage, called = ("static ", f"group_{name[8:]}") if name.startswith("outputs_") else ("", f"WL({name})")
    return (
        f"\n{linkage}void {called}({parameters}, double *result)\n{{\n"
        f"    const double *arguments[] = {{{listed}}};\n    double *results[] = {{result}};\n"
        f"    {name}(arguments, results, 0, 0, 0);\n}}\n"
    )


def _output_dispatcher(groups: int) -> str:
    if groups == 0:
        return ""
    cases = "".join(f"    case {i}: group_{i}(x, u, d, time, result); break;\n" for i in range(groups))
    return (
        "\nvoid WL(outputs)(int group, const double *x, const double *u, const double *d,\n"
        "                 const double *time, double *result)\n{\n"
        f"    switch (group) {{\n{cases}    }}\n}}\n"
    )


def _variables_file(component: Component, groups: Sequence[Sequence[int]]) -> str:
    first_output = component.p.size + component.u.size
    place = {
        first_output + output: (number, position)
        for number, group in enumerate(groups)
        for position, output in enumerate(group)
    }
    rows = "".join(
        f"    {_row(scalar, place.get(scalar.reference, (0, 0)))},\n" for scalar in component.scalars()
    )
    sentences = "".join(
        f"    {_string(_numbered(component, check.sentence))},\n" for check in component.checks
    )
    states = "".join(
        f"    {{{_string(name)}, {int(state.accepts_nan)}}},\n"
        for state in component.states
        for name in state.scalar_names
    )
    sizes = ", ".join(str(len(group)) for group in groups) or "0"
    return (
        "/* Variables of one component in the order of their value references; generated. */\n"
        '#include "model.h"\n\n'
        f"const Variable WL(variables)[] = {{\n{rows}}};\n\n"
        f"const StateVariable WL(state_variables)[] = {{\n{states}    {{0, 0}}\n}};\n\n"
        f"const char *const WL(sentences)[] = {{\n{sentences}    0\n}};\n\n"
        f"const int WL(group_sizes)[] = {{{sizes}}};\n"
    )


def _row(scalar: Scalar, place: tuple[int, int]) -> str:
    variable = scalar.variable
    bounds = [variable.minimum, variable.maximum]
    flags = [
        name
        for name, holds in (
            ("HAS_MINIMUM", variable.minimum is not None),
            ("HAS_MAXIMUM", variable.maximum is not None),
            ("POSITIVE", isinstance(variable, Parameter) and variable.positive),
            ("ACCEPTS_NAN", isinstance(variable, Input) and variable.accepts_nan),
        )
        if holds
    ]
    numbers = ", ".join(repr(float(value or 0)) for value in (scalar.start, *bounds))
    unit = "" if variable.unit == "1" else f" {variable.unit}"
    kind = variable.type.upper()
    return (
        f"{{{_string(scalar.name)}, {_string(unit)}, {numbers}, "
        f"{kind}, {' | '.join(flags) or 0}, {place[0]}, {place[1]}}}"
    )


def _numbered(component: Component, sentence: str) -> str:
    """Sentence whose `{length}` and `{sensor_position[0]}` are given by value reference: `{0}`."""

    def number(match: re.Match[str]) -> str:
        stem, element = match["name"], match["element"]
        name = stem if element is None else f"{stem}[{int(element) + 1}]"
        return f"{{{component.p.index[name]}}}"

    return re.sub(r"\{(?P<name>\w+)(?:\[(?P<element>\d+)\])?\}", number, sentence)


def _string(text: str) -> str:
    """C string literal; what lies outside ASCII as octal escapes of its UTF-8."""
    plain = {ord("\\"): "\\\\", ord('"'): '\\"', ord("\n"): "\\n"}
    encoded = "".join(
        plain.get(byte, chr(byte) if 32 <= byte < 127 else f"\\{byte:03o}") for byte in text.encode()
    )
    return f'"{encoded}"'
