"""What a machine's variables are for: what is scored, what a column holds, what controllers read."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated

from warmlink.controllers.interface import SENSED
from warmlink.fmus.component import Scalar
from warmlink.orchestration.written.entries import Names, Quantity
from warmlink.orchestration.written.expression import Expression
from warmlink.orchestration.written.tables import Table

TEMPERATURES = tuple(each.removesuffix("_temperature") for each in SENSED)


@dataclass(frozen=True)
class Roles:
    """Roles of a machine's variables: their `score` is the error of the tool point in m.

    `uncompensated` is the same error without a controller; of the coupling errors of the `plant`'s variables
    the largest is reported.
    """

    score: Expression
    uncompensated: Expression
    plant: tuple[str, ...]


NOTHING_SCORED = Roles(Expression("0"), Expression("0", "uncompensated"), ())
"""Roles of a bench, which has no tool point."""


@dataclass(frozen=True)
class WeightedSum:
    """A weighted sum of outputs: the weight of each by its full name, and what it is as a variable."""

    weights: Mapping[str, float]
    scalar: Scalar


@dataclass(frozen=True)
class Sensors(Table):
    """Thermometers that controllers use: noise (1 sigma), and which; None: as the machine has them."""

    noise: Annotated[float | None, Quantity("K", least=0, difference=True)] = None
    used: Annotated[tuple[str, ...] | None, Names("base", TEMPERATURES)] = None


AS_THEY_ARE = Sensors()
