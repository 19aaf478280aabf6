"""The form of a cause, and the catalogue: every TOML file in this folder."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, lru_cache
from pathlib import Path
from typing import Any, Literal

from warmlink.fmus.errors import InputError
from warmlink.orchestration.text_files import read_toml

Kind = Literal[
    "plant",
    "input",
    "place",
    "temperature sensor",
    "camera",
    "reading",
    "declared reading",
    "record",
    "simulation",
]


@dataclass(frozen=True)
class Cause:
    """Something that may be missing from or wrong in the model.

    Attributes
    ----------
    name : as in the results, which add the channel after a colon where the cause belongs to an instrument
    sentence : what happens, for a technician
    frees : variables that take one common value, as `link.emissivity`; for the cause of an instrument the
        name within the instrument, as `lag`
    lower, upper : physical bounds in SI units
    looks_like, check : what it looks like in the data, and what to check on the machine
    neutral : value that changes nothing; None: the nominal value
    shown_unit : unit in which people read the value
    relative : whether the bounds are factors on the nominal value
    added : whether the value is added to each variable's own, so that the bounds are differences
    grouped : whether it may hold for the columns of one logger alone
    material : whether it is a property of the material, which is the same in all runs
    covariate : input whose column the cause needs
    declared : whether a person declared it, so that it frees exactly the variables that it names
    kind : what it belongs to; a cause of kind "simulation" is checked before all others, and not fitted
    """

    name: str
    sentence: str
    frees: tuple[str, ...]
    lower: float
    upper: float
    looks_like: str
    check: str
    neutral: float | None = None
    shown_unit: str = ""
    relative: bool = False
    added: bool = False
    grouped: bool = False
    material: bool = False
    covariate: str | None = None
    declared: bool = False
    kind: Kind = "plant"


@lru_cache(maxsize=1)
def catalogue() -> tuple[Cause, ...]:
    """Every cause declared in this folder, by name."""
    return tuple(read_cause(path) for path in sorted(Path(__file__).parent.glob("*.toml")))


def read_cause(path: Path) -> Cause:
    """Read the declaration of a cause; its name is that of the file.

    Raises
    ------
    InputError
        An entry is missing, not known, or of the wrong type.
    """
    from pydantic import ValidationError

    try:
        return _form().validate_python({**read_toml(path), "name": path.stem})
    except ValidationError as fault:
        first = fault.errors()[0]
        entry = ".".join(map(str, first["loc"]))
        raise InputError(f"{path.name}: {entry}: {first['msg']}; see the other files in causes/") from None


@cache
def _form() -> Any:
    from pydantic import ConfigDict, TypeAdapter, with_config

    return TypeAdapter(with_config(ConfigDict(extra="forbid"))(Cause))
