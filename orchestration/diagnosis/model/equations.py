"""A rig's equations in one piece: rates, outputs, derivatives, from the joined component.

So the diagnosis integrates the same equations as the FMUs, without the communication steps between them.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Collection, Sequence
from dataclasses import replace
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warmlink.fmus.component.join import part_of
from warmlink.fmus.errors import InputError
from warmlink.fmus.packaging.cache import kept, kept_before
from warmlink.fmus.packaging.native.library import loaded, made_here, processor
from warmlink.fmus.thermal_link.equations import sensor_positions
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.machine.rig import OFFSET, PLACE, SCALE, Rig

_BESIDE = 1e-6
"""m from a node at which a sensor is placed: on the node itself the course has a kink."""

_LOOP = Path(__file__).parent / "sources" / "integrator.c"

_PAYS_FROM = 2_500
"""Evaluations on CasADi's machine from which compiling pays, which takes as long as some ten thousand."""

_BLOCK, _PAIR = 64, 2
"""Points at which outputs are computed in one call; CasADi would keep a function for each other number."""

Indices = NDArray[np.int64]


class Equations:
    """Compiled functions of a rig for a choice of freed variables and outputs.

    Parameters
    ----------
    rig : the system
    slots : freed parameters or inputs, by full name
    outputs : outputs wanted, by full name
    derivatives : whether those by the slots are wanted beside the values
    given : inputs with a signal of their own, which a slot of another input leaves alone

    Attributes
    ----------
    states : names of the states that the outputs depend on; the others are left out
    columns : number of slots by which derivatives are given: all or none
    linear : CasADi's function of states, slots, parameters, inputs and time in s: the rates, and what is not
        zero of their derivatives by state and by slot, row by row
    taken : evaluations on CasADi's machine so far
    """

    def __init__(
        self,
        rig: Rig,
        slots: Sequence[str],
        outputs: Sequence[str],
        derivatives: bool = True,
        given: Collection[str] = (),
    ) -> None:
        import casadi as ca

        self.rig, self.slots, self.outputs = rig, tuple(slots), tuple(outputs)
        self.columns = len(self.slots) if derivatives else 0
        self.taken, self._pays = 0, False
        joined = _Symbols(rig, self.slots, given)
        rates, observed = joined.rates, ca.vertcat(*(joined.values[name] for name in outputs))
        needed = _needed_states(ca, joined.x, rates, observed)
        self.states = tuple(rig.component.x.names[i] for i in needed)
        x = joined.x[needed]
        rates, begun = rates[needed], joined.begun[needed]
        z = joined.z[: self.columns]
        arguments = [x, joined.z, joined.p, joined.w, joined.time]
        # What is not zero of the transposes, by column as CasADi has it, is row by row of the matrices.
        found: list[Any] = [ca.densify(rates), ca.jacobian(rates, x).T, ca.jacobian(rates, z).T]
        self.linear = ca.Function("linear", arguments, found, {"cse": True})
        # What slots and parameters alone say of the outputs is computed once for all points.
        tables: list[Any] = [observed, ca.jacobian(observed, x), ca.jacobian(observed, z)]
        self._places = [(each.shape, *each.sparsity().get_triplet()) for each in tables]
        entries, held = ca.vertcat(*(e for each in tables for e in each.nonzeros())), arguments[1:3]
        there, *parts = ca.extract_parametric(entries, ca.vertcat(*held), {"extract_trivial": True})
        symbols, once = (ca.vertcat(ca.SX(0, 1), *each) for each in parts)
        self._once = ca.Function("once", held, [once], {"cse": True})
        observe = ca.Function("observe", [x, symbols, joined.w, joined.time], [there], {"cse": True})
        self._observe = {count: observe.map(count) for count in (_PAIR, _BLOCK)}
        found = [ca.densify(v) for v in (begun, ca.jacobian(begun, z))]
        self._begin = ca.Function("begin", arguments[1:4], found, {"cse": True})

    @cached_property
    def parameter_values(self) -> Array:
        """Start values of all parameters, shape (parameters,)."""
        return np.asarray(self.rig.component.start_values()[0], dtype=float)

    def begin(self, z: Array, p: Array, w: Array) -> tuple[Array, Array]:
        """States at the start, shape (n,), and their derivatives by the slots, shape (n, columns)."""
        x, by_slot = self._begin(z, p, w)
        return np.array(x).ravel(), np.array(by_slot).reshape(x.shape[0], self.columns)

    @cached_property
    def by_row(self) -> tuple[tuple[Indices, Indices], ...]:
        """Of the rates' derivatives by state and by slot: where each row begins, and its columns."""
        sparsities = [self.linear.sparsity_out(i) for i in (1, 2)]
        return tuple(
            (np.array(each.colind(), np.int64), np.array(each.row(), np.int64)) for each in sparsities
        )

    def library(self, ahead: int = 0) -> ctypes.CDLL | None:
        """`integrator.c` with these equations if it was compiled before or pays; None for CasADi.

        So many evaluations lie `ahead`.
        """
        self._pays = self._pays or self.taken + ahead >= _PAYS_FROM
        return self._before or (self._compiled if self._pays else None)

    def compile(self) -> None:
        """Take C from the first step on if it compiles here: for many steps that must all come out alike."""
        self._pays = True

    @cached_property
    def _sources(self) -> dict[str, str]:
        import casadi as ca

        generator = ca.CodeGenerator("equations.c", {"with_header": False})
        generator.add(self.linear)
        # Where CasADi marks its functions as exported, a library for Windows exports no others.
        unmarked = "#define CASADI_SYMBOL_EXPORT\n\n" + generator.dump()
        return {"equations.c": unmarked, "integrator.c": _LOOP.read_text("utf-8")}

    @cached_property
    def _before(self) -> ctypes.CDLL | None:
        return self._loaded(kept_before)

    @cached_property
    def _compiled(self) -> ctypes.CDLL | None:
        return self._loaded(lambda name, made_of: kept(name, made_of, self._built))

    def _loaded(self, contents: Callable[[str, object], bytes | None]) -> ctypes.CDLL | None:
        """A compiled library; None where nothing compiles here, or may be loaded from a file."""
        try:
            library = contents("steps", (*made_here(), processor()[1], self._sources))
            return None if library is None else loaded(library)
        except (InputError, OSError):
            return None

    def _built(self) -> bytes:
        from warmlink.fmus.packaging.native.compile import library_here

        # With -O1 it is compiled in half the time, and as fast.
        return library_here(self._sources, "steps", "-O1", level=processor()[1])

    def observe(self, x: Array, z: Array, p: Array, w: Array, time: Array) -> tuple[Array, Array, Array]:
        """Outputs at many points.

        Parameters
        ----------
        x : states, shape (n, points)
        z, p : slots and parameters
        w : inputs, shape (externals, points)
        time : s, shape (points,)

        Returns
        -------
        tuple of numpy.ndarray
            Outputs, shape (points, outputs); derivatives by state, shape (points, outputs, n), and by
            slot, shape (points, outputs, columns).
        """
        size = _PAIR if time.size <= _PAIR else _BLOCK
        rows = np.minimum(np.arange(-(-time.size // size) * size), time.size - 1)
        at, fed, when = (np.ascontiguousarray(course[rows]) for course in (x.T, w.T, time))
        once = np.tile(np.array(self._once(z, p)).ravel(), (size, 1))
        observe = self._observe[size]
        found = np.empty((rows.size, observe.size1_out(0)))  # CasADi's columns are rows here
        for block in (slice(first, first + size) for first in range(0, rows.size, size)):
            _buffer, evaluate = bound(observe, [at[block], once, fed[block], when[block]], [found[block]])
            evaluate()
        tables, begin = [], 0
        for shape, row, column in self._places:
            tables.append(np.zeros((time.size, *shape)))
            tables[-1][:, row, column] = found[: time.size, begin : begin + len(row)]
            begin += len(row)
        y, by_state, by_slot = tables
        return y[:, :, 0], by_state, by_slot


@lru_cache(maxsize=24)
def equations(
    rig: Rig,
    cells: int,
    slots: tuple[str, ...],
    outputs: tuple[str, ...],
    derivatives: bool,
    given: frozenset[str] = frozenset(),
) -> Equations:
    """Compiled functions of a rig, kept for the next problem of the same kind."""
    return Equations(replace(rig, cells=cells), slots, outputs, derivatives, given)


def bound(function: Any, given: Sequence[Array], found: Sequence[Array]) -> tuple[Any, Any]:
    """Buffer of a CasADi function that reads from and writes to arrays in place, and the call that does so.

    Whoever calls it keeps the buffer and the arrays.
    """
    buffer, evaluate = function.buffer()
    for i, array in enumerate(given):
        buffer.set_arg(i, array.reshape(-1).data)
    for i, array in enumerate(found):
        buffer.set_res(i, array.reshape(-1).data)
    return buffer, evaluate


class _Symbols:
    """A rig's rates, start values and outputs as expressions; slots stand in place of what they free."""

    def __init__(self, rig: Rig, slots: tuple[str, ...], given: Collection[str]) -> None:
        import casadi as ca

        component = rig.component
        self.p = ca.SX.sym("p", component.p.size)
        self.w = ca.SX.sym("w", component.u.size)
        self.z = ca.SX.sym("z", len(slots))
        self.x = ca.SX.sym("x", component.x.size)
        self.time = ca.SX.sym("time")
        p, u = ca.SX(self.p), ca.SX(self.w)
        for i, name in enumerate(slots):
            if name in component.p.index:
                p[component.p.index[name]] = self.z[i]
            elif name in component.u.index:
                u[component.u.index[name]] = self.z[i]
            elif name.startswith(SCALE) or name.startswith(OFFSET):
                logged = name.partition(":")[2]
                fed = rig.fed_with(logged, given)
                for k in (component.u.index[n] for n in fed if n in component.u.index):
                    u[k] = u[k] * self.z[i] if name.startswith(SCALE) else u[k] + self.z[i]
        for i, name in enumerate(slots):
            if name.startswith(PLACE):
                place = name.partition(":")[2]
                said = sensor_positions(part_of(component.p.read(p), place.rpartition(".")[0]))
                p[component.p.index[place]] = said[int(name[-2]) - 1] + self.z[i] + _BESIDE
        d = component.settled(p)
        self.rates = component.rates_of(self.x, u, d, self.time)
        self.begun = component.states_at_start(u, d)
        outputs = ca.vertsplit(component.outputs_of(self.x, u, d, self.time))
        self.values = dict(zip(component.y.names, outputs, strict=True))
        for name in component.y.names:
            link, element = rig.on_link(name) or ("", 0)
            if f"{PLACE}:{link}.sensor_position[{element}]" in slots:
                self.values[name] = self.values[f"{link}.sensor_temperature[{element}]"]


def _needed_states(ca: Any, x: Any, rates: Any, observed: Any) -> list[int]:
    """Indices of the states that the outputs depend on, at once or through other states."""
    by_state = np.array(ca.DM(ca.jacobian(rates, x).sparsity(), 1)) != 0
    needed = (np.array(ca.DM(ca.jacobian(observed, x).sparsity(), 1)) != 0).any(axis=0)
    while True:
        more = needed | by_state[needed].any(axis=0)
        if (more == needed).all():
            return [int(i) for i in np.flatnonzero(needed)]
        needed = more
