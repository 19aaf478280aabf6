"""A law as Structured Text: one function block that a task calls, and the blocks and functions inside it."""

from __future__ import annotations

import textwrap

from warmlink.controllers.export.c_text import kinds_of
from warmlink.controllers.export.core import Core
from warmlink.controllers.export.lines import WIDTH, wrapped
from warmlink.controllers.export.program.statements import Slot
from warmlink.controllers.export.st_text import StructuredText, number

FUNCTIONS = {
    "larger": (
        "The larger of two numbers; b where one is NaN.",
        "ab",
        ["IF a > b THEN", "  {0} := a;", "ELSE", "  {0} := b;", "END_IF;"],
    ),
    "smaller": (
        "The smaller of two numbers; b where one is NaN.",
        "ab",
        ["IF a < b THEN", "  {0} := a;", "ELSE", "  {0} := b;", "END_IF;"],
    ),
    "ratio": (
        "a / b; 0 where b is 0, and NaN where it is NaN.",
        "ab",
        ["IF (b > 0.0) OR (b < 0.0) THEN", "  {0} := a / b;", "ELSE", "  {0} := b * 0.0;", "END_IF;"],
    ),
    "root": (
        "Square root; 0 below 0.",
        "a",
        ["IF a < 0.0 THEN", "  {0} := 0.0;", "ELSE", "  {0} := SQRT(a);", "END_IF;"],
    ),
    "no_number": (
        "NaN, which stands for a reading that is missing; zero is 0.",
        "zero",
        ["{0} := zero / zero;"],
    ),
    "floor": (
        "Largest whole number not above a.",
        "a",
        [
            "whole := LINT_TO_{1}({1}_TO_LINT(a));",
            "IF whole > a THEN",
            "  whole := whole - 1.0;",
            "ELSIF whole + 1.0 <= a THEN",
            "  whole := whole + 1.0;",
            "END_IF;",
            "{0} := whole;",
        ],
    ),
    "erf": (
        "Error function: M. Abramowitz and I. A. Stegun, Handbook of Mathematical Functions, 7.1.6.",
        "a",
        [
            "term := a;",
            "whole := a;",
            "FOR i := 1 TO 150 DO",
            "  term := term * 2.0 * a * a / (2.0 * INT_TO_{1}(i) + 1.0);",
            "  whole := whole + term;",
            "END_FOR;",
            "IF ABS(a) < 6.0 THEN",
            "  {0} := 1.1283791670955126 * EXP(-(a * a)) * whole;",
            "ELSE",
            "  {0} := SEL(a > 0.0, -1.0, 1.0);",
            "END_IF;",
        ],
    ),
}
"""Functions that a law may use beside those of the standard: what they are, arguments, statements."""

PASSED = Slot(
    "passed",
    (),
    "input",
    unit="s",
    about="time for which the controller was off; below 0: unknown, nothing is recalled",
)


def st_files(core: Core) -> dict[str, str]:
    """Text of each file of an export to Structured Text by name."""
    return {f"{core.name}.st": structured_text(core)}


def structured_text(core: Core) -> str:
    """The law's types, functions and function blocks, each after those that it needs."""
    printer = StructuredText(core.name, core.program, core.precision == "single")
    lines = ["(*", f"  {core.component.description}.", *(f"  {each}" for each in core.origin()), "*)", ""]
    lines += printer.types()
    for name in _needed(core):
        lines += _function(printer, name)
    roots = {id(core.program.update), id(core.program.outputs_of)}
    for routine in core.program.routines:
        if id(routine) not in roots:
            lines += printer.block(routine)
    return "\n".join((*lines, *_law(core, printer), ""))


def _needed(core: Core) -> list[str]:
    used = {kind for routine in core.program.routines for kind in kinds_of(routine.body)}
    return [name for name in FUNCTIONS if name in used]


def _function(printer: StructuredText, name: str) -> list[str]:
    about, arguments, body = FUNCTIONS[name]
    full, real = f"{printer.law}_{name}", printer.real
    names = [arguments] if len(arguments) > 2 else list(arguments)
    own = {"floor": ["whole"], "erf": ["term", "whole"]}.get(name, [])
    variables = [f"  {each} : {real};" for each in own] + (["  i : INT;"] if name == "erf" else [])
    return [
        f"FUNCTION {full} : {real}",
        f"(* {about} *)",
        "VAR_INPUT",
        *(f"  {each} : {real};" for each in names),
        "END_VAR",
        *printer.section("VAR", variables),
        *(line.format(full, real) for line in body),
        "END_FUNCTION",
        "",
    ]


def _law(core: Core, printer: StructuredText) -> list[str]:
    """The function block that a task calls once each sample time."""
    made = core.program
    about = f"{core.component.description}. Call it every {core.period:g} s."
    lines = [f"FUNCTION_BLOCK {core.name}", *textwrap.wrap(f"(* {about} *)", WIDTH)]
    inputs = [*made.inputs, *([PASSED] if core.goes_on else [])]
    declared = [
        line
        for slot in inputs
        for line in printer.declared(slot, start=" := -1.0" if slot is PASSED else _start(core, slot))
    ]
    lines += printer.section("VAR_INPUT", declared)
    retained = [slot for slot in made.outputs if core.goes_on and slot.name == "retained"]
    outputs = [slot for slot in made.outputs if slot not in retained]
    lines += printer.section("VAR_OUTPUT", [line for s in outputs for line in printer.declared(s)])
    lines += printer.section("VAR CONSTANT", [line for s in made.design for line in printer.constant(s)])
    lines += printer.section("VAR RETAIN", [line for s in retained for line in printer.declared(s)])
    own = ["  running : BOOL := FALSE; (* whether it has begun *)"]
    own += [f"  x : {core.name}_state;", f"  next : {core.name}_state;"]
    own += [line for slot in made.recall for line in printer.declared(slot)]
    own += ["  elapsed : " + printer.real + "; (* s: time since it began *)"] if made.timed else []
    own += [line for line in printer.inner([made.update, made.outputs_of]) if line not in own]
    begin = f"  run_{made.begin.name} : {core.name}_{made.begin.name};"
    own += [] if begin in own else [begin]
    lines += printer.section("VAR", own)
    return [*lines, *_body(core, printer), "END_FUNCTION_BLOCK"]


def _start(core: Core, slot: Slot) -> str:
    """Start value of an input."""
    start = core.component.start_values()[1][core.component.u.index[slot.name]]
    return f" := {number(float(start))}"


def _body(core: Core, printer: StructuredText) -> list[str]:
    made = core.program
    block = printer.blocks[id(made.begin)]
    given = [f"{slot.name} := {slot.name}" for slot in block.given]
    given += ["next := next"] if "next" in block.records else []
    lines = ["IF NOT running THEN"]
    if core.goes_on:
        recalled, waited = made.recall
        lines += [f"  {recalled.name} := retained;", f"  {waited.name} := passed;"]
    lines += wrapped(f"  run_{made.begin.name}({', '.join(given)});", "      ")
    lines += ["  running := TRUE;", "ELSE"]
    if made.timed:
        lines.append(f"  elapsed := elapsed + {number(core.period)};")
    lines += [*printer.statements(made.update.body, 1), "END_IF;", "x := next;"]
    return [*lines, *printer.statements(made.outputs_of.body)]
