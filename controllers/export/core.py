"""A law as it is exported: its design, its program, and who made it of what."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

from warmlink.controllers.export.program.program import LawProgram, program
from warmlink.controllers.export.program.statements import For, Invoke, Operation, Set, Statement, Value
from warmlink.controllers.export.vectors import Vectors, vectors
from warmlink.controllers.start_values import with_scalars
from warmlink.fmus.component import Component
from warmlink.fmus.component.arithmetic import Number
from warmlink.fmus.packaging.release import version
from warmlink.fmus.safe_text import printable

Precision = Literal["double", "single"]


@dataclass(frozen=True)
class Core:
    """A law that is exported.

    Attributes
    ----------
    component : the law, its parameters' start values being the design
    name : what files and functions are named after
    precision : of its arithmetic
    source_of_design : what the design was read from, as it is told in each file
    """

    component: Component
    name: str
    precision: Precision
    source_of_design: str = "the one that ships, designed for WarmupCell as it ships"

    @property
    def design(self) -> Number:
        """Parameters and what they settle, shape (d.size,)."""
        return self.component.settled(self.component.start_values()[0])

    @cached_property
    def program(self) -> LawProgram:
        """What it computes."""
        return program(self.component, self.design, self.name, self.precision == "single")

    @cached_property
    def vectors(self) -> Vectors:
        """What the law says to inputs that try it; InputError if it gives no numbers."""
        return vectors(self.component, self.period)

    @property
    def description(self) -> str:
        """What the law is, as it may stand in a comment of any language."""
        return in_comment(self.component.description)

    @property
    def period(self) -> float:
        """Sample time in s."""
        return float(self.design[self.component.d.index["sample_time"]])

    @property
    def goes_on(self) -> bool:
        """Whether the law can go on from what it retained of a run before."""
        return bool(self.program.recall)

    @property
    def mark(self) -> str:
        """SHA-256 of the values of its parameters, in short."""
        values = self.component.start_values()[0].tolist()
        told = "\n".join(f"{n}={v!r}" for n, v in zip(self.component.p.names, values, strict=True))
        return hashlib.sha256(f"{self.component.name}\n{told}".encode()).hexdigest()[:16]

    def origin(self) -> list[str]:
        """Sentences that say which warmlink made it, of which design."""
        return [
            f"Written by warmlink {version()} for {self.component.name} in {self.precision} precision.",
            f"Design: {in_comment(self.source_of_design)}.",
            f"The values of its parameters have the SHA-256 {self.mark}.",
        ]

    def operations(self) -> int:
        """Arithmetic operations of a sample and its outputs, at most."""
        return sum(_operations(each.body) for each in (self.program.update, self.program.outputs_of))


def in_comment(text: str) -> str:
    """A text that ends no comment, in C or in Structured Text."""
    return printable(" ".join(text.split())).replace("*/", "* /").replace("*)", "* )").replace("(*", "( *")


def designed(component: Component, values: dict[str, float]) -> Component:
    """The law with the values of a parameter set by scalar name; raises KeyError where it has none such."""
    return replace(component, parameters=with_scalars(component.parameters, values))


def _operations(body: list[Statement]) -> int:
    count = 0
    for each in body:
        if isinstance(each, Set):
            count += _inside(each.value)
        elif isinstance(each, For):
            count += each.count * _operations(each.body)
        elif isinstance(each, Invoke):
            count += _operations(each.function.body) + sum(_inside(value) for _, value in each.given)
    return count


def _inside(value: Value) -> int:
    return 1 + sum(map(_inside, value.of)) if isinstance(value, Operation) else 0
