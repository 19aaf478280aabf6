"""Runs a law's program statement by statement, as C does: arrays are handed on by their place."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from warmlink.controllers.export.program.expressions import FUNCTIONS
from warmlink.controllers.export.program.program import LawProgram
from warmlink.controllers.export.program.statements import (
    For,
    Index,
    Invoke,
    KnownNumber,
    Operation,
    Read,
    Routine,
    Set,
    Slot,
    Statement,
    Value,
)

Array = NDArray[np.float64]

GUARDED: dict[str, Any] = {
    "ratio": lambda a, b: a / b if b != 0 else b * 0,
    "root": lambda a: 0.0 if a < 0 else np.sqrt(a),
}


class Interpreter:
    """One law at work; what was never written is NaN."""

    def __init__(self, made: LawProgram) -> None:
        self.made, self.loops = made, dict[str, int]()
        self.records: dict[tuple[str, str], Array] = {}

    def begin(self, u: dict[str, float]) -> dict[str, Array]:
        """The outputs after the first inputs, by name."""
        for slot in self.made.inputs:
            self.records["input", slot.name] = np.array([u[slot.name]])
        self._run(self.made.begin, {})
        return self._told()

    def step(self, u: dict[str, float], elapsed: float) -> dict[str, Array]:
        """The outputs a sample later."""
        for slot in self.made.inputs:
            self.records["input", slot.name] = np.array([u[slot.name]])
        self.records["clock", "elapsed"] = np.array([elapsed])
        self._run(self.made.update, {})
        return self._told()

    def _told(self) -> dict[str, Array]:
        for slot in self.made.states:
            self.records["state", slot.name] = self.records.pop(("next", slot.name))
        self._run(self.made.outputs_of, {})
        return {slot.name: self.records["output", slot.name] for slot in self.made.outputs}

    def _run(self, routine: Routine, frame: dict[int, Array]) -> None:
        for slot in routine.locals:
            frame[id(slot)] = np.full(slot.size, np.nan)
        self._all(routine.body, frame)

    def _all(self, body: list[Statement], frame: dict[int, Array]) -> None:
        for each in body:
            if isinstance(each, Set):
                self._place(each.to, frame)[:] = self._value(each.value, frame)
            elif isinstance(each, For):
                for turn in range(each.count):
                    self.loops[each.variable] = turn
                    self._all(each.body, frame)
            elif each.asked is None or self._value(each.asked, frame):
                self._invoke(each, frame)

    def _invoke(self, each: Invoke, frame: dict[int, Array]) -> None:
        inner = {id(slot): self._place(read, frame) for slot, read in each.results}
        for slot, value in each.given:
            if slot.array and isinstance(value, Read):
                inner[id(slot)] = self._place(value, frame)
            else:
                inner[id(slot)] = np.array([self._value(value, frame)])
        loops, self.loops = self.loops, {}
        before = dict(self.records) if each.fresh else {}
        self._run(each.function, inner)
        self.loops = loops
        if each.fresh:
            for (record, name), held in list(self.records.items()):
                if record == "next":
                    before["fresh", name] = held
            self.records = before

    def _held(self, slot: Slot, frame: dict[int, Array]) -> Array:
        if slot.record == "design":
            return np.asarray(slot.values, dtype=float)
        if id(slot) in frame:
            return frame[id(slot)]
        return self.records.setdefault((slot.record, slot.name), np.full(slot.size, np.nan))

    def _place(self, read: Read, frame: dict[int, Array]) -> Array:
        """The elements that are read or written, as a view."""
        held = self._held(read.slot, frame)
        if read.place is None:
            return held
        at = self._at(read.place)
        assert 0 <= at < held.size, (read.slot.name, at)
        return held[at : at + 1]

    def _at(self, index: Index) -> int:
        tables = sum(int(slot.values[self._at(inner)]) for slot, inner in index.tables)
        turns = sum(pace * self.loops[name] for name, pace in index.terms)
        return index.constant + turns + index.of_tables * tables

    def _value(self, value: Value, frame: dict[int, Array]) -> Any:
        if isinstance(value, KnownNumber):
            return value.value
        if isinstance(value, Read):
            (found,) = self._place(value, frame)
            return found
        assert isinstance(value, Operation)
        function = GUARDED.get(value.kind) or FUNCTIONS[value.kind]
        with np.errstate(all="ignore"):
            return function(*(self._value(each, frame) for each in value.of))
