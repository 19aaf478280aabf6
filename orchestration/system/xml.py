"""Reading other people's XML without trusting it; attribute texts as values.

Nothing here expands an entity or fetches from a network; whatever is wrong becomes one `InputError` that says
where it stands.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Any, TypeVar

from warmlink.fmus.errors import InputError
from warmlink.orchestration.system.archive import XML_LIMIT_BYTES, brief

Read = TypeVar("Read")

XML_LIMIT_TAGS = 500_000
"""Opening and closing ones together: a tree in memory takes some hundred bytes for each."""


def parse_xml(data: bytes, where: str) -> Any:
    """Give the root of an XML document, without comments and processing instructions.

    It must declare no document type, so that there is no entity to expand or fetch. `where` is how an error
    names it, such as `cell.ssp: SystemStructure.ssd`.
    """
    from lxml import etree

    if len(data) > XML_LIMIT_BYTES:
        raise InputError(f"{where}: is larger than {XML_LIMIT_BYTES >> 20} MiB, the limit; make it smaller")
    # As many as there may be attributes; in other encodings the limit is not lower.
    if data.count(b"<") > XML_LIMIT_TAGS or data.count(b"=") > 4 * XML_LIMIT_TAGS:
        raise InputError(
            f"{where}: has more than {XML_LIMIT_TAGS} tags or {4 * XML_LIMIT_TAGS} attributes, the limit; "
            "make it smaller"
        )
    # Before parsing, for every encoding in which the characters are one or two bytes wide.
    if b"<!DOCTYPE" in data.replace(b"\0", b"").upper():
        raise InputError(f"{where}: declares a document type, which could hold entities; remove the DOCTYPE")
    parser = etree.XMLParser(
        resolve_entities=False,
        no_network=True,
        load_dtd=False,
        huge_tree=False,
        remove_comments=True,
        remove_pis=True,
    )
    try:
        root = etree.fromstring(data, parser)
    except (etree.XMLSyntaxError, ValueError) as fault:
        raise InputError(f"{where}: not well-formed XML ({brief(fault)}); make it anew") from fault
    if root is None or root.getroottree().docinfo.internalDTD is not None:
        raise InputError(f"{where}: empty, or declares a document type, which could hold entities")
    return root


def required(element: Any, name: str, where: str) -> str:
    """Give an attribute that the standard demands."""
    text = element.get(name)
    if text is None:
        raise InputError(f"{where}: {local(element)} lacks its attribute {name}")
    return str(text)


def any_number(text: str, where: str) -> float:
    """Give a number that may be NaN or infinite, as an xs:double may."""
    try:
        if "_" not in text:
            return float(text)
    except ValueError:
        pass
    raise InputError(f"{where}: {text!r} is not a number")


def number(text: str, where: str) -> float:
    """Give a finite number."""
    value = any_number(text, where)
    if not math.isfinite(value):
        raise InputError(f"{where}: {text!r} is not a finite number")
    return value


def integer(text: str, where: str) -> int:
    """Give an integer of at most 64 bits."""
    try:
        value = int(text)
    except ValueError:
        value = 1 << 64
    if not -(1 << 63) <= value < 1 << 64 or "_" in text:
        raise InputError(f"{where}: {text!r} is not an integer of 64 bits")
    return value


def truth(text: str, where: str) -> bool:
    """Give a truth value: true, false, 1 or 0."""
    if text.strip() not in ("true", "false", "1", "0"):
        raise InputError(f"{where} is {text!r}, neither true nor false")
    return text.strip() in ("true", "1")


def optional(element: Any, name: str, read: Callable[[str, str], Read], where: str) -> Read | None:
    """Give an attribute as `number`, `integer` or `truth` read it, or None where it is absent."""
    text = None if element is None else element.get(name)
    return None if text is None else read(text, f"{where}: {name}")


def local(element: Any) -> str:
    """Give an element's name without its namespace."""
    return str(element.tag).rpartition("}")[2]


def children(parent: Any, name: str) -> Iterator[Any]:
    """Give the child elements of one name."""
    return (child for child in (() if parent is None else parent) if local(child) == name)


def only_child(parent: Any, name: str) -> Any:
    """Give the first child of one name, or None."""
    return next(children(parent, name), None)


def refuse_other_children(parent: Any, known: tuple[str, ...], where: str) -> None:
    """Refuse by name any child element of SSP that is not read; notes are passed over."""
    for child in parent:
        if local(child) not in (*known, "Annotations", "MetaData"):
            raise InputError(
                f"{where}: the element {local(child)} is not supported; remove it or write it another way"
            )
