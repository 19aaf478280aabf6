"""Which expressions get variables, and which of them share one."""

from __future__ import annotations

from collections import defaultdict
from math import inf

from warmlink.controllers.export.program.algebra import told_by
from warmlink.controllers.export.program.expressions import FUNCTIONS, Computed
from warmlink.controllers.export.program.places import FreeNames, Tables
from warmlink.controllers.export.program.statements import Routine, Slot, Statement
from warmlink.controllers.export.program.tracing import Call, TracedFunction

LONG = 9
"""Operations in an expression beyond which it is divided."""


class Uses:
    """Who uses which expression of a function, and which of them gets a variable of its own.

    Parameters
    ----------
    leaves : variables of the records by place, to which those that the design settles are added
    targets : variables that take the results
    routines : by their identity, the functions that it may call
    """

    def __init__(
        self,
        traced: TracedFunction,
        targets: list[Slot],
        leaves: dict[tuple[str, str], Slot],
        tables: Tables,
        names: FreeNames,
        routines: dict[int, Routine],
    ) -> None:
        self.traced, self.leaves, self.tables, self.names = traced, leaves, tables, names
        self.routines = routines
        self.slots: dict[int, Slot] = {}
        self.locals: list[Slot] = []
        self.body: list[Statement] = []
        self._targets = list(zip(traced.results, targets, strict=True))
        self._order = self._reachable()
        self._users = self._used_by()
        self._emitted: dict[int, float] = {}
        late = [one for one in traced.results if one.kind != "result"] if traced.kept else []
        self._in_place = set(map(id, late))
        self._share()

    def _given(self, one: Computed) -> list[Computed]:
        """What an expression reads: of a call the arguments that the function uses."""
        if one.kind != "result":
            return list(one.of)
        call: Call = one.data[0]
        used = self.routines[id(call.function)].used
        read = [each for each, needed in zip(call.given, used, strict=True) if needed]
        return [*read, *([call.asked] if call.asked is not None else [])]

    def _reachable(self) -> list[Computed]:
        found: dict[int, Computed] = {}
        pending = list(self.traced.results)
        while pending:
            one = pending.pop()
            if id(one) not in found:
                found[id(one)] = one
                pending.extend(self._given(one))
        return sorted(found.values(), key=lambda each: each.serial)

    def _used_by(self) -> dict[int, list[Computed | None]]:
        users: dict[int, list[Computed | None]] = defaultdict(list)
        for one in self._order:
            for each in self._given(one):
                users[id(each)].append(one)
        for one in self.traced.results:
            users[id(one)].append(None)
        return users

    def held(self, one: Computed) -> bool:
        """Whether an expression gets a variable of its own."""
        if one.kind in ("leaf", "constant", "take"):
            return False
        if id(one) in self.slots or one.kind in ("sum", "stack", "weave", "result"):
            return True
        users = self._users[id(one)]
        kinds = {each.kind for each in users if each is not None}
        if "take" in kinds or ("result" in kinds and one.shape):
            return True
        deeper = any(each is not None and each.shape and not one.shape for each in users)
        size = self._operations(one)
        if (deeper and size) or size > LONG:
            return True
        if len(users) > 1 and size and (size > 1 or one.kind != "neg"):
            return True
        return bool(one.name) and size > 3 and not one.shape

    def _operations(self, one: Computed) -> int:
        if id(one) in self._sizes:
            return self._sizes[id(one)]
        own = 1 if one.kind in FUNCTIONS and not is_flag(one) else 0
        inner = sum(0 if self.held(each) else self._operations(each) for each in one.of)
        self._sizes[id(one)] = own + inner
        return own + inner

    _sizes: dict[int, int]

    def _last(self, one: Computed) -> float:
        """When an expression is read for the last time, as a serial."""
        return max((self._when(each) for each in self._users[id(one)]), default=-1.0)

    def _when(self, user: Computed | None) -> float:
        if user is None or id(user) in self._in_place:
            return inf
        if self.held(user):
            return user.data[0].given_at if user.kind == "result" else float(user.serial)
        if id(user) not in self._emitted:
            self._emitted[id(user)] = self._last(user)
        return self._emitted[id(user)]

    def _share(self) -> None:
        """Results get the variables that wait for them; what a call changes keeps its variable."""
        self._sizes = {}
        mutable = self.traced.arguments[: self.traced.kept]
        for argument in self.traced.arguments:
            self.slots[id(argument)] = self.leaves[argument.data]
        for one, target in self._targets:
            if one.kind not in ("leaf", "constant", "take") and target.record != "kept":
                self.slots.setdefault(id(one), target)
        for one in reversed(self._order):
            if one.kind != "result":
                continue
            call: Call = one.data[0]
            call.given_at = float(
                min(e.serial for e in self._order if e.kind == "result" and e.data[0] is call)
            )
            over = self._overwritten(call.function, one.data[1])
            if over is None:
                continue
            before = call.given[over]
            last = self._last(before) <= call.given_at and sum(each is before for each in call.given) == 1
            if not last and not call.function.kept:
                continue
            if last and id(one) not in self.slots and any(before is each for each in mutable):
                self.slots[id(one)] = self.slots[id(before)]
            slot = self._slot(one)
            if last and id(before) not in self.slots and before.kind not in ("leaf", "constant", "take"):
                self.slots[id(before)] = slot
        self._sizes = {}

    def _overwritten(self, function: TracedFunction, result: int) -> int | None:
        """Which argument a function changes into a result, or may overwrite with it; None if none."""
        if function.kept:
            return result if result < function.kept else None
        return self.routines[id(function)].over.get(result)

    def _slot(self, one: Computed) -> Slot:
        """The variable of an expression that has one."""
        if id(one) not in self.slots:
            name = self.names.fresh(one.name or one.fallback or "value")
            self.slots[id(one)] = Slot(name, one.shape, "local", one.condition)
            self.locals.append(self.slots[id(one)])
        return self.slots[id(one)]


def is_flag(one: Computed) -> bool:
    """Whether an expression is 1 where a condition holds, else 0."""
    return one.kind == "select" and told_by(one) is not None
