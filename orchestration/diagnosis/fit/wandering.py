"""Process noise: a room, and heat into the shaft, that wander beside what was logged.

Each is a broken line over the run with the covariance of an Ornstein-Uhlenbeck process. The response of the
readings to it has a covariance of low rank beside the noise of the instruments. That is folded into the
whitening, so that fits, search, intervals and lack of fit stay as they are. Amplitudes and memory are those
of the largest likelihood, see `likeliest.py`; C. E. Rasmussen and C. K. I. Williams, Gaussian Processes for
Machine Learning, MIT Press 2006, chapter 5.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.fit.problem import Problem
from warmlink.orchestration.diagnosis.model.integrator import Courses

_SPACING, _MOST_NODES = 240.0, 60
"""s between nodes, at least, and their number at most."""


@dataclass(frozen=True)
class Wander:
    """How much is taken to wander: standard deviations in K and W, and the correlation time in s."""

    room: float = 0.0
    heat: float = 0.0
    memory: float = 600.0

    def __str__(self) -> str:
        room = f"a room that wanders by {self.room:g} K beside its log" if self.room else ""
        heat = f"heat into the shaft that wanders by {self.heat:g} W" if self.heat else ""
        return " and ".join(filter(None, (room, heat))) or "nothing that wanders"

    @property
    def still(self) -> bool:
        """Whether nothing wanders."""
        return not (self.room or self.heat)


STILL = Wander()


class Responses:
    """Responses of all readings to what may wander, by run, at the given values of the slots.

    `signals` are the names of what may wander in this system, `nodes` are in s, and `columns` have the shape
    (rows, outputs, signals * nodes).
    """

    def __init__(self, problem: Problem, values: Sequence[Array]) -> None:
        slots = {
            name: tuple(i for i, slot in enumerate(problem.slots) if slot in wandering)
            for name, wandering in problem.experiment.rig.wandering.items()
        }
        self.signals = tuple(slots)
        self.nodes: list[Array] = []
        self.columns: list[Array] = []
        for run, z in enumerate(values):
            span = float(problem.data[run].time[-1])
            count = int(np.clip(span / _SPACING, 2, _MOST_NODES)) + 1
            self.nodes.append(np.linspace(0.0, span, count))
            courses = Courses(tuple(slots[name] for name in self.signals), self.nodes[-1])
            self.columns.append(problem.responses(run, z, courses))

    def root(self, run: int, wander: Wander) -> Array:
        """Matrix whose square is the covariance of all values at the nodes, shape (values, values)."""
        from scipy.linalg import block_diag

        apart = np.abs(np.subtract.outer(self.nodes[run], self.nodes[run]))
        root = np.linalg.cholesky(np.exp(-apart / wander.memory) + 1e-9 * np.eye(len(apart)))
        return np.asarray(block_diag(*(getattr(wander, name) * root for name in self.signals)))


class Smoothing:
    """Takes from whitened columns of one run what wandering explains: a whitening of low rank.

    Parameters
    ----------
    columns : whitened responses of all channels after one another, shape (rows, values)
    """

    def __init__(self, columns: Array) -> None:
        self._left, size, _ = np.linalg.svd(columns, full_matrices=False)
        self._shrunk = 1 - 1 / np.sqrt(1 + size**2)

    def __call__(self, columns: Array) -> Array:
        """(I + F F')^(-1/2) times columns, shape (rows, ...)."""
        return columns - self._left @ (self._shrunk[:, None] * (self._left.T @ columns))


def integrated_out(gram: Array, across: Array, inner: Array, root: Array) -> tuple[Array, float]:
    """Gram matrix of columns with what wanders integrated out, and minus twice the log-likelihood's constant.

    Parameters
    ----------
    gram : of the columns, shape (n, n)
    across, inner : of responses and columns, shape (values, n), and of responses, shape (values, values)
    root : of the covariance of the values
    """
    matrix = np.eye(len(root)) + root.T @ inner @ root
    factor = np.linalg.cholesky(matrix)
    part = np.linalg.solve(factor, root.T @ across)
    return gram - part.T @ part, 2 * float(np.log(np.diag(factor)).sum())
