"""A law as Structured Text: the function block that a task calls, and those and the functions inside."""

from __future__ import annotations

import textwrap
from dataclasses import dataclass, replace

from warmlink.controllers.export.core import Core
from warmlink.controllers.export.lines import WIDTH, wrapped
from warmlink.controllers.export.program.statements import Slot, kinds_of
from warmlink.controllers.export.st_text import BlockText, Declaration, StructuredText, number

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
    "left": (
        "What rounding leaves of b where it is added to a.",
        "ab",
        ["{0} := b - ((a + b) - a);"],
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


@dataclass(frozen=True)
class Blocks:
    """A law as types and units, each after those that it needs."""

    arrays: list[tuple[str, int, str]]
    state: tuple[str, list[Declaration]]
    units: list[BlockText]


def blocks(core: Core) -> Blocks:
    """The law as what a controller's project holds."""
    made = core.program
    printer = StructuredText(core.name, made, core.precision == "single")
    used = {kind for routine in made.routines for kind in kinds_of(routine.body)}
    functions = [_function(printer, name) for name in FUNCTIONS if name in used]
    roots = {id(made.update), id(made.outputs_of)}
    inner = [printer.block(routine) for routine in made.routines if id(routine) not in roots]
    state = f"{core.name}_state", [printer.variable(slot) for slot in made.states]
    return Blocks(printer.arrays(), state, [*functions, *inner, _law(core, printer)])


def _function(printer: StructuredText, name: str) -> BlockText:
    about, arguments, body = FUNCTIONS[name]
    full, real = f"{printer.law}_{name}", printer.real
    names = [arguments] if len(arguments) > 2 else list(arguments)
    own = [Declaration(each, real) for each in {"floor": ["whole"], "erf": ["term", "whole"]}.get(name, [])]
    own += [Declaration("i", "INT")] if name == "erf" else []
    sections = {"VAR_INPUT": [Declaration(each, real) for each in names], "VAR": own}
    return BlockText("FUNCTION", full, about, sections, [line.format(full, real) for line in body], real)


def _law(core: Core, printer: StructuredText) -> BlockText:
    """The function block that a task calls once each sample time."""
    made = core.program
    retained = [slot for slot in made.outputs if core.goes_on and slot.name == "retained"]
    inputs = [replace(printer.variable(slot), start=_start(core, slot)) for slot in made.inputs]
    inputs += [replace(printer.variable(PASSED), start=("-1.0",))] if core.goes_on else []
    own = [
        Declaration("running", "BOOL", ("FALSE",), "whether it has begun"),
        Declaration("x", f"{core.name}_state", (), "what it remembers"),
        Declaration("next", f"{core.name}_state", (), "what it will remember"),
        *(printer.variable(slot) for slot in made.recall),
        *([Declaration("samples", "LINT", ("0",), "since it began")] if made.timed else []),
        *([Declaration("elapsed", printer.real, (), "s: time since it began")] if made.timed else []),
        *printer.inner([made.update, made.outputs_of]),
    ]
    begin = Declaration(f"run_{made.begin.name}", f"{core.name}_{made.begin.name}")
    return BlockText(
        "FUNCTION_BLOCK",
        core.name,
        f"{core.description}. Call it every {core.period:g} s.",
        {
            "VAR_INPUT": inputs,
            "VAR_OUTPUT": [printer.variable(slot) for slot in made.outputs if slot not in retained],
            "VAR CONSTANT": [printer.constant(slot) for slot in made.design],
            "VAR RETAIN": [printer.variable(slot) for slot in retained],
            "VAR": own if begin in own else [*own, begin],
        },
        _body(core, printer),
    )


def _start(core: Core, slot: Slot) -> tuple[str]:
    """Start value of an input."""
    return (number(float(core.component.start_values()[1][core.component.u.index[slot.name]])),)


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
        # Summed up in single precision, tenths of a second would be off by percents within days.
        lines += [
            "  samples := samples + 1;",
            f"  elapsed := LINT_TO_{printer.real}(samples) * {number(core.period)};",
        ]
    lines += [*printer.statements(made.update.body, 1), "END_IF;", "x := next;"]
    return [*lines, *printer.statements(made.outputs_of.body)]


def structured_text(core: Core) -> str:
    """The law's types, functions and function blocks as text."""
    made = blocks(core)
    told = (f"{core.description}.", *core.origin())
    about = (line for each in told for line in wrapped(f"  {each}", "    "))
    lines = ["(*", *about, "*)", "", "TYPE"]
    lines += [f"  {name} : ARRAY [0..{size - 1}] OF {of};" for name, size, of in made.arrays]
    name, fields = made.state
    lines += [f"  {name} : STRUCT", *(line for each in fields for line in _declared(each, "    "))]
    lines += ["  END_STRUCT;", "END_TYPE", ""]
    return "\n".join((*lines, *(line for unit in made.units for line in _unit(unit))))


def _unit(unit: BlockText) -> list[str]:
    head = f"{unit.head} {unit.name}" + (f" : {unit.returns}" if unit.returns else "")
    lines = [head, *(textwrap.wrap(f"(* {unit.about} *)", WIDTH) if unit.about else [])]
    for word, variables in unit.sections.items():
        if variables:
            lines += [word, *(line for each in variables for line in _declared(each, "  ")), "END_VAR"]
    return [*lines, *unit.body, f"END_{unit.head}", ""]


def _declared(variable: Declaration, pad: str) -> list[str]:
    """Declaration of a variable, with unit and description in a comment."""
    start = ", ".join(variable.start)
    start = f" := [{start}]" if len(variable.start) > 1 else f" := {start}" if start else ""
    text, told = f"{pad}{variable.name} : {variable.type}{start};", variable.told.replace("*)", ")")
    if told and len(text) + len(told) + 7 <= WIDTH:
        return [f"{text} (* {told} *)"]
    comment = textwrap.wrap(f"(* {told} *)", WIDTH - len(pad)) if told else []
    return [*(f"{pad}{line}" for line in comment), *wrapped(text, f"{pad}    ")]
