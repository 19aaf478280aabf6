"""`warmlink check`: an FMU or a system checked as its users would check it."""

from __future__ import annotations

from pathlib import Path

from warmlink.orchestration.console import FAILED, answer, answer_json, print_table

COMMANDS = ("check",)

_SIGNS = {
    "pass": ("pass", "green"),
    "fail": ("FAIL", "red"),
    "skip": ("skip", "yellow"),
    "remark": ("note", "yellow"),
}


def check(
    file: Path, *, variant: str | None = None, time_limit: str | None = None, json: bool = False
) -> None:
    """Check an FMU or a system as its user would check it; the exit code is 1 if a check fails.

    Parameters
    ----------
    file : An .fmu or .ssp file from any tool.
    time_limit : Longest time that one check of an FMU may take. Default: "30 s".
    """
    from rich.text import Text

    from warmlink.orchestration.check.checked import check as check_file
    from warmlink.orchestration.check.fmu import TIME_LIMIT

    found = check_file(file, variant=variant, time_limit=time_limit or TIME_LIMIT)
    if json:
        answer_json(found.to_dict())
    else:
        rows = [(each.name, Text(*_SIGNS[each.verdict]), each.detail) for each in found.results]
        print_table(found.name, ("check", "", "detail"), rows)
        sound = sum(each.verdict != "fail" for each in found.results)
        answer(f"{sound} of {len(found.results)} checks found no fault")
    if found.failed:
        raise SystemExit(FAILED)
