"""Parameters of a law's component: as start values of a run, and as a parameter set (SSV) for its FMU."""

from __future__ import annotations

from pathlib import Path

from warmlink.controllers.start_values import Values, by_scalar
from warmlink.fmus.arguments import argument
from warmlink.fmus.errors import InputError
from warmlink.orchestration import catalogue
from warmlink.orchestration.machine.machine import COMPENSATOR
from warmlink.orchestration.system.ssp.parameter_values import SsvValue, write_ssv
from warmlink.orchestration.system.units import parse_unit


def start_values_of(values: Values) -> dict[str, float]:
    """Start values by full name, as `compensator.gain`, in SI units."""
    return {f"{COMPENSATOR}.{name}": value for name, value in by_scalar(values).items()}


def write_law_values(law: str, values: Values, path: str | Path, title: str, source: str) -> None:
    """Write the parameter set of a law's FMU.

    Parameters
    ----------
    law : name
    values : in SI units
    path : .ssv file
    title : what the set is called
    source : what it was made from, which an export of the law repeats

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    units = {s.name: s.variable.unit for s in catalogue.controller(law).scalars()}
    held = {
        name: SsvValue(name, "Real", value, None if units[name] == "1" else parse_unit(units[name]))
        for name, value in by_scalar(values).items()
    }
    try:
        write_ssv(held, Path(path), title, source)
    except OSError as fault:
        raise InputError(
            f"{path}: cannot be written ({fault.strerror}); choose another {argument('out')}"
        ) from None
