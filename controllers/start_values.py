"""Parameters whose start values come from a design."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from warmlink.fmus.component import Parameter

Values = Mapping[str, float | Sequence[float]]
"""A parameter set: values by name, a sequence where the parameter is a vector."""


def design_file(law: str) -> Path:
    """File with the parameter set that ships for a law, by its folder's name; there is none for some laws."""
    return Path(__file__).parent / law / "designed.json"


def shipped_design(law: str) -> dict[str, float | list[float]]:
    """Parameter set that ships for a law, which `python -m warmlink.controllers.design` writes."""
    values: dict[str, float | list[float]] = json.loads(design_file(law).read_text("utf-8"))
    return values


def with_values(parameters: Sequence[Parameter], values: Values) -> tuple[Parameter, ...]:
    """Parameters whose start values are those given by name; the others keep theirs."""
    names = {parameter.name for parameter in parameters}
    return with_scalars(parameters, by_scalar({n: value for n, value in values.items() if n in names}))


def by_scalar(values: Values) -> dict[str, float]:
    """A parameter set by scalar name, as `mode_rate[1]`: what instances, FMUs and SSVs go by."""
    scalars: dict[str, float] = {}
    for name, value in values.items():
        if isinstance(value, Sequence):
            scalars.update({f"{name}[{i}]": float(each) for i, each in enumerate(value, start=1)})
        else:
            scalars[name] = float(value)
    return scalars


def with_scalars(parameters: Sequence[Parameter], values: Mapping[str, float]) -> tuple[Parameter, ...]:
    """Parameters whose start values are those given by scalar name (`mode_rate[1]`); the others keep theirs.

    Raises
    ------
    KeyError
        None of the parameters has a scalar of such a name.
    """
    left = dict(values)
    found: list[Parameter] = []
    for parameter in parameters:
        if left.keys().isdisjoint(parameter.scalar_names):
            found.append(parameter)
            continue
        kept = parameter.starts or (parameter.start,) * parameter.count
        starts = [left.pop(name, start) for name, start in zip(parameter.scalar_names, kept, strict=True)]
        several = None if parameter.size is None else tuple(starts)
        found.append(replace(parameter, start=starts[0], starts=several))
    if left:
        raise KeyError(f"no parameters: {', '.join(left)}")
    return tuple(found)
