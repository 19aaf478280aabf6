"""A law's C: the core with its header, a program that tests it, and a README."""

from __future__ import annotations

import re
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from warmlink.controllers.export.c_helpers import comment
from warmlink.controllers.export.c_text import C
from warmlink.controllers.export.core import Core
from warmlink.controllers.export.lines import wrapped
from warmlink.controllers.export.program.statements import Routine, Slot
from warmlink.controllers.export.texts import filled, listed, parameters
from warmlink.controllers.export.vectors import SAMPLES

ALLOWED = {"double": 1e-12, "single": 0.05e-6}
"""Largest difference of the correction from the test vectors, in m."""


def export_files(core: Core) -> dict[str, str]:
    """Text of each file of an export to C by name; the README without what is measured."""
    return {
        f"{core.name}.c": source(core),
        f"{core.name}.h": header(core),
        f"{core.name}_test.c": test_program(core),
        "README.md": readme(core),
    }


def printer(core: Core) -> C:
    """What prints the law."""
    return C(core.name, core.program, core.precision == "single")


def _origin(core: Core) -> str:
    return "\n".join(line for each in core.origin() for line in wrapped(f"   {each}", "     "))


def header(core: Core) -> str:
    """The text of `NAME.h`."""
    law, made = core.name, core.program
    recall, more, restart = "", "", ""
    if core.goes_on:
        fields = _fields(law, made.recall)
        recall = f"\n/* What a restart goes on from. */\ntypedef struct {{\n{fields}\n}} {law}_recall;\n"
        more = f"    {law}_recall recall;\n"
        restart = (
            "\n   `retained` are the outputs of that name before a restart, `passed` the time in s since;"
            "\n   where nothing was kept, a null pointer and 0."
        )
    if made.timed:
        more += "    unsigned long samples;\n"
    return filled(
        core,
        "law.h",
        origin=_origin(core),
        real="float" if core.precision == "single" else "double",
        inputs=_fields(law, made.inputs),
        outputs=_fields(law, made.outputs),
        states=_fields(law, made.states),
        recall=recall,
        more=more,
        restart=restart,
        init=_init(core),
        step=_step(core),
    )


def _fields(law: str, slots: Iterable[Slot]) -> str:
    lines = []
    for slot in slots:
        size = f"[{slot.size}]" if slot.shape else ""
        about = f"{slot.unit}: {slot.about}" if slot.about else slot.unit
        text = f"    {law}_real {slot.name}{size};"
        told = f"{text} /* {about} */"
        lines += [told] if len(told) <= 110 else [*(f"    {line}" for line in comment(about)), text]
    return "\n".join(lines)


def _init(core: Core) -> str:
    law = core.name
    kept = f", const {law}_real retained[], {law}_real passed" if core.goes_on else ""
    return f"void {law}_init({law} *law, const {law}_inputs *u{kept})"


def _step(core: Core) -> str:
    return f"void {core.name}_step({core.name} *law, const {core.name}_inputs *u)"


def source(core: Core) -> str:
    """The text of `NAME.c`."""
    made, text = core.program, printer(core)
    functions = [line for routine in made.routines for line in text.function(routine)]
    helpers = text.helpers()
    body = "\n".join((*helpers, *functions))
    time = f"({core.name}_real)law->samples * {text.number(core.period)}"
    beginning = _begun(core, text)
    stepping: list[str] = []
    if made.timed:
        stepping.append("    law->samples++;")
    stepping += _called(text, made.update, time)
    stepping.append("    law->state = next;")
    stepping += _called(text, made.outputs_of, time)
    return filled(
        core,
        "law.c",
        origin=_origin(core),
        includes=("#include <math.h>\n" if re.search(r"\b(NAN|[a-z]+f?\()", body) else "")
        + "#include <stdbool.h>\n#include <stddef.h>\n",
        constants="\n".join(text.constants()),
        helpers="\n".join((*helpers, "")) if helpers else "",
        functions="\n".join((*functions, "")),
        init=_init(core),
        step=_step(core),
        beginning="".join(f"{line}\n" for line in beginning),
        stepping="".join(f"{line}\n" for line in stepping),
        zero=text.number(0.0),
    )


