"""CasADi's functions as C: their text, cut down to what is called, and wrapped for `model.h`."""

import re
from collections import Counter
from collections.abc import Collection, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from warmlink.fmus.component import Component
from warmlink.fmus.packaging.native.moved_less import without_copies
from warmlink.fmus.packaging.native.straight_code import with_straight_code

Expression = Any
"""A CasADi SX or MX."""

Function = tuple[str, list[Expression], Expression]
"""Name, arguments and result of a function that CasADi writes."""


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
    def of(cls, component: Component, calls: bool = False) -> "Symbols":
        """Fresh symbols for a component; `d` are the parameters and what they settle.

        With `calls` functions marked `kept_whole` stay calls, and vectors loops (MX); otherwise all is
        written out number by number (SX).
        """
        import casadi

        kind = casadi.MX if calls else casadi.SX
        sizes = {"x": component.x.size, "u": component.u.size, "p": component.p.size, "d": component.d.size}
        vectors = {name: kind.sym(name, size) for name, size in sizes.items()}
        return cls(**vectors, time=kind.sym("time"), step=kind.sym("step"))

    @property
    def now(self) -> list[Expression]:
        """States, inputs, settled parameters and time."""
        return [self.x, self.u, self.d, self.time]


def beginning(component: Component, suffix: str = "") -> Iterator[Function]:
    """Yield `begin`, the states at the start, and `begin_tangent`, their derivative along inputs."""
    import casadi

    if not component.states:
        return
    s = Symbols.of(component, calls=component.sampled)
    yield f"begin{suffix}", [s.u, s.d], component.states_at_start(s.u, s.d)
    s = Symbols.of(component)
    begun, along = component.states_at_start(s.u, s.d), casadi.SX.sym("also", component.u.size)
    yield f"begin_tangent{suffix}", [s.u, s.d, along], casadi.jtimes(begun, s.u, along)


def sampling(component: Component, clock: int, name: str = "sample") -> Function:
    """States of a clock after a sample; the function's name ends with the clock's number."""
    s = Symbols.of(component, calls=component.sampled)
    updated = component.updated(s.x, s.u, s.d, s.time, s.step, component.clocks[clock])
    return f"{name}_{clock}", [*s.now, s.step], updated


DECLARED = ("settle", "margins", "begin", "begin_tangent", "advance", "rates", "rates_tangent", "tangent")
"""Functions that `model.h` declares; others are for the generated file alone."""

_TABLE = re.compile(r"static const casadi_\w+ (casadi_s\d+|casadi_zeros)\[\d+\] =.*?;\n", re.DOTALL)
"""A table of indices, or of zeros."""

_COPIES = (
    (r"for \(i=0; i<n; \+\+i\) \*y\+\+ = \*x\+\+;", "memmove(y, x, n*sizeof *x);"),
    (
        r"for \(i=0, cs=(\w+); i<(\d+); \+\+i\) \*rr\+\+ = \*cs\+\+;",
        r"memmove(rr, \1, \2*sizeof *rr); rr += \2;",
    ),
)
"""Loops that copy, number by number, and what takes their place."""


def function(name: str, arguments: list[Expression], result: Expression) -> Any:
    """CasADi function of one result, in the kind of expression that its arguments are."""
    import casadi

    kind = type(arguments[0])
    with unsimplified():
        return casadi.Function(name, arguments, [casadi.cse(casadi.densify(kind(result)))])


@contextmanager
def unsimplified() -> Iterator[None]:
    """Keep expressions as they are written: CasADi turns each product with a reciprocal into a division."""
    import casadi

    casadi.GlobalOptions.setSimplificationOnTheFly(False)
    try:
        yield
    finally:
        casadi.GlobalOptions.setSimplificationOnTheFly(True)


def functions_file(prefix: str, functions: Iterable[Any]) -> str:
    """C file with functions from `function` for `model.h`."""
    text = functions_text(prefix, functions)
    for loop, copy in _COPIES:
        text = re.sub(loop, copy, text)
    return '#include "model.h"\n' + "#include <string.h>\n" * ("memmove(" in text) + "\n" + text


def functions_text(prefix: str, functions: Iterable[Any], declared: Collection[str] = DECLARED) -> str:
    """C functions from `function`, each as `void NAME(const double *a0, ..., double *result)`.

    The prefix is that of the names of CasADi's own helpers. A header declares those `declared` under
    `WL(NAME)`; the others are `static`, as `NAME_of`.
    """
    import casadi

    # CasADi takes the names of its helper functions from the file's.
    options: dict[str, Any] = {"with_header": False, "verbose": False, "casadi_int": "int"}
    generator = casadi.CodeGenerator(f"{prefix}.c", options)
    wrappers = []
    functions = list(functions)
    for each in functions:
        generator.add(each, False)
        wrappers.append(_wrapper(each, declared))
    text = with_straight_code(without_copies(_trimmed(generator.dump())), functions)
    return "#define CASADI_SYMBOL_EXPORT static\n\n" + text + "".join(wrappers)


def _trimmed(text: str) -> str:
    """CasADi's C without what nobody calls, nor asks whether arguments are given, which all are."""
    kept, dropping = [], False
    for line in text.splitlines(keepends=True):
        described = line.startswith("CASADI_SYMBOL_EXPORT") and "(const casadi_real** arg" not in line
        if not (dropping or described):
            kept.append(line)
        ends = line == "}\n" or (described and line.endswith("}\n"))
        dropping = (dropping or described) and not ends
    text = re.sub(r"(arg\[\d+\]) ?\? \1(\[\d+\])? : (0|casadi_zeros)", r"\1\2", "".join(kept))
    named = Counter(re.findall(r"casadi_s\d+|casadi_zeros", text))  # where prefixed and defined, at least
    return _TABLE.sub(lambda table: table[0] if named[table[1]] > 2 else "", text)


def _wrapper(function: Any, declared: Collection[str]) -> str:
    name, inputs = function.name(), function.n_in()
    parameters = ", ".join(f"const double *a{i}" for i in range(inputs))
    listed = ", ".join(f"a{i}" for i in range(inputs))
    called = f"WL({name})" if name in declared else f"{name}_of"
    linkage = "" if name in declared else "static "
    scratch, given = "", "0, 0"
    if function.is_a("MXFunction"):
        scratch = f"    int places[{function.sz_iw() + 1}];\n    double work[{function.sz_w() + 1}];\n"
        given = "places, work"
    return (
        f"\n{linkage}void {called}({parameters}, double *result)\n{{\n"
        f"    const double *arguments[{function.sz_arg()}] = {{{listed}}};\n"
        f"    double *results[{function.sz_res()}] = {{result}};\n{scratch}"
        f"    {name}(arguments, results, {given}, 0);\n}}\n"
    )
