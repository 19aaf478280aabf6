"""Start values given to a comparison: which of its controllers take them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from warmlink.fmus.component import Component
from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.orchestration.scenarios.overrides import StartValueSet, settable
from warmlink.orchestration.system.shipped import COMPENSATOR


def takers(given: StartValueSet, controllers: Mapping[str, Component]) -> list[str]:
    """Controllers for which a set is: those that have every variable that it sets of the compensator.

    The parameters of a designed observer, say, none but observers have.

    Raises
    ------
    InputError
        If there is none.
    """
    names = _of_compensator(given)
    found = [name for name, law in controllers.items() if names <= settable(law).keys()]
    if found:
        return found
    # The law that has most of them is the one that was meant.
    known = max((settable(law).keys() for law in controllers.values()), key=lambda held: len(names & held))
    missing = min(names - known)
    every = sorted({each for law in controllers.values() for each in settable(law)})
    remedy = instead(missing, every, "or compare the controller that it is for")
    raise InputError(f"{given.origin}: no controller compared has {COMPENSATOR}.{missing}; {remedy}")


def assigned(
    sets: Sequence[StartValueSet], controllers: Mapping[str, Component]
) -> dict[str, dict[str, str | float]]:
    """Start values for each controller; later sets outdo earlier ones. Raises as `takers`."""
    values: dict[str, dict[str, str | float]] = {name: {} for name in controllers}
    for given in sets:
        taking = takers(given, controllers)
        for name in controllers:
            values[name] |= {
                key: value
                for key, value in given.values.items()
                if name in taking or key.rpartition(".")[0] != COMPENSATOR
            }
    return values


def told(given: StartValueSet, controllers: Mapping[str, Component]) -> str | None:
    """Sentence that says for whom a set is; None where it sets nothing of a controller."""
    return f"{given.origin}: for {', '.join(takers(given, controllers))}" if _of_compensator(given) else None


def _of_compensator(given: StartValueSet) -> set[str]:
    split = (name.rpartition(".") for name in given.values)
    return {variable for instance, _, variable in split if instance == COMPENSATOR}
