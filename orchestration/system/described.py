"""What an FMU says of itself under what a system chooses: an interface of it, and the sizes of its arrays."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path

from warmlink.orchestration.system import archive, xml
from warmlink.orchestration.system.description import parse_description, read_description
from warmlink.orchestration.system.model import FmuPart, ModelInfo, Value


def described(part: FmuPart) -> ModelInfo:
    """Give the description of a part's FMU for the interface that the system uses; InputError as of that.

    Its arrays have the sizes that the part's values of structural parameters give them.
    """
    return resized(read_description(part.fmu), part.values).used_as(part.implementation)


def resized(info: ModelInfo, values: Mapping[str, Value]) -> ModelInfo:
    """Give a description with the arrays' sizes that some start values mean (FMI 3.0 section 2.4.7.5)."""
    sizes = {
        name: int(value)
        for name, value in values.items()
        if name in info.variables and info.variables[name].causality == "structuralParameter"
    }
    if all(info.variables[name].start == size for name, size in sizes.items()):
        return info
    return _resized(info.path, tuple(sizes.items()))


@lru_cache(maxsize=256)
def _resized(fmu: Path, sizes: tuple[tuple[str, int], ...]) -> ModelInfo:
    where, remarks = f"{fmu.name}: modelDescription.xml", list[str]()
    root = xml.parse_xml(archive.read_member(fmu, "modelDescription.xml"), where, remarks)
    for variable in root.iterfind("ModelVariables/*"):
        if variable.get("name") in dict(sizes):
            variable.set("start", str(dict(sizes)[variable.get("name")]))
    return parse_description(root, fmu, where, other_sizes=True)
