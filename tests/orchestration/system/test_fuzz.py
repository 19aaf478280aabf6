"""Whatever is done to an SSP's bytes or XML, reading it either works or says in one sentence why not."""

from __future__ import annotations

import io
import shutil
import tempfile
import zipfile
from collections.abc import Callable
from pathlib import Path

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from warmlink.fmus.errors import InputError
from warmlink.orchestration.system.description import parse_description
from warmlink.orchestration.system.read import read_system
from warmlink.orchestration.system.xml import parse_xml

from .ssp_text import (
    LINK,
    MOTOR,
    Lab,
    connection,
    entry,
    fmi2,
    mapping,
    parameters,
)
from .test_description import FMI3, STRUCTURE

QUICK = settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.too_slow])
LINEAR = '<ssc:LinearTransformation factor="2" offset="1"/>'


def _made() -> tuple[bytes, str]:
    with tempfile.TemporaryDirectory() as folder:
        lab = Lab(Path(folder))
        end = "</ssd:ParameterBinding>"
        bound = parameters("L:Real:300:mm", "n:Integer:9").replace(
            end, mapping(entry("L", "length", LINEAR)) + end
        )
        text = lab.cell(
            connection("motor.heat_flow", "link.heat_flow")
            + connection("link.temperature", "motor.ambient", LINEAR),
            link=bound + parameters("metal:Enumeration:brass", "radiates:Boolean:true", "label:String:a"),
            after="<ssd:Annotations><ssc:Annotation type='a'/></ssd:Annotations>",
        )
        return lab.ssp(text).read_bytes(), text


SSP, SSD = _made()
FRAGMENTS = (
    *("", "-1", "1e999", "nan", "&amp;", "<x/>", "K", "W", "../", "9" * 30, "ssd:", "System", "true"),
    *("\u0000", "\ud7ff", "\n", "motor", "link.", "input", "output", "parameter", "Real", "Integer"),
    *('unit="', 'name="', "resources/Link.fmu"),
)


def read(data: bytes) -> None:
    folder = Path(tempfile.mkdtemp())
    try:
        path = folder / "cell.ssp"
        path.write_bytes(data)
        one_sentence(lambda: read_system(path, folder / "work"))
    finally:
        shutil.rmtree(folder)


def one_sentence(action: Callable[[], object]) -> None:
    """Do something; nothing may come of it but success or one line that says what is wrong."""
    said = "nothing wrong"
    try:
        action()
    except InputError as refusal:
        said = str(refusal)
    assert len(said.splitlines()) == 1
    assert len(said) > 10


def packed(text: str) -> bytes:
    stream = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(SSP)) as old, zipfile.ZipFile(stream, "w") as new:
        for name in old.namelist():
            data = text.encode("utf-8", "surrogatepass") if name == "SystemStructure.ssd" else old.read(name)
            new.writestr(name, data)
    return stream.getvalue()


@st.composite
def mutated(draw: st.DrawFn, text: str) -> str:
    """Cut, replace or double pieces between the marks that XML is made of."""
    for _ in range(draw(st.integers(1, 4))):
        start = draw(st.integers(0, len(text) - 1))
        length = draw(st.integers(0, 40))
        piece = draw(st.one_of(st.sampled_from(FRAGMENTS), st.just(text[start : start + length] * 2)))
        text = text[:start] + piece + text[start + length :]
    return text


@st.composite
def mutated_values(draw: st.DrawFn, text: str) -> str:
    """Replace whole attribute values, so that the document stays well formed and the checks are reached."""
    parts = text.split('"')
    for _ in range(draw(st.integers(1, 3))):
        place = 2 * draw(st.integers(0, len(parts) // 2 - 1)) + 1
        known = st.sampled_from(parts[1::2])
        parts[place] = draw(
            st.one_of(known, st.sampled_from([f for f in FRAGMENTS if '"' not in f and "<" not in f]))
        )
    return '"'.join(parts)


def test_the_original_is_good() -> None:
    read(SSP)
    read(packed(SSD))


@QUICK
@given(st.data())
def test_flipped_bytes(data: st.DataObject) -> None:
    changed = bytearray(SSP)
    for _ in range(data.draw(st.integers(1, 6))):
        changed[data.draw(st.integers(0, len(SSP) - 1))] = data.draw(st.integers(0, 255))
    read(
        bytes(changed[: data.draw(st.integers(1, len(SSP)))]) if data.draw(st.booleans()) else bytes(changed)
    )


@QUICK
@given(mutated(SSD))
def test_mutated_text(text: str) -> None:
    read(packed(text))


@QUICK
@given(mutated_values(SSD))
def test_mutated_values(text: str) -> None:
    read(packed(text))


@QUICK
@given(
    st.one_of(
        *(
            f(t)
            for f in (mutated, mutated_values)
            for t in (fmi2("Link", LINK, structure=STRUCTURE), fmi2("M", MOTOR), FMI3)
        )
    )
)
def test_mutated_descriptions(text: str) -> None:
    one_sentence(
        lambda: parse_description(
            parse_xml(text.encode("utf-8", "surrogatepass"), "x.fmu"), Path("x.fmu"), "x.fmu"
        )
    )
