"""What the shell proposes for a name that is half typed."""

from __future__ import annotations

from collections.abc import Iterable


def scenarios(incomplete: str) -> list[str]:
    """Scenarios of the cell and of the arm."""
    from warmlink.orchestration.scenarios.load import scenario_names

    return _beginning(incomplete, scenario_names())


def controllers(incomplete: str) -> list[str]:
    """Controllers that warmlink ships."""
    from warmlink.orchestration.catalogue import controllers as known

    return _beginning(incomplete, known())


def mismatches(incomplete: str) -> list[str]:
    """Mismatches that warmlink ships."""
    from warmlink.orchestration.studies.mismatch import names as known

    return _beginning(incomplete, known())


def masters(incomplete: str) -> list[str]:
    """Master algorithms."""
    from warmlink.orchestration.master.algorithms.table import ALGORITHMS

    return _beginning(incomplete, ALGORITHMS)


def _beginning(incomplete: str, known: Iterable[str]) -> list[str]:
    return [name for name in known if name.startswith(incomplete)]
