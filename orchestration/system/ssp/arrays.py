"""Arrays of SSP 2.0 become their elements, which bear the names of FMI 3.0, as `A[1,2]`, counted from 1.

An array connector of a component stands for scalars of these names if its FMU, as one of FMI 2.0, has those.
The elements of a system's array connector are led through one by one.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import product

from warmlink.fmus.errors import InputError
from warmlink.orchestration.system.model import ModelInfo
from warmlink.orchestration.system.ssp.net import Edge, Element, Net, Node

_ELEMENT = re.compile(r"(.+)\[(\d+(?:,\d+)*)\]")


def element_names(name: str, sizes: Sequence[int]) -> tuple[str, ...]:
    """Names of an array's elements row by row; its own name if it has no sizes, being a scalar."""
    if not sizes:
        return (name,)
    return tuple(f"{name}[{','.join(map(str, at))}]" for at in product(*(range(1, n + 1) for n in sizes)))


def element_of(name: str, indices: Iterable[int]) -> str:
    """Name of the element of an array at some indices."""
    return f"{name}[{','.join(map(str, indices))}]"


def array_and_indices(name: str) -> tuple[str, tuple[int, ...]]:
    """Name of the array that an element belongs to, and its indices; a scalar's own name, and none."""
    found = _ELEMENT.fullmatch(name)
    return (name, ()) if found is None else (found[1], tuple(int(each) for each in found[2].split(",")))


def mapped_elements(entries: Iterable[Edge], parameters: Iterable[str]) -> tuple[Edge, ...]:
    """Give the entries of a parameter mapping with one for each element of an array that it maps."""
    known = list(parameters)
    return tuple(
        replace(
            entry,
            source=replace(entry.source, connector=name),
            target=replace(entry.target, connector=entry.target.connector + name[len(source) :]),
        )
        for entry in entries
        for source in [entry.source.connector]
        for name in [each for each in known if array_and_indices(each)[0] == source] or [source]
    )


def take_apart(net: Net) -> None:
    """Put elements in the place of array connectors, and of the connections between them.

    InputError if an array has another number of elements in its FMU, or those of two connected differ.
    """
    names: dict[Node, tuple[str, ...]] = {}
    for path, element in net.elements.items():
        declared = dict(element.connectors)
        element.connectors.clear()
        for name, connector in declared.items():
            node = Node(path, name)
            names[node] = _elements(node, element, connector.sizes)
            element.connectors.update(dict.fromkeys(names[node], replace(connector, sizes=())))
    for element in net.elements.values():
        element.connections[:] = [each for edge in element.connections for each in _edges(edge, names)]


def _elements(node: Node, element: Element, sizes: Sequence[int]) -> tuple[str, ...]:
    """Give the elements of a connector, which an FMU of FMI 3.0 tells by itself."""
    info, wanted = element.info, element_names(node.connector, sizes)
    if info is None:
        return wanted
    held = info.arrays.get(node.connector) or _scalars(info, node.connector, wanted)
    if sizes and len(held) != math.prod(sizes):
        told = f"is declared with {math.prod(sizes)} elements, but has {len(held)} in its FMU"
        raise InputError(f"{node}: {told}; correct one")
    return held


def _scalars(info: ModelInfo, name: str, wanted: tuple[str, ...]) -> tuple[str, ...]:
    """Give the scalars that stand for an array in an FMU that has none, else the connector's own name."""
    first = element_of(name, (1,) * max(1, wanted[0].count(",") + 1))
    if len(wanted) > 1 and first in info.variables:
        known = [each for each in info.variables if array_and_indices(each)[0] == name]
        return wanted if set(wanted) == set(known) else tuple(known)
    return wanted if set(wanted) <= info.variables.keys() else (name,)


def _edges(edge: Edge, names: dict[Node, tuple[str, ...]]) -> list[Edge]:
    """Give the connections of the elements of two ends."""
    sources, targets = (names.get(node, (node.connector,)) for node in edge.ends)
    if len(sources) != len(targets):
        counts = f"{len(sources)} and {len(targets)} elements"
        remedy = "connect arrays of one size, or give startIndices or endIndices"
        raise InputError(f"{edge}: {counts}; {remedy}")
    return [
        replace(edge, source=replace(edge.source, connector=a), target=replace(edge.target, connector=b))
        for a, b in zip(sources, targets, strict=True)
    ]
