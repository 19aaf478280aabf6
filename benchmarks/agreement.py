"""Whether joined systems give a comparison's figures and ranks as the FMUs do, in every row."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from itertools import combinations, product
from typing import Annotated

import typer

from benchmarks.command import start
from warmlink.orchestration.command_line.arguments import listed
from warmlink.orchestration.console import answer, answer_json, remark
from warmlink.orchestration.progress import progress_bar
from warmlink.orchestration.studies.case import BOUNDED
from warmlink.orchestration.studies.compare import Comparison, plan_on, run_comparison
from warmlink.orchestration.studies.joined import differences_from_fmus
from warmlink.orchestration.studies.processes import LocalWorkers
from warmlink.orchestration.studies.session import RunOptions, open_study


@dataclass(frozen=True)
class Agreement:
    """How far the rows of a comparison agree.

    Attributes
    ----------
    coupling_um : the coupling error that the comparison prints
    largest_um : largest difference of a figure of the error, in the row `where`
    within : rows in which no figure differs by more than the coupling error
    cells : duty cycles under a mismatch, in each of which controllers are ranked by their largest error
    same_order : those in which the whole order is the same
    decided_alike : those in which no two that differ by more than the coupling error change places
    """

    rows: int
    coupling_um: float
    largest_um: float
    where: str
    within: int
    cells: int
    same_order: int
    decided_alike: int


def agreement(
    controllers: Sequence[str] | None,
    duties: Sequence[str] | None,
    mismatches: Sequence[str] | None,
    jobs: int,
) -> Agreement:
    """Compare both ways.

    Raises
    ------
    InputError
        If there is none of a name.
    """
    plan = plan_on(controllers=controllers, duty_cycles=duties, mismatches=mismatches)
    with open_study(plan.runs, RunOptions(jobs=jobs)) as work:
        told = differences_from_fmus(plan.runs, work.fmus, remark)
        with progress_bar("joined") as progress:
            joined = run_comparison(plan.cases, work.workers, progress)
        with LocalWorkers(replace(work.fmus, rollouts={}), jobs) as workers, progress_bar("FMUs") as progress:
            exact = run_comparison(plan.cases, workers, progress)
    return compared(joined, exact, max(coupling for _, coupling in told.values()))


def compared(joined: Comparison, exact: Comparison, coupling: float) -> Agreement:
    """Hold one comparison beside the other, with the coupling error in um."""
    differences = {
        key: max(abs(getattr(row.outcome, name) - getattr(exact.rows[key].outcome, name)) for name in BOUNDED)
        for key, row in joined.rows.items()
    }
    where = max(differences, key=differences.__getitem__)
    cells = list(product(joined.duty_cycles, joined.mismatches))
    same_order = decided_alike = 0
    for cell in cells:
        errors = [
            [each.rows[law, *cell].outcome.max_abs_um for law in joined.controllers]
            for each in (joined, exact)
        ]
        pairs = [(a - b, c - d) for (a, c), (b, d) in combinations(list(zip(*errors, strict=True)), 2)]
        turned = [min(abs(one), abs(other)) for one, other in pairs if one * other < 0]
        same_order += not turned
        decided_alike += all(size <= coupling for size in turned)
    within = sum(each <= coupling for each in differences.values())
    return Agreement(
        *(len(differences), coupling, differences[where], ", ".join(where), within),
        *(len(cells), same_order, decided_alike),
    )


def main(
    controllers: Annotated[str | None, typer.Option(help="Names, separated by commas.")] = None,
    duty_cycles: Annotated[str | None, typer.Option(help="Names, separated by commas.")] = None,
    mismatch: Annotated[str | None, typer.Option(help="Names, separated by commas.")] = None,
    jobs: Annotated[int, typer.Option(help="Processes that run at once.")] = 2,
    json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Run `compare` with joined systems and with FMUs, and print how far the rows agree."""
    found = agreement(listed(controllers), listed(duty_cycles), listed(mismatch), jobs)
    if json:
        answer_json(asdict(found))
        return
    answer(
        f"largest difference      {found.largest_um:.3g} µm ({found.where})\n"
        f"coupling error printed  {found.coupling_um:.3g} µm\n"
        f"rows within it          {found.within} of {found.rows}\n"
        f"controllers in order    {found.same_order} of {found.cells} duty cycles under a mismatch\n"
        f"... where told apart    {found.decided_alike} of {found.cells}"
    )


if __name__ == "__main__":
    start(main)
