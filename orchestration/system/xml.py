"""Reading other people's XML without trusting it, attribute texts as values, and writing the XML of SSP.

Nothing here expands an entity or fetches from a network; whatever is wrong becomes one `InputError` that says
where it stands. SSP 2.0 kept the namespaces of 1.0 and tells its version in an attribute; elements are found
in any namespace. Some readers (libcosim, Ecos) know elements by their prefix alone, so writing always uses
the standard's own prefixes.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any, TypeVar

from warmlink.fmus.errors import InputError
from warmlink.orchestration.system.archive import XML_LIMIT_BYTES, brief
from warmlink.orchestration.text_files import demand_file

Read = TypeVar("Read")

XML_LIMIT_TAGS = 500_000
"""Opening and closing ones together: a tree in memory takes some hundred bytes for each."""

_BASE = "http://ssp-standard.org/SSP1/SystemStructure"
PREFIXES = {
    "ssd": f"{_BASE}Description",
    "ssc": f"{_BASE}Common",
    "ssv": f"{_BASE}ParameterValues",
    "ssm": f"{_BASE}ParameterMapping",
    "oms": "https://raw.githubusercontent.com/OpenModelica/OMSimulator/master/schema/oms.xsd",
    "osp": "http://opensimulationplatform.com/SSP/OSPAnnotations",
}
_SSP_NAMESPACE = re.compile(r"^\{http://ssp-standard\.org/SSP[12]/SystemStructure[A-Za-z]+\}")
_VERSION = re.compile(r"^[12]\.\d+(-.*)?$")


def parse_xml(data: bytes, where: str, remarks: list[str] | None = None) -> Any:
    """Give the root of an XML document, without comments and processing instructions.

    It must declare no document type, so that there is no entity to expand or fetch. `where` is how an error
    names it, such as `cell.ssp: SystemStructure.ssd`. A prefix that the document does not declare is refused
    without `remarks`; with them it has the standard's meaning, and the remark does not repeat `where`.
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
    parser = _parser()
    try:
        root = etree.fromstring(data, parser)
    except etree.XMLSyntaxError as fault:
        faults = list(parser.error_log)
        if remarks is None or any(
            each.type != etree.ErrorTypes.NS_ERR_UNDEFINED_NAMESPACE for each in faults
        ):
            raise InputError(f"{where}: not well-formed XML ({brief(fault)}); make it anew") from fault
        root = etree.fromstring(data, _parser(recover=True))
        remarks += _declared(root, faults[0].line)
    except ValueError as fault:
        raise InputError(f"{where}: not well-formed XML ({brief(fault)}); make it anew") from fault
    if root is None or root.getroottree().docinfo.internalDTD is not None:
        raise InputError(f"{where}: empty, or declares a document type, which could hold entities")
    return root


def _parser(recover: bool = False) -> Any:
    from lxml import etree

    off = dict.fromkeys(("resolve_entities", "load_dtd", "huge_tree"), False)
    return etree.XMLParser(no_network=True, remove_comments=True, remove_pis=True, recover=recover, **off)


def _declared(root: Any, line: int) -> Iterator[str]:
    """Give elements with undeclared prefixes the namespaces that these stand for, and a remark on each."""
    found: dict[str, None] = {}
    for each in root.iter():
        prefix, colon, name = str(each.tag).partition(":")
        if colon and not prefix.startswith("{"):
            found[prefix] = None
            each.tag = f"{{{PREFIXES.get(prefix, f'urn:undeclared:{prefix}')}}}{name}"
    names = ", ".join(found) or "of an attribute"
    yield f"the prefix {names} is not declared (from line {line} on) and is read as the standard's"


def required(element: Any, name: str, where: str) -> str:
    """Give an attribute that the standard demands."""
    text = element.get(name)
    if text is None:
        raise InputError(f"{where}: {local(element)} lacks its attribute {name}")
    return str(text)


def any_number(text: str, where: str) -> float:
    """Give a number that may be NaN or infinite, as an xs:double may."""
    with suppress(ValueError):
        if "_" not in text:
            return float(text)
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


def refuse_other_children(parent: Any, known: tuple[str, ...], where: str) -> None:
    """Refuse by name any child element of SSP that is not read; notes are passed over."""
    for child in parent:
        if local(child) not in (*known, "Annotations", "MetaData"):
            raise InputError(
                f"{where}: the element {local(child)} is not supported; remove it or write it another way"
            )


def root_of_file(path: Path, expected: str, where: str, remarks: list[str]) -> Any:
    """Parse an SSP document of the expected kind that is a file of its own, and give its root."""
    demand_file(path, f"give the path of a file that holds a {expected}")
    with path.open("rb") as stream:
        # One more byte than the limit, so that the parser sees and says that it is exceeded.
        found: list[str] = []
        root = parse_xml(stream.read(XML_LIMIT_BYTES + 1), where, found)
    remarks += [f"{where}: {each}" for each in found]
    check_root(root, expected, where, remarks)
    return root


def check_root(root: Any, expected: str, where: str, remarks: list[str]) -> None:
    """Check the name and version of a document's root, which may stand inside another document.

    A namespace that is not the standard's is a remark.
    """
    if local(root) != expected:
        raise InputError(f"{where}: its root is {local(root)}, not {expected} of SSP 1.0 or 2.0")
    if not _SSP_NAMESPACE.match(str(root.tag)):
        space = str(root.tag)[1:].rpartition("}")[0] if str(root.tag).startswith("{") else ""
        told = f"is in the namespace {space[:80]!r}" if space else "is in no namespace"
        remarks.append(f"{where}: {expected} {told}, not in that of SSP; it is read as if it were")
    version = root.get("version", "")
    if not _VERSION.match(version):
        raise InputError(f"{where}: version {version!r} is not supported; use SSP 1.0 or 2.0")


def element(prefix: str, tag: str, /, **attributes: str) -> Any:
    """Give a new root element that declares the prefixes of SSP."""
    from lxml import etree

    inside = ("ssv", "oms", "osp") if prefix == "ssd" else ()
    used = {key: PREFIXES[key] for key in ("ssc", *inside, prefix)}
    return etree.Element(f"{{{PREFIXES[prefix]}}}{tag}", attributes, nsmap=used)


def sub_element(parent: Any, prefix: str, tag: str, /, **attributes: str | float | None) -> Any:
    """Add a child element and give it; attributes that are None are left out."""
    from lxml import etree

    texts = {name: text_of(value) for name, value in attributes.items() if value is not None}
    return etree.SubElement(parent, f"{{{PREFIXES[prefix]}}}{tag}", texts)


def text_of(value: str | float) -> str:
    """Give a value as an attribute holds it."""
    if isinstance(value, bool):
        return "true" if value else "false"
    # A NumPy float's repr tells its type.
    return repr(float(value)) if isinstance(value, float) else str(value)


def to_bytes(root: Any) -> bytes:
    """Give a document's bytes, the same for the same content."""
    from lxml import etree

    return bytes(etree.tostring(root, xml_declaration=True, encoding="UTF-8", pretty_print=True))
