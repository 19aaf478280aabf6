"""A law on a processor, as a slave of the master in its FMU's place."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from benchmarks.processor.board import Board
from warmlink.fmus.component import Component
from warmlink.orchestration.master.slaves.slave import Names, Slave
from warmlink.orchestration.system.model import Value


class OnProcessor:
    """Everything but its numbers is the FMU's: variables, dependencies, capabilities, life.

    Parameters
    ----------
    fmu : the law's FMU, which the board stands in for
    law : its component
    board : computes the outputs
    """

    def __init__(self, fmu: Slave, law: Component, board: Board) -> None:
        self._fmu, self._law, self._board = fmu, law, board
        self._inputs = law.start_values()[1].copy()
        self._begins, self._stale = True, True
        self._outputs = np.zeros(law.y.size)
        self.name, self.variables, self.dependencies = fmu.name, fmu.variables, fmu.dependencies
        self.accepts_nan, self.remarks = fmu.accepts_nan, fmu.remarks
        # A processor cannot be set back.
        self.capabilities = replace(fmu.capabilities, get_set_state=False, serialize_state=False)
        self.setup, self.terminate = fmu.setup, fmu.terminate
        self.enter_initialization = fmu.enter_initialization

    def exit_initialization(self) -> None:
        """Begin with the inputs that stand."""
        self._fmu.exit_initialization()
        self._compute()
        self._begins = False

    def set(self, names: Names, values: Sequence[Value]) -> None:
        """Set variables; inputs are kept for the board."""
        self._fmu.set(names, values)
        for name, value in zip(names, values, strict=True):
            if name in self._law.u.index:
                self._inputs[self._law.u.index[name]] = float(value)
                self._stale = True

    def get(self, names: Names) -> list[Value]:
        """Give values: outputs are the board's, all others the FMU's."""
        values = self._fmu.get(names)
        if self._begins and self._stale:
            self._compute()
        index = self._law.y.index
        return [
            type(value)(self._outputs[index[name]]) if name in index else value
            for name, value in zip(names, values, strict=True)
        ]

    def step(self, time: float, step_size: float) -> None:
        """Take a sample on the board."""
        self._compute()

    def _compute(self) -> None:
        self._outputs = self._board.outputs(self._inputs, self._begins)
        self._stale = False
