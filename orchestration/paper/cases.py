"""The paper's two cases as drives, and the finite-element models that run them."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from warmlink.orchestration.paper.data import (
    Geometry,
    Materials,
    Printed,
    load_geometry,
    load_materials,
    load_paper,
)
from warmlink.orchestration.paper.fea.drive import Drive, Smooth, TimeGrid, graded_grid
from warmlink.orchestration.paper.fea.mesh import Assembly, paper_assembly
from warmlink.orchestration.paper.fea.simulate import Fea, History
from warmlink.orchestration.paper.link_model import LinkHistory, LinkModel

Array = NDArray[np.float64]

ZERO_CELSIUS = 273.15


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
        n: dict[str, Printed] = load_paper()[name]
        return cls(
            name=name,
            shaft=n["shaft"].value + ZERO_CELSIUS,
            ambient=n["ambient"].value + ZERO_CELSIUS,
            convection=n["convection"].value,
            duration=n["duration"].value,
        )

    @property
    def rise(self) -> float:
        """Shaft above ambient [K]."""
        return self.shaft - self.ambient

    @property
    def grid(self) -> TimeGrid:
        """Steps that grow after the shaft's temperature jumps."""
        return graded_grid([0.0, self.duration])

    def drive(self, *, radiation: bool = False, lag: float = 0.0, convection: float | None = None) -> Drive:
        """Hold the shaft's temperature; `lag` [s] delays it by a first order, `convection` replaces h."""
        rise, ambient = self.rise, self.ambient

        def heated(time: float) -> float:
            return ambient + rise * (-math.expm1(-time / lag) if lag > 0 else 1.0)

        h = self.convection if convection is None else convection
        return Drive(Smooth(h), Smooth(ambient), temperature=Smooth(heated), radiation=radiation)


@dataclass
class Bench:
    """Geometry, materials and the finite-element models made so far, so that none is made twice."""

    geometry: Geometry = field(default_factory=load_geometry)
    materials: Materials = field(default_factory=load_materials)
    _models: dict[Assembly, Fea] = field(default_factory=dict)

    def fea(self, assembly: Assembly, displacement_order: int = 2) -> Fea:
        """Return the finite-element model of an assembly."""
        if assembly not in self._models:
            body = paper_assembly(self.geometry, self.materials, assembly)
            self._models[assembly] = Fea(body, displacement_order)
        return self._models[assembly]

    def run_fea(self, case: Case, drive: Drive, assembly: Assembly) -> History:
        """Run a case on the finite elements."""
        return self.fea(assembly).run(drive, case.grid, case.ambient)

    def run_link(self, case: Case, drive: Drive) -> LinkHistory:
        """Run a case on the 1-D link, its base held at the shaft's temperature."""
        return LinkModel(self.geometry, self.materials.link).run(drive, case.grid, case.ambient)


def steady_time(time: Array, values: Array) -> float:
    """Three time constants [s], a time constant being the time to (e - 1)/e of the last value ([1] VI.A).

    Parameters
    ----------
    time : increasing [s], shape (n,)
    values : what approaches its last value from its first, shape (n,)
    """
    share = (values - values[0]) / (values[-1] - values[0])
    reached = int(np.argmax(share >= 1 - math.exp(-1)))
    if reached == 0:
        return 0.0
    ends = slice(reached - 1, reached + 1)
    return 3 * float(np.interp(1 - math.exp(-1), share[ends], time[ends]))
