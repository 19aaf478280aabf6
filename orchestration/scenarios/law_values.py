"""Parameters of a law's component: as start values of a run, and as a parameter set (SSV) for its FMU."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from warmlink.controllers.start_values import Values, by_scalar
from warmlink.fmus.arguments import argument, path_given
from warmlink.fmus.errors import InputError
from warmlink.orchestration import catalogue
from warmlink.orchestration.files import with_hash
from warmlink.orchestration.machine.machine import COMPENSATOR
from warmlink.orchestration.system.ssp.parameter_values import SsvValue, write_ssv
from warmlink.orchestration.system.units import parse_unit
from warmlink.orchestration.text_files import is_file


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


def source_named(system: str | Path, parameters: Mapping[str, str | float]) -> str:
    """A system or scenario: its name, with the hash of its file if it has one, and what is changed."""
    path = path_given("system", system)
    name = with_hash(path) if path.suffix in (".toml", ".ssp") and is_file(path) else f"{system} as it ships"
    changes = ", ".join(f"{key} = {value}" for key, value in parameters.items())
    return f"{name} with {changes}" if changes else name
