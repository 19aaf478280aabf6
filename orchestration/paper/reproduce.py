"""The paper's tables, temperatures, times and statements, beside what the models here give for them.

Four of our own answers stand beside the measured and the predicted number: Eq. (4) as printed, its
correction, the 1-D link and the 3-D finite elements, these two with the boundary conditions of the paper.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from warmlink.orchestration.paper.cases import Case, CaseResult, run_case
from warmlink.orchestration.paper.statements import Row, Statement, findings, paper_rows, paper_statements
from warmlink.orchestration.paper.tried import (
    Agreement,
    Attempt,
    Consistency,
    Refinement,
    agreements,
    consistency,
    refinements,
    try_everything,
)


@dataclass(frozen=True)
class Reproduction:
    """Everything that `warmlink reproduce` shows; `pad_gaps` as of `try_everything`."""

    rows: Sequence[Row]
    statements: Sequence[Statement]
    attempts: Sequence[Attempt]
    pad_gaps: Mapping[str, float]
    consistency: Sequence[Consistency]
    findings: Sequence[str]
    refinements: Sequence[Refinement]
    agreements: Sequence[Agreement]
    cases: Mapping[str, CaseResult]


def reproduce(progress: Callable[[float], None] = lambda share: None) -> Reproduction:
    """Compute every number; about a minute.

    Parameters
    ----------
    progress : receives the fraction done

    Raises
    ------
    MissingExtraError
        scikit-fem is not installed.
    """
    cases = {}
    for share, name in ((0.0, "stationary"), (0.14, "moving")):
        progress(share)
        cases[name] = run_case(Case.printed(name))
    progress(0.2)
    attempts, gaps = try_everything(lambda share: progress(0.2 + 0.25 * share))
    progress(0.45)
    refined = refinements()
    progress(0.7)
    agreed = agreements(lambda share: progress(0.7 + 0.3 * share))
    consistent = consistency()
    found = Reproduction(
        rows=paper_rows(cases, attempts),
        statements=paper_statements(cases),
        attempts=attempts,
        pad_gaps=gaps,
        consistency=consistent,
        findings=findings(attempts, gaps, consistent),
        refinements=refined,
        agreements=agreed,
        cases=cases,
    )
    progress(1.0)
    return found
