"""A law's program as Structured Text of IEC 61131-3."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from warmlink.controllers.export.lines import wrapped
from warmlink.controllers.export.program.program import LawProgram
from warmlink.controllers.export.program.statements import (
    For,
    Invoke,
    KnownNumber,
    Read,
    Routine,
    Set,
    Slot,
    Statement,
    Value,
    flat,
)

INFIX = {
    "add": ("+", 4),
    "sub": ("-", 4),
    "mul": ("*", 5),
    "div": ("/", 5),
    "lt": ("<", 3),
    "le": ("<=", 3),
    "gt": (">", 3),
    "ge": (">=", 3),
    "and": ("AND", 2),
    "or": ("OR", 1),
}
"""Operators and how tightly they bind; comparisons and logic always stand in brackets."""

STANDARD = {
    "abs": "ABS",
    "exp": "EXP",
    "log": "LN",
    "sqrt": "SQRT",
    "sin": "SIN",
    "cos": "COS",
    "pow": "EXPT",
}
"""Functions of the standard."""

RECORDS = {"state": "x", "next": "next"}
"""Records that are structures, and what they are called."""


def number(value: float) -> str:
    """A number, with a point and a large E."""
    mantissa, _, exponent = repr(float(value)).partition("e")
    mantissa = mantissa if "." in mantissa else f"{mantissa}.0"
    return f"{mantissa}E{int(exponent)}" if exponent else mantissa


@dataclass(frozen=True)
class Declaration:
    """A declaration: name, type, start values, and a comment."""

    name: str
    type: str
    start: tuple[str, ...] = ()
    told: str = ""


@dataclass(frozen=True)
class BlockText:
    """A program organisation unit: a function or a function block.

    Attributes
    ----------
    head : `FUNCTION` or `FUNCTION_BLOCK`
    sections : its variables by the word that begins them, as `VAR_INPUT`
    body : lines of statements
    returns : type of a function
    """

    head: str
    name: str
    about: str
    sections: dict[str, list[Declaration]]
    body: list[str]
    returns: str = ""


@dataclass(frozen=True)
class InnerBlock:
    """A function block inside of a law's: what it is given beside its arguments.

    Attributes
    ----------
    routine : what it does
    given : constants, inputs and what is recalled that it, or a block that it calls, reads
    records : structures of states that it reads or changes
    """

    routine: Routine
    given: list[Slot]
    records: list[str]


class StructuredText:
    """Prints one law."""

    def __init__(self, law: str, program: LawProgram, single: bool) -> None:
        self.law, self.program = law, program
        self.real = "REAL" if single else "LREAL"
        self.blocks: dict[int, InnerBlock] = {}
        roots = {id(program.update), id(program.outputs_of)}
        for routine in program.routines:
            if id(routine) not in roots:
                self.blocks[id(routine)] = self._block(routine)

    def _block(self, routine: Routine) -> InnerBlock:
        given = {slot.name: slot for slot in routine.slots() if slot.record in _PASSED}
        for each in routine.calls():
            given |= {slot.name: slot for slot in self.blocks[id(each)].given}
        records = [name for name in routine.records() if name in RECORDS]
        return InnerBlock(routine, list(given.values()), records)

    def kind(self, slot: Slot) -> str:
        """The type of a variable."""
        base = "BOOL" if slot.condition else "INT" if slot.whole else self.real
        if not slot.array:
            return base
        if slot.condition:
            return f"ARRAY [0..{slot.size - 1}] OF {base}"
        return f"{self.law}_{'places' if slot.whole else 'vector'}_{slot.size}"

    def arrays(self) -> list[tuple[str, int, str]]:
        """Types of arrays: name, number of elements, and their type."""
        slots = [*self.program.states, *self.program.inputs, *self.program.outputs, *self.program.recall]
        slots += self.program.design
        for routine in self.program.routines:
            slots += [*routine.locals, *routine.arguments, *routine.results, *routine.kept]
        found = sorted({(s.whole, s.size) for s in slots if s.array and not s.condition})
        names = [(self.kind(Slot("", (size,), whole=whole)), size, whole) for whole, size in found]
        return [(name, size, "INT" if whole else self.real) for name, size, whole in names]

    def variable(self, slot: Slot, told: bool = True) -> Declaration:
        """A variable, with what is said of it or without."""
        about = ": ".join(each for each in (slot.unit, slot.about) if each) if told else ""
        return Declaration(slot.name, self.kind(slot), (), about)

    def constant(self, slot: Slot) -> Declaration:
        """A constant."""
        values = [str(int(v)) if slot.whole else self.real_number(float(v)) for v in slot.values]
        return replace(self.variable(slot), start=tuple(values))

    def real_number(self, value: float) -> str:
        """A number of the arithmetic's range."""
        if np.isinf(value):
            value = float(np.copysign(3e38, value))
        return number(value)

    def read(self, read: Read) -> str:
        """A variable, or an element of it."""
        slot = read.slot
        record = "fresh" if slot.record == "fresh" else RECORDS.get(slot.record)
        text = f"{record}.{slot.name}" if record else slot.name
        return text if read.place is None else f"{text}[{read.place.text()}]"

    def value(self, value: Value, outer: int = 0) -> str:
        """A value; in brackets where what is around it binds more tightly."""
        if isinstance(value, KnownNumber):
            if np.isnan(value.value):
                return f"{self.law}_no_number(0.0)"
            text = self.real_number(value.value)
            return f"({text})" if text.startswith("-") and outer else text
        if isinstance(value, Read):
            return self.read(value)
        kind, of = value.kind, value.of
        if kind == "neg":
            return f"(-{self.value(of[0], 6)})"
        if kind == "not":
            return f"(NOT {self.value(of[0], 6)})"
        if kind == "eq":
            a, b = (self.value(each, 4) for each in of)
            return f"(({a} <= {b}) AND ({a} >= {b}))"
        if kind == "select":
            condition, then, otherwise = (self.value(each) for each in of)
            return f"SEL({condition}, {otherwise}, {then})"
        if kind in INFIX:
            sign, level = INFIX[kind]
            left, right = self.value(of[0], level), self.value(of[1], level + 1)
            text = f"{left} {sign} {right}"
            return f"({text})" if level < outer or (level <= 3 and outer) else text
        name = STANDARD.get(kind, f"{self.law}_{kind}")
        return f"{name}({', '.join(self.value(each) for each in of)})"

    def statements(self, body: Iterable[Statement], depth: int = 0) -> Iterator[str]:
        """Lines of statements."""
        pad = "  " * depth
        for each in body:
            if isinstance(each, Set):
                yield from wrapped(f"{pad}{self.read(each.to)} := {self.value(each.value)};", f"{pad}    ")
            elif isinstance(each, For):
                yield f"{pad}FOR {each.variable} := 0 TO {each.count - 1} DO"
                yield from self.statements(each.body, depth + 1)
                yield f"{pad}END_FOR;"
            else:
                yield from self.invoked(each, depth)

    def invoked(self, each: Invoke, depth: int) -> Iterator[str]:
        """A call of a block, and the condition for it."""
        pad = "  " * depth
        if each.asked is not None:
            yield from wrapped(f"{pad}IF {self.value(each.asked)} THEN", f"{pad}    ")
            yield from self.called(each, depth + 1)
            yield f"{pad}END_IF;"
        else:
            yield from self.called(each, depth)

    def called(self, each: Invoke, depth: int) -> Iterator[str]:
        """A call of a block."""
        pad, block = "  " * depth, self.blocks[id(each.function)]
        given = [f"{slot.name} := {slot.name}" for slot in block.given]
        for name in block.records:
            given.append(f"{RECORDS[name]} := {'fresh' if each.fresh else RECORDS[name]}")
        given += [f"{slot.name} := {self.value(value)}" for slot, value in each.given]
        kept = {id(slot) for slot in each.function.kept}
        given += [f"{slot.name} := {self.read(to)}" for slot, to in each.results if id(slot) in kept]
        yield from wrapped(f"{pad}run_{each.function.name}({', '.join(given)});", f"{pad}    ")
        for slot, to in each.results:
            if id(slot) not in kept:
                yield f"{pad}{self.read(to)} := run_{each.function.name}.{slot.name};"

    def block(self, routine: Routine) -> BlockText:
        """An inner function block."""
        block = self.blocks[id(routine)]
        changed = [Declaration(RECORDS[name], f"{self.law}_state") for name in block.records]
        return BlockText(
            "FUNCTION_BLOCK",
            f"{self.law}_{routine.name}",
            routine.about.replace("`", ""),
            {
                "VAR_INPUT": self.plain([*block.given, *routine.arguments]),
                "VAR_OUTPUT": self.plain(routine.results),
                "VAR_IN_OUT": [*changed, *self.plain(routine.kept)],
                "VAR": self.inner([routine]),
            },
            list(self.statements(routine.body)),
        )

    def plain(self, slots: Iterable[Slot]) -> list[Declaration]:
        """Variables without comments."""
        return [self.variable(slot, told=False) for slot in slots]

    def inner(self, routines: list[Routine]) -> list[Declaration]:
        """What functions need for themselves."""
        found = self.plain(slot for routine in routines for slot in routine.locals)
        if any(routine.fresh for routine in routines):
            found.append(Declaration("fresh", f"{self.law}_state"))
        loops = sorted({s.variable for r in routines for s in flat(r.body) if isinstance(s, For)})
        found += [Declaration(name, "INT") for name in loops]
        called = {each.name: each for routine in routines for each in routine.calls()}
        return [*found, *(Declaration(f"run_{name}", f"{self.law}_{name}") for name in called)]


_PASSED = ("design", "input", "recall", "clock")
