"""The XML of SSP: its namespaces, and small steps of reading and writing that all its formats share.

SSP 2.0 kept the namespaces of 1.0 and tells its version in an attribute. Some readers (libcosim, Ecos) know
elements by their prefix alone, so writing always uses the standard's own prefixes.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from warmlink.fmus.errors import InputError
from warmlink.orchestration.system.archive import XML_LIMIT_BYTES
from warmlink.orchestration.system.model import Value
from warmlink.orchestration.system.units import BASE_UNITS, Unit, meaning
from warmlink.orchestration.system.xml import local, parse_xml
from warmlink.orchestration.text_files import is_file

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


def root_of_file(path: Path, expected: str, where: str) -> Any:
    """Parse an SSP document of the expected kind that is a file of its own, and give its root."""
    if not is_file(path):
        raise InputError(f"{path}: no such file; give the path of a file that holds a {expected}")
    with path.open("rb") as stream:
        # One more byte than the limit, so that the parser sees and says that it is exceeded.
        root = parse_xml(stream.read(XML_LIMIT_BYTES + 1), where)
    check_root(root, expected, where)
    return root


def check_root(root: Any, expected: str, where: str) -> None:
    """Check the name, namespace and version of a document's root, which may stand inside another document."""
    if local(root) != expected or not _SSP_NAMESPACE.match(str(root.tag)):
        raise InputError(f"{where}: its root is {local(root)}, not {expected} of SSP 1.0 or 2.0")
    version = root.get("version", "")
    if not _VERSION.match(version):
        raise InputError(f"{where}: version {version!r} is not supported; use SSP 1.0 or 2.0")


def element(prefix: str, tag: str, /, **attributes: str) -> Any:
    """Give a new root element that declares the prefixes of SSP."""
    from lxml import etree

    inside = ("ssv", "oms", "osp") if prefix == "ssd" else ()
    used = {key: PREFIXES[key] for key in ("ssc", *inside, prefix)}
    return etree.Element(f"{{{PREFIXES[prefix]}}}{tag}", attributes, nsmap=used)


def sub_element(parent: Any, prefix: str, tag: str, /, **attributes: Value | None) -> Any:
    """Add a child element and give it; attributes that are None are left out."""
    from lxml import etree

    texts = {name: _text(value) for name, value in attributes.items() if value is not None}
    return etree.SubElement(parent, f"{{{PREFIXES[prefix]}}}{tag}", texts)


def _text(value: Value) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    return (
        repr(float(value)) if isinstance(value, float) else str(value)
    )  # a NumPy float's repr tells its type


def unit_elements(root: Any, prefix: str, units: Iterable[Unit]) -> None:
    """Add a `Units` element with the definitions of some units, by name; nothing where there are none."""
    ordered = sorted(units, key=lambda unit: unit.name)
    held = sub_element(root, prefix, "Units") if ordered else None
    for unit in map(meaning, ordered):
        shown = dict(zip(BASE_UNITS, (each or None for each in unit.exponents or ()), strict=True))
        scale = None if unit.factor == 1.0 else unit.factor
        child = sub_element(held, "ssc", "Unit", name=unit.name)
        sub_element(child, "ssc", "BaseUnit", **shown, factor=scale, offset=unit.offset or None)


def to_bytes(root: Any) -> bytes:
    """Give a document's bytes, the same for the same content."""
    from lxml import etree

    return bytes(etree.tostring(root, xml_declaration=True, encoding="UTF-8", pretty_print=True))
