"""`warmlink reproduce`: the paper's tables beside ours."""

from __future__ import annotations

from pathlib import Path

from warmlink.orchestration.commands.console import answer, answer_json, progress_bar
from warmlink.orchestration.files import fresh_folder


def reproduce_command(out: Path, as_json: bool) -> None:
    """Compute, write the report and print the tables."""
    from dataclasses import asdict

    from warmlink.orchestration.paper.presentation import write_report
    from warmlink.orchestration.paper.reproduce import reproduce
    from warmlink.orchestration.paper.terminal import terminal_table

    with fresh_folder(out) as target:
        with progress_bar("The paper, reproduced") as progress:
            result = reproduce(lambda share, what: progress(share))
        write_report(result, target / "report.html")
    if as_json:
        answer_json({"rows": [asdict(row) for row in result.rows], "findings": list(result.findings)})
        return
    from rich.console import Console

    Console().print(terminal_table(result))
    answer(f"report  {out / 'report.html'}")