def _begun(core: Core, text: C) -> list[str]:
    made, lines = core.program, list[str]()
    if "input" not in {*made.begin.records(), *made.outputs_of.records()}:
        lines.append("    (void)u;")
    if core.goes_on:
        (recalled, waited), none = made.recall, text.number(0.0)
        lines += [
            "    int i;",
            f"    for (i = 0; i < {recalled.size}; i++) {{",
            f"        law->recall.{recalled.name}[i] = (retained == NULL) ? {none} : retained[i];",
            "    }",
            f"    law->recall.{waited.name} = (retained == NULL) ? {text.number(-1.0)} : passed;",
        ]
    if made.timed:
        lines.append("    law->samples = 0;")
    lines += _called(text, made.begin, text.number(0.0), "&law->state")
    return lines + _called(text, made.outputs_of, text.number(0.0))


def _called(text: C, routine: Routine, time: str, into: str = "&next") -> list[str]:
    place = {
        "state": "&law->state",
        "next": into,
        "input": "u",
        "output": "&law->outputs",
        "recall": "&law->recall",
        "clock": time,
    }
    given = [place[name] for name in routine.records()]
    return [f"    {text.name(routine)}({', '.join(given)});"]


def test_program(core: Core) -> str:
    """A C program that runs the law through the test vectors; it ends with 0 where they are met."""
    given, taken = core.vectors.inputs, core.vectors.outputs
    names = core.component.y.names
    allowed = [_allowed(core, name, taken[:, k]) for k, name in enumerate(names)]
    return filled(
        core,
        "test.c",
        origin=_origin(core),
        given=_table(given),
        taken=_table(taken),
        count=len(given),
        input_count=given.shape[1],
        output_count=taken.shape[1],
        input_names="\n   ".join(core.component.u.names),
        output_names="\n   ".join(names),
        nothing=", NULL, 0" if core.goes_on else "",
        allowed=", ".join(allowed),
        correction=core.component.y.index["correction"],
    )


def _allowed(core: Core, name: str, values: NDArray[np.float64]) -> str:
    """How far an output may be off: flags and what is retained in single precision as they come."""
    size = float(np.max(np.abs(values), initial=0.0))
    if core.precision == "double":
        return repr(max(1e-12, 1e-9 * size))
    return repr(ALLOWED["single"]) if name in ("correction", "predicted_elongation") else "INFINITY"


def _table(rows: NDArray[np.float64]) -> str:
    text = "".join("    {" + ", ".join(repr(float(each)) for each in row) + "},\n" for row in rows)
    return re.sub(r"\binf\b", "INFINITY", re.sub(r"\bnan\b", "NAN", text))


_RESTART = """
After a restart, `retained` are the outputs of that name that were stored before, and `passed` is the time
in s since then; where nothing was stored, give a null pointer and 0. What does not add up is not used.
"""

_NAN = """Every input but `drift_valid` may be NaN: a reading that is missing. A thermometer's reading beyond
10,000 K counts as NaN. A law leaves out what is NaN, and says so by `distrusted`; it goes on with the next
good reading."""


_NO_NAN = """This law gives no number where a reading is missing (NaN) or none that can be: give it none
such, and do not use its correction meanwhile."""


def readme(core: Core, measured: str = "") -> str:
    """How to use the export, and what it needs, with a text on what was measured."""
    size, made = 4 if core.precision == "single" else 8, core.program
    numbers = sum(slot.size for slot in (*made.states, *made.outputs, *made.recall))
    constants = sum(
        slot.size * ((1 if slot.values.max() < 128 else 2) if slot.whole else size) for slot in made.design
    )
    return filled(
        core,
        "readme.txt",
        origin="\n".join(core.origin()),
        precision=core.precision,
        memory=numbers * size + (8 if made.timed else 0),
        constants=constants,
        operations=core.operations(),
        samples=SAMPLES,
        kept=", retained, passed" if core.goes_on else "",
        more=_RESTART if core.goes_on else "",
        nan=_NAN if core.vectors.wild else _NO_NAN,
        measured=measured,
        inputs=listed(made.inputs),
        outputs=listed(made.outputs),
        parameters=parameters(core),
    )
