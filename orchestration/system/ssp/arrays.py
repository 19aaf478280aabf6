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
from warmlink.orchestration.system import xml
from warmlink.orchestration.system.model import ModelInfo
from warmlink.orchestration.system.ssp.net import Edge, Element, Net, Node

_ELEMENT = re.compile(r"(.+)\[(\d+(?:,\d+)*)\]")


MOST_ELEMENTS = 100_000
"""Of one array in an SSP."""


def sizes_of_array(texts: Iterable[str], where: str) -> tuple[int, ...]:
    """Sizes of an array's dimensions; InputError if one is no integer above 0, or they are too many."""
    sizes = tuple(xml.integer(text, where) for text in texts)
    for size in sizes:
        if size < 1:
            raise InputError(f"{where}: has a dimension of {size} elements; give at least one")
    if math.prod(sizes) > MOST_ELEMENTS:
        raise InputError(f"{where}: has {math.prod(sizes)} elements; give at most {MOST_ELEMENTS}")
    return sizes


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


Sizes = dict[Node, tuple[int, ...]]
"""Sizes of arrays by the connectors that they are as a whole."""


def arrays_in(net: Net) -> Sizes:
    """Sizes of the arrays of FMI 3.0 of which a component shows an element."""
    found: Sizes = {}
    for path, element in net.elements.items():
        for name in element.connectors:
            array, _ = array_and_indices(name)
            if element.info is not None and name in element.info.arrays.get(array, ()):
                found[Node(path, array)] = array_and_indices(element.info.arrays[array][-1])[1]
    return found


def array_of(node: Node, arrays: Sizes) -> str:
    """Name of the array that an element belongs to; that of any other connector itself."""
    array, _ = array_and_indices(node.connector)
    return array if replace(node, connector=array) in arrays else node.connector


Indices = tuple[int, ...]


def joined_edges(edges: Iterable[Edge], arrays: Sizes) -> list[tuple[Edge, tuple[Indices, Indices]]]:
    """Connections with those of all elements of two arrays as one, and the others' indices at both ends."""
    by_ends: dict[tuple[Node, Node], list[Edge]] = {}
    for edge in edges:
        ends = [replace(node, connector=array_of(node, arrays)) for node in edge.ends]
        by_ends.setdefault((ends[0], ends[1]), []).append(edge)
    found: list[tuple[Edge, tuple[Indices, Indices]]] = []
    for (source, target), each in by_ends.items():
        wanted = [element_names(node.connector, arrays.get(node, ())) for node in (source, target)]
        given = [tuple(edge.ends[end].connector for edge in each) for end in (0, 1)]
        alike = len({replace(edge, source=source, target=target) for edge in each}) == 1
        whole = alike and wanted == given and arrays.get(source) == arrays.get(target)
        for edge in each[:1] if whole else each:
            inside = [
                () if whole or node not in arrays else array_and_indices(end.connector)[1]
                for node, end in zip((source, target), edge.ends, strict=True)
            ]
            found.append((replace(edge, source=source, target=target), (inside[0], inside[1])))
    return found
