"""Expressions become statements: a variable for what is long or used often (`Uses.held`), an array a loop."""

from __future__ import annotations

import numpy as np

from warmlink.controllers.export.program.contraction import contracted
from warmlink.controllers.export.program.expressions import FUNCTIONS, Computed
from warmlink.controllers.export.program.in_place import may_follow, may_overwrite, stays
from warmlink.controllers.export.program.places import fitted, place_of
from warmlink.controllers.export.program.ranges import never_negative, never_zero
from warmlink.controllers.export.program.statements import (
    SIDE,
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
from warmlink.controllers.export.program.tidy import tidied
from warmlink.controllers.export.program.tracing import Call, TracedFunction
from warmlink.controllers.export.program.uses import Uses, is_flag

LOOPS = ("i", "j", "k")
"""Variables of loops, from the outermost inwards."""


class Lowering(Uses):
    """One function of a law on its way from expressions to statements."""

    def lowered(self) -> Routine:
        """The function as statements; to be called once."""
        done: set[int] = set()
        late = {id(one) for one, target in self._targets if self._late(one, target)}
        for one in self._order:
            if one.kind == "result":
                if id(one.data[0]) not in done:
                    done.add(id(one.data[0]))
                    self._call(one.data[0])
            elif self.held(one) and id(one) not in late:
                self._compute(one, self._slot(one))
        self._finish(late)
        arguments = self.traced.arguments
        kept = [self.leaves[each.data] for each in arguments[: self.traced.kept]]
        read = {id(e) for e in self._order}
        used = [k < self.traced.kept or id(e) in read for k, e in enumerate(arguments)]
        given = [self.leaves[e.data] for k, e in enumerate(arguments) if used[k] and k >= self.traced.kept]
        results = [] if kept else [slot for _, slot in self._targets if slot.record == "result"]
        name, about = self.traced.name, self.traced.about
        body = contracted(tidied(self.body), self.locals)
        over = {} if kept else self._over(body)
        body = [For(SIDE, 2, body)] if self.traced.paired else body
        return Routine(name, about, body, given, results, kept, self.locals, used, over)

    def _over(self, body: list[Statement]) -> dict[int, int]:
        """Which arguments results may overwrite, both by place."""
        found: dict[int, int] = {}
        for k, (_, result) in enumerate(self._targets):
            for j, argument in enumerate(self.traced.arguments):
                slot = self.leaves[argument.data]
                alike = (slot.shape, slot.paired) == (result.shape, result.paired) and slot.array
                free = result.record == "result" and j not in found.values() and k not in found
                if alike and free and slot is not result and may_overwrite(body, result, slot):
                    found[k] = j
        return found

    def _late(self, one: Computed, target: Slot) -> bool:
        """Whether a result that is changed in place is computed last, straight into its variable."""
        alone = len(self._users[id(one)]) == 1
        simple = one.kind in FUNCTIONS or one.kind == "weave"
        return target.record == "kept" and simple and alone and id(one) not in self.slots

    def _finish(self, late: set[int]) -> None:
        """Write the results that lie elsewhere; what is changed in place after all who read it."""
        pending = [(one, target) for one, target in self._targets if self._place(one) is not target]
        while pending:
            texts = {id(target): self._read_slots(one) for one, target in pending}
            free = [
                (one, target)
                for one, target in pending
                if not any(id(target) in texts[id(other)] for _, other in pending if other is not target)
                and (texts[id(target)].get(id(target), True) or self._in_turn(one, target))
            ]
            one, target = (free or pending)[0]
            pending = [each for each in pending if each[1] is not target]
            if free:
                self._compute(one, target)
            else:
                held = Slot(self.names.fresh(f"new_{target.name}"), target.shape, "local")
                self.locals.append(held)
                self._compute(one, held)
                self.slots[id(one)] = held
                late.discard(id(one))
                if self._place(one) is not target:
                    pending.append((one, target))

    def _place(self, one: Computed) -> Slot | None:
        return self.leaves.get(one.data) if one.kind == "leaf" else self.slots.get(id(one))

    def _read_slots(self, one: Computed) -> dict[int, bool]:
        """Variables that an expression reads, and whether each only at the place that it is computed for."""
        found: dict[int, bool] = {}

        def seen(each: Computed, straight: bool) -> None:
            place = self._place(each)
            if place is not None and (each is not one or id(one) in self.slots):
                found[id(place)] = found.get(id(place), True) and straight
                return
            for inner in each.of:
                seen(inner, straight and each.kind in FUNCTIONS)

        seen(one, True)
        return found

    def _call(self, call: Call) -> None:
        """Add the call of a routine, with variables for what it gives back, whether read or not."""
        routine = self.routines[id(call.function)]
        results = {e.data[1]: e for e in self._order if e.kind == "result" and e.data[0] is call}
        taken: list[tuple[Slot, Read]] = []
        for k, slot in enumerate(routine.kept):
            of = results.get(k)
            to = self._slot(of) if of is not None else self._spare(slot)
            if self._place(call.given[k]) is not to:
                self._compute(call.given[k], to)
            taken.append((slot, Read(to)))
        kept = len(routine.kept)
        traced = [k for k in range(kept, len(call.given)) if routine.used[k]]
        given = [
            (slot, self._passed(call.given[k])) for slot, k in zip(routine.arguments, traced, strict=True)
        ]
        if not kept and not routine.results:  # a record's values, all at once
            for of in results.values():
                self.slots[id(of)] = Slot(of.fallback, of.shape, "fresh")
        elif not kept:
            for k, slot in zip(_own(call.function), routine.results, strict=True):
                of = results.get(k)
                taken.append((slot, Read(self._slot(of) if of is not None else self._spare(slot))))
        asked = None if call.asked is None else self.element(call.asked, ())
        self.body.append(Invoke(routine, given, taken, asked, not routine.kept and not routine.results))

    def _spare(self, like: Slot) -> Slot:
        made = Slot(self.names.fresh("unused"), (like.size,) if like.array else (), "local")
        self.locals.append(made)
        return made

    def _passed(self, one: Computed) -> Value:
        if not one.shape:
            return self.element(one, ())
        place = self._place(one)
        place = None if place is not None and place.paired else place
        if place is None and one.kind == "constant":
            place = self.tables.of(one.data, one.name or one.fallback or "row")
        if place is None:  # elements of something else
            place = Slot(self.names.fresh(one.name or one.fallback or "part"), one.shape, "local")
            self.locals.append(place)
            self._compute(one, place)
            self.slots[id(one)] = place
        return Read(place)

    def _compute(self, one: Computed, to: Slot) -> None:
        """Statements that give a variable its value."""
        if one.kind in ("stack", "weave") and self._place(one) in (None, to):
            if one.kind == "stack":
                self._pieces(one, to)
            else:
                self.body.extend(self._strands(one, to))
            return
        dims = LOOPS[: one.ndim]
        at = place_of(one.shape, dims) if to.array else None
        target = Read(to, at)
        if one.kind == "sum" and self._place(one) in (None, to):
            (inner,) = one.of
            variable = LOOPS[one.ndim]
            more = Operation("add", (target, self.element(inner, (*dims, variable))))
            body: list[Statement] = [
                Set(target, KnownNumber(0.0)),
                For(variable, inner.shape[-1], [Set(target, more)]),
            ]
        else:
            own = self.slots.pop(id(one), None) if self._place(one) is to else None
            body = [Set(target, self.element(one, dims))]
            if own is not None:
                self.slots[id(one)] = own
        for variable, count in reversed(list(zip(dims, one.shape, strict=True))):
            body = [For(variable, count, body)]
        self.body.extend(body)

    def _pieces(self, one: Computed, to: Slot) -> None:
        start, parts = 0, list(one.of)
        while parts:
            part = parts.pop(0)
            count = 1
            while not part.shape and parts and parts[0] is part:
                parts.pop(0)
                count += 1
            size = part.size * count
            if size == 1:
                value = self.element(part, (0,) * part.ndim)
                self.body.append(Set(Read(to, Index(start)), value))
            else:
                inner = self.element(part, ("i",) if part.shape else ())
                at = Read(to, Index(start, (("i", 1),)))
                self.body.append(For("i", size, [Set(at, inner)]))
            start += size

    def _in_turn(self, one: Computed, target: Slot) -> bool:
        """Whether parts can be written into the variable that they are read from, one after the other."""
        if one.kind != "weave" or id(one) in self.slots:
            return False
        lost: set[int] = set()
        return all(may_follow(statement, target, lost) for statement in self._strands(one, target))

    def _strands(self, one: Computed, to: Slot) -> list[Statement]:
        """Statements that write parts to where they belong among the others."""
        start, places, made = 0, np.argsort(one.data), list[Statement]()
        for part in one.of:
            own = places[start : start + part.size]
            start += part.size
            if part.size == 1:
                value = self.element(part, (0,) * part.ndim)
                made.append(Set(Read(to, Index(int(own[0]))), value))
            else:
                at = Read(to, fitted(own, ("i",), self.tables))
                made.append(For("i", part.size, [Set(at, self.element(part, ("i",)))]))
        return [each for each in made if not stays(each)]

    def element(self, one: Computed, dims: tuple[str | int, ...]) -> Value:
        """An element of an expression; of a number, itself.

        Divisions by what may be 0 and roots of what may be negative are guarded: they give 0.
        """
        dims = dims if one.shape else ()
        place = self._place(one)
        if one.kind == "leaf" and place is None:
            place = self._settled(one)
        if place is not None:
            return Read(place, place_of(one.shape, dims) if place.array else None)
        if one.kind == "constant":
            if one.data.size == 1 or np.all(one.data == one.data.flat[0]):
                return KnownNumber(float(one.data.flat[0]))
            table = self.tables.of(one.data, one.name or one.fallback or "numbers")
            return Read(table, place_of(one.shape, dims))
        if one.kind == "take":
            return self._taken(one, dims)
        if one.kind == "select" and is_flag(one):
            return Operation("select", (self.element(one.of[0], dims), KnownNumber(1.0), KnownNumber(0.0)))
        kind = one.kind
        if kind == "div" and not never_zero(one.of[1]):
            kind = "ratio"
        if kind == "sqrt" and not never_negative(one.of[0]):
            kind = "root"
        return Operation(kind, tuple(self.element(each, dims) for each in one.of))

    def _settled(self, one: Computed) -> Slot:
        """The variable of a constant that the design settles."""
        assert one.value is not None
        origin = [self.leaves["design", name] for name in sorted(one.origin)]
        name = self.tables.names.fresh(one.name or one.fallback or f"of_{origin[0].name}")
        values = np.atleast_1d(one.value).ravel()
        about = f"follows from {', '.join(map(_with_value, origin))}"
        slot = Slot(name, one.shape, "design", values=values, about=about)
        self.leaves[one.data] = slot
        return slot

    def _taken(self, one: Computed, dims: tuple[str | int, ...]) -> Value:
        (of,) = one.of
        if not of.shape:
            return self.element(of, ())
        index = fitted(one.data, dims, self.tables)
        if of.kind == "constant":
            return Read(self.tables.of(of.data, of.name or of.fallback or "numbers"), index)
        place = self._place(of)
        if place is None and of.kind == "leaf":
            place = self._settled(of)
        if place is None and not index.terms and not index.tables:
            inner = np.unravel_index(index.constant, of.shape)
            return self.element(of, tuple(int(each) for each in inner))
        assert place is not None, of.kind
        return Read(place, index)


def _with_value(parameter: Slot) -> str:
    """A parameter's name with its unit, and its value if it is a number."""
    unit = "" if parameter.unit == "1" else parameter.unit
    if parameter.shape:
        return f"{parameter.name} [{unit}]" if unit else parameter.name
    return f"{parameter.name} = {float(parameter.values[0]):g} {unit}".strip()


def _own(function: TracedFunction) -> list[int]:
    """Which results a function computes, and does not merely pass on."""
    arguments = {id(each) for each in function.arguments}
    return [k for k, each in enumerate(function.results) if id(each) not in arguments]
