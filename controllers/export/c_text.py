"""A law's program as C99."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from warmlink.controllers.export.c_helpers import HELPERS, comment, helper
from warmlink.controllers.export.lines import wrapped
from warmlink.controllers.export.parts import divided
from warmlink.controllers.export.program.contraction import of_loops
from warmlink.controllers.export.program.program import LawProgram
from warmlink.controllers.export.program.statements import (
    For,
    Invoke,
    KnownNumber,
    Operation,
    Read,
    Routine,
    Set,
    Slot,
    Statement,
    Value,
    flat,
    kinds_of,
)

INFIX = {
    "add": ("+", 6),
    "sub": ("-", 6),
    "mul": ("*", 7),
    "div": ("/", 7),
    "lt": ("<", 5),
    "le": ("<=", 5),
    "gt": (">", 5),
    "ge": (">=", 5),
    "and": ("&&", 3),
    "or": ("||", 2),
}
"""Operators of C and how tightly they bind."""

FUNCTIONS = {"abs": "fabs", "exp": "exp", "log": "log", "sqrt": "sqrt", "sin": "sin", "cos": "cos"} | {
    "floor": "floor",
    "pow": "pow",
    "erf": "erf",
}
"""Functions of the C library."""

POINTERS = {
    "state": "x",
    "next": "next",
    "input": "u",
    "output": "y",
    "recall": "recall",
}
"""Records that functions are given, and what they call them."""


class C:
    """Prints one law."""

    def __init__(self, law: str, program: LawProgram, single: bool) -> None:
        self.law, self.program, self.single = law, program, single
        self.suffix = "f" if single else ""
        self.real = f"{law}_real"
        self._shared: set[int] = set()
        self._of_loops: dict[int, list[Slot]] = {}
        for routine in program.routines:
            self._of_loops |= of_loops(routine.body, routine.locals)
        whole = {id(routine): divided(routine, self._lines) for routine in program.routines}
        self._divided = {key: found for key, found in whole.items() if found is not None}
        self._shared.update(id(slot) for found in self._divided.values() for slot in found.shared)

    def _lines(self, statement: Statement) -> int:
        return len(self.statements([statement]))

    def number(self, value: float) -> str:
        """A number."""
        if np.isnan(value):
            return f"({self.real})NAN"
        if np.isinf(value) or (self.single and abs(value) > 3e38):
            value = np.copysign(3e38, value)
        return f"{float(value)!r}{self.suffix}"

    def read(self, read: Read) -> str:
        """A variable, or an element of it."""
        slot = read.slot
        text = slot.name
        if id(slot) in self._shared:
            text = f"work->{slot.name}"
        elif slot.record == "fresh":
            text = f"fresh.{slot.name}"
        elif slot.record in POINTERS:
            text = f"{POINTERS[slot.record]}->{slot.name}"
        elif slot.record in ("result", "kept") and not slot.array:
            return f"*{slot.name}"
        return text if read.place is None else f"{text}[{read.place.text()}]"

    def value(self, value: Value, outer: int = 0) -> str:
        """A value; in brackets where what is around it binds more tightly."""
        if isinstance(value, KnownNumber):
            text = self.number(value.value)
            return f"({text})" if text.startswith("-") and outer > 5 else text
        if isinstance(value, Read):
            return self.read(value)
        kind, of = value.kind, value.of
        if kind == "neg":
            text, level = f"-{self.value(of[0], 9)}", 8
        elif kind == "not":
            text, level = f"!{self.value(of[0], 9)}", 8
        elif kind == "eq":
            a, b = (self.value(each, 6) for each in of)
            text, level = f"({a} <= {b}) && ({a} >= {b})", 3
        elif kind == "select":
            text, level = f"{self.value(of[0], 7)} ? {self.value(of[1], 5)} : {self.value(of[2], 2)}", 1
        elif kind in INFIX:
            sign, level = INFIX[kind]
            inner = 7 if kind in ("and", "or") else level
            chained = isinstance(of[0], Operation) and of[0].kind == kind
            left = self.value(of[0], level if chained else inner)
            right = self.value(of[1], inner if kind in ("and", "or") else level + 1)
            text = f"{left} {sign} {right}"
        else:
            name = f"{FUNCTIONS[kind]}{self.suffix}" if kind in FUNCTIONS else f"{kind}"
            return f"{name}({', '.join(self.value(each) for each in of)})"
        return f"({text})" if level < outer else text

    def statements(self, body: Iterable[Statement], depth: int = 1) -> list[str]:
        """Lines of statements."""
        lines: list[str] = []
        pad = "    " * depth
        for each in body:
            if isinstance(each, Set):
                lines += wrapped(f"{pad}{self.assigned(each)}", f"{pad}    ")
            elif isinstance(each, For):
                name = each.variable
                lines.append(f"{pad}for ({name} = 0; {name} < {each.count}; {name}++) {{")
                lines += self.declared(self._of_loops.get(id(each), []), depth + 1)
                lines += [*self.statements(each.body, depth + 1), f"{pad}}}"]
            else:
                lines += self.invoked(each, depth)
        return lines

    def assigned(self, each: Set) -> str:
        """An assignment."""
        to, value = self.read(each.to), each.value
        if isinstance(value, Operation) and value.kind in ("add", "sub", "mul") and value.of[0] == each.to:
            return f"{to} {INFIX[value.kind][0]}= {self.value(value.of[1], 0)};"
        return f"{to} = {self.value(value)};"

    def invoked(self, each: Invoke, depth: int) -> list[str]:
        """A call, and the condition for it."""
        pad = "    " * depth
        lines = []
        if each.asked is not None:
            lines += wrapped(f"{pad}if ({self.value(each.asked)}) {{", f"{pad}    ")
            pad += "    "
        by_slot = {id(slot): value for slot, value in each.given}
        by_slot |= {id(slot): read for slot, read in each.results}
        pointers = POINTERS | ({"next": "&fresh"} if each.fresh else {})
        names = [*(pointers[name] for name in each.function.records() if name != "clock")]
        if "clock" in each.function.records():
            names.append("elapsed")
        for slot in (*each.function.kept, *each.function.arguments, *each.function.results):
            value = by_slot[id(slot)]
            if isinstance(value, Read) and not slot.array and slot.record != "argument":
                inner = self.read(value)
                names.append(inner[1:] if inner.startswith("*") else f"&{inner}")
            else:
                names.append(self.value(value))
        lines += wrapped(f"{pad}{self.name(each.function)}({', '.join(names)});", f"{pad}    ")
        return lines if each.asked is None else [*lines, f"{pad[:-4]}}}"]

    def name(self, routine: Routine) -> str:
        """Name of a function."""
        return f"{self.law}_{routine.name}"

    def signature(self, routine: Routine) -> str:
        """Head of a function."""
        records = routine.records()
        given = []
        for name in records:
            if name == "clock":
                continue
            kind = {"state": "state", "next": "state", "input": "inputs", "output": "outputs"}.get(name, name)
            const = "const " if name in ("state", "input", "recall") else ""
            given.append(f"{const}{self.law}_{kind} *{POINTERS[name]}")
        if "clock" in records:
            given.append(f"{self.real} elapsed")
        for slot in routine.kept:
            given.append(
                f"{self.real} {slot.name}[{slot.size}]" if slot.array else f"{self.real} *{slot.name}"
            )
        for slot in routine.arguments:
            const = f"const {self.real} {slot.name}[{slot.size}]"
            given.append(const if slot.array else f"{self.real} {slot.name}")
        for slot in routine.results:
            given.append(
                f"{self.real} {slot.name}[{slot.size}]" if slot.array else f"{self.real} *{slot.name}"
            )
        return f"static void {self.name(routine)}({', '.join(given) or 'void'})"

    def function(self, routine: Routine) -> list[str]:
        """A function, and in a comment what it computes; where it is long, in parts that it calls."""
        whole = self._divided.get(id(routine))
        if whole is None:
            return self.one(routine, self.statements(routine.body))
        record = f"{self.law}_{routine.name}_work" if whole.shared else ""
        members = [f"    {'bool' if s.condition else self.real} {_sized(s)};" for s in whole.shared]
        told = comment(f"What the parts of {routine.name} have in common.")
        lines = [*told, "typedef struct {", *members, f"}} {record};", ""] if record else []
        calls = [f"    {record} work;"] if record else []
        for part in whole.parts:
            work = any(id(slot) in self._shared for slot in part.slots())
            lines += self.one(part, self.statements(part.body), record if work else "")
            given = [POINTERS[name] for name in part.records() if name != "clock"]
            given += ["elapsed"] if "clock" in part.records() else []
            given += [slot.name for slot in (*part.kept, *part.arguments, *part.results)]
            given += ["&work"] if work else []
            calls += wrapped(f"    {self.name(part)}({', '.join(given)});", "        ")
        return [*lines, *self.one(replace(routine, locals=[]), calls, loops=False)]

    def one(self, routine: Routine, statements: list[str], work: str = "", loops: bool = True) -> list[str]:
        """A function of these statements, which is given a record of the type `work` if any."""
        lines = comment(routine.about) if routine.about else []
        head = self.signature(routine)
        if work:
            head = f"{head[:-1]}{'' if head.endswith('(void)') else ', '}{work} *work)".replace("(void", "(")
        lines += [*wrapped(head, "    "), "{"]
        variables = _loops(routine.body)
        if variables and loops:
            lines.append(f"    int {', '.join(variables)};")
        if routine.fresh:
            lines.append(f"    {self.law}_state fresh;")
        inner = {id(slot) for each in flat(routine.body) for slot in self._of_loops.get(id(each), [])}
        lines += self.declared([slot for slot in routine.locals if id(slot) not in inner], 1)
        return [*lines, *statements, "}", ""]

    def declared(self, slots: list[Slot], depth: int) -> list[str]:
        """Declarations of variables."""
        lines, pad = list[str](), "    " * depth
        for kind, condition in ((self.real, False), ("bool", True)):
            names = [_sized(slot) for slot in slots if slot.condition is condition]
            if names:
                lines += wrapped(f"{pad}{kind} {', '.join(names)};", f"{pad}    ")
        return lines

    def constants(self) -> list[str]:
        """The design and the tables."""
        lines = []
        for slot in self.program.design:
            about = f"{slot.unit}: {slot.about}" if slot.unit else slot.about
            lines += comment(about) if about else []
            if slot.whole:
                kind = "signed char" if slot.values.max() < 128 else "short"
                values = [str(int(each)) for each in slot.values]
            else:
                kind, values = self.real, [self.number(float(each)) for each in slot.values]
            listed = f"{{{', '.join(values)}}}" if slot.shape else values[0]
            size = f"[{slot.size}]" if slot.shape else ""
            lines += wrapped(f"static const {kind} {slot.name}{size} = {listed};", "    ")
        return lines

    def helpers(self) -> list[str]:
        """Functions that the law uses."""
        used = {kind for routine in self.program.routines for kind in kinds_of(routine.body)}
        return [line for name in HELPERS if name in used for line in helper(name, self.real, self.suffix)]


def _sized(slot: Slot) -> str:
    return f"{slot.name}[{slot.size}]" if slot.array else slot.name


def _loops(body: Iterable[Statement]) -> list[str]:
    return sorted({each.variable for each in flat(list(body)) if isinstance(each, For)})
