"""Which parameters of a machine a cause of its parts frees."""

from __future__ import annotations

from collections.abc import Callable

from warmlink.orchestration.diagnosis.causes.catalogue import Cause
from warmlink.orchestration.machine.rig import Rig


def freed_in_parts(
    cause: Cause, rig: Rig, logged: Callable[[str], bool] = lambda name: False
) -> dict[str, tuple[str, ...]]:
    """Variables that a cause of motors and links frees in a machine, by the name of each case of it.

    A cause of one kind of part is `joint_resistance:x_motor` and so on if the machine has several of them.
    A part without the parameters is left out, and so is one whose input for the cause is neither fed by
    another part nor, by its full name, `logged`.
    """
    found: dict[str, tuple[str, ...]] = {}
    for kind, _, name in (each.partition(".") for each in cause.frees):
        for instance in rig.called(kind):
            needed = f"{instance}.{cause.covariate}"
            driven = cause.covariate is None or needed not in rig.variables or logged(needed)
            if driven and f"{instance}.{name}" in rig.parameters:
                found[instance] = (*found.get(instance, ()), f"{instance}.{name}")
    if len({name.partition(".")[0] for name in cause.frees}) == 1 and len(found) > 1:
        return {f"{cause.name}:{instance}": freed for instance, freed in found.items()}
    return {cause.name: tuple(name for freed in found.values() for name in freed)} if found else {}
