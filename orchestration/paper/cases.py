"""The paper's two cases as drives, and the finite-element models that run them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache

import numpy as np

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.paper.data import load_geometry, load_materials, load_paper
from warmlink.orchestration.paper.fea.drive import Drive, graded
from warmlink.orchestration.paper.fea.mesh import Assembly, paper_assembly
from warmlink.orchestration.paper.fea.simulate import Fea
from warmlink.orchestration.system.units import ZERO_CELSIUS


@dataclass(frozen=True)
class Case:
    """One of the paper's experiments: `shaft`, `ambient` [K], `convection` [W/(m2.K)], `duration` [s]."""

    name: str
    shaft: float
    ambient: float
    convection: float
    duration: float

    @classmethod
    def printed(cls, name: str) -> Case:
        """Read the case `stationary` or `moving` from the paper's numbers."""
        n = {key: entry.value for key, entry in load_paper()[name].items()}
        shaft, ambient = n["shaft"] + ZERO_CELSIUS, n["ambient"] + ZERO_CELSIUS
        return cls(name, shaft, ambient, n["convection"], n["duration"])

    @property
    def rise(self) -> float:
        """Shaft above ambient [K]."""
        return self.shaft - self.ambient

    @property
    def times(self) -> Array:
        """Times [s] whose steps grow after the shaft's temperature jumps."""
        return graded([0.0, self.duration])

    def drive(self, *, radiation: bool = False, lag: float = 0.0) -> Drive:
        """Hold the shaft's temperature; `lag` [s] delays it by a first order."""

        def heated(time: float) -> float:
            return self.ambient + self.rise * (-math.expm1(-time / lag) if lag > 0 else 1.0)

        return Drive(self.convection, self.ambient, temperature=heated, radiation=radiation)


@cache
def fea(assembly: Assembly) -> Fea:
    """Return the finite-element model of an assembly, which is made once."""
    return Fea(paper_assembly(load_geometry(), load_materials(), assembly))


def steady_time(time: Array, values: Array) -> float:
    """Three time constants [s] of what approaches its last value from its first, `values` over `time` [s].

    A time constant is the time to (e - 1)/e of the last value ([1] VI.A).
    """
    share = (values - values[0]) / (values[-1] - values[0])
    reached = int(np.argmax(share >= 1 - math.exp(-1)))
    if reached == 0:
        return 0.0
    ends = slice(reached - 1, reached + 1)
    return 3 * float(np.interp(1 - math.exp(-1), share[ends], time[ends]))
