"""The form of a cause, and the catalogue made of the folder `causes`."""

from __future__ import annotations

import importlib
import pkgutil
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

Kind = Literal["plant", "temperature sensor", "camera", "reading", "record", "simulation"]


@dataclass(frozen=True)
class Cause:
    """Something that may be missing from or wrong in the model.

    Attributes
    ----------
    name : as in the results; a cause of an instrument bears its channel after a colon
    sentence : what happens, for a technician
    frees : variables that take one common value, as `link.emissivity`; for an instrument's cause the name
        within the instrument, as `lag`
    lower, upper : physical bounds in SI units
    neutral : value that changes nothing; None: the nominal value
    shown_unit : unit in which people read the value
    looks_like, check : what it looks like in the data, and what to look at on the machine
    kind : what it belongs to; one of the simulation itself is checked before all others, not fitted
    relative : whether the bounds are factors on the nominal value
    material : whether it is a property of the material, which no label of a run changes
    covariate : input whose column the cause needs
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
    material: bool = False
    covariate: str | None = None
    kind: Kind = "plant"


@lru_cache(maxsize=1)
def catalogue() -> tuple[Cause, ...]:
    """Every cause declared in the folder `causes`, by name."""
    package = importlib.import_module("warmlink.orchestration.diagnosis.causes")
    found = [
        importlib.import_module(f"{package.__name__}.{module.name}").CAUSE
        for module in pkgutil.iter_modules(package.__path__)
    ]
    return tuple(sorted(found, key=lambda cause: cause.name))
