"""Parameter sets (SSV) as start values of a scenario: what `design`, `tune` and `diagnose` write."""

from __future__ import annotations

from pathlib import Path

from warmlink.fmus.errors import InputError
from warmlink.orchestration.system.shipped import COMPENSATOR
from warmlink.orchestration.system.ssp.parameter_values import read_ssv


def parameters_of(path: Path) -> dict[str, float]:
    """Start values in SI units by `instance.variable`; names without an instance are the compensator's.

    Raises
    ------
    InputError
        The file cannot be read, or holds a value that is no number.
    """
    found = {}
    for name, parameter in read_ssv(path).items():
        full = name if "." in name else f"{COMPENSATOR}.{name}"
        value, unit = parameter.value, parameter.unit
        if isinstance(value, str):
            raise InputError(f"{path.name}: {name}: {value!r} is not a number; leave it out of the file")
        found[full] = float(value) if unit is None else unit.factor * float(value) + unit.offset
    return found
