"""The growth that a controller should take out: a weighted sum of outputs that were measured."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warmlink.fmus.errors import InputError
from warmlink.fmus.names import listed
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.fit.problem import Problem


@dataclass(frozen=True)
class Growth:
    """The growth that is to be compensated: outputs of a problem, by number, each with its weight."""

    variables: tuple[str, ...]
    channels: tuple[int, ...]
    weights: Array

    def __call__(self, table: Array) -> Array:
        """The growth, from a table whose second axis is that of a problem's outputs."""
        parts = [weight * table[:, i] for i, weight in zip(self.channels, self.weights, strict=True)]
        return np.asarray(sum(parts[1:], parts[0]))


def growth_of(problem: Problem) -> Growth:
    """The growth of a problem's machine.

    Raises InputError if nothing says what it is, or an output of it was not measured.
    """
    machine, measured = problem.experiment.rig.machine, list(problem.variables)
    if not any(problem.experiment.rig.unit(name) == "m" for name in measured):
        raise InputError(f"{machine.name}: no growth was measured, so that nothing is known of it")
    if not machine.growth:
        raise InputError(
            f"{machine.name}: nothing says which growth a controller should take out; give it as a weighted "
            'sum: score under [roles], in a file that the experiment names as system = "machine.toml"'
        )
    if missing := [name for name in machine.growth if name not in measured]:
        raise InputError(
            f"{machine.name}: nobody measured {listed(missing)}, or knows how well it is predicted; "
            "measure it, or score what was measured"
        )
    weights = np.array([*machine.growth.values()])
    return Growth(tuple(machine.growth), tuple(map(measured.index, machine.growth)), weights)
