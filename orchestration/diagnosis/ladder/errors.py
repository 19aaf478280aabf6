"""Errors in units of differences, and whether they matter to whoever asks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from warmlink.orchestration.diagnosis.fit.verdict import Word
from warmlink.orchestration.system.units import parse_unit


def shown(unit: str) -> str:
    """Unit in which an error in a column of this unit is shown: a difference of temperatures is K."""
    if unit in ("um", "µm", "micrometer", "micron"):
        return "um"
    return "K" if parse_unit(unit).exponents == parse_unit("K").exponents else unit


def per_si(unit: str) -> float:
    """Factor from SI to a unit, for differences."""
    return 1.0 / parse_unit(unit).factor


def largest_errors(by_run: Sequence[Mapping[str, float]]) -> dict[str, float]:
    """Largest root mean square error of any run by column name."""
    found: dict[str, float] = {}
    for errors in by_run:
        for name, error in errors.items():
            found[name] = max(error, found.get(name, 0.0))
    return found


def good_enough(
    errors: Mapping[str, float], accuracy: Mapping[str, tuple[float, str]], found: tuple[Word, str]
) -> tuple[Word, str]:
    """Verdict and what is to be said of it, where the errors that matter are known.

    Parameters
    ----------
    errors : of the uncorrected model in SI, by column name
    accuracy : error that matters in SI and the unit of the column, by column name; it rules if every column
        has one
    found : verdict by the noise, and what is said of it
    """
    if not errors or not errors.keys() <= accuracy.keys() or found[0] == "adequate":
        return found
    name = max(errors, key=lambda each: errors[each] / accuracy[each][0])
    asked, unit = accuracy[name]
    if errors[name] > asked:
        return found
    size, wanted = (f"{each * per_si(shown(unit)):.3g} {shown(unit)}" for each in (errors[name], asked))
    return "adequate", (
        f"The model is adequate for what you asked: {name} is off most, by {size} rms, and {wanted} matter. "
        "Beyond the noise something is wrong all the same."
    )
