"""What a reproduction of the paper consists of."""

from __future__ import annotations

from dataclasses import dataclass

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.paper.agreement import Agreement
from warmlink.orchestration.paper.cases import Case
from warmlink.orchestration.paper.fea.mesh import Body
from warmlink.orchestration.paper.fea.simulate import History
from warmlink.orchestration.paper.link_model import LinkHistory
from warmlink.orchestration.paper.tried import Attempt, Consistency


@dataclass(frozen=True)
class Row:
    """One number of the paper and ours for it; None where a column has no such number.

    `unit` is that of all columns; `place` says where the paper prints it; `note` what is behind a difference.
    """

    place: str
    case: str
    quantity: str
    unit: str
    link: float
    fea: float
    note: str
    measured: float | None = None
    predicted: float | None = None
    printed_eq4: float | None = None
    corrected: float | None = None

    @property
    def difference(self) -> float:
        """3-D FEA minus the measured number, or minus the predicted one where nothing was measured."""
        return self.fea - self._printed

    @property
    def difference_percent(self) -> float | None:
        """The difference relative to the paper's number [%]; None for temperatures."""
        return None if self.unit == "degC" else 100 * self.difference / self._printed

    @property
    def _printed(self) -> float:
        printed = self.predicted if self.measured is None else self.measured
        assert printed is not None
        return printed


@dataclass(frozen=True)
class Statement:
    """A statement of the paper that can be compared with the models: whether it is true, and the figures."""

    place: str
    claim: str
    holds: bool
    figures: str


@dataclass(frozen=True)
class Refinement:
    """One mesh of a convergence study: after an hour, tip temperature [degC] and elongation [um]."""

    body: str
    refinement: int
    tip: float
    elongation: float


@dataclass(frozen=True)
class CaseResult:
    """Both models' histories of a case, as described in the paper, with the body and the Fea that ran it."""

    case: Case
    fea: History
    link: LinkHistory
    body: Body
    displacement: Array
    corrected: Array
    printed: Array


@dataclass(frozen=True)
class Reproduction:
    """Everything that `warmlink reproduce` shows."""

    rows: tuple[Row, ...]
    statements: tuple[Statement, ...]
    attempts: tuple[Attempt, ...]
    pad_gaps: dict[str, float]
    consistency: tuple[Consistency, ...]
    findings: tuple[str, ...]
    refinements: tuple[Refinement, ...]
    agreements: tuple[Agreement, ...]
    cases: dict[str, CaseResult]
