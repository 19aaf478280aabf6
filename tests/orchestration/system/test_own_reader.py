"""Damaged model descriptions: what our reader says and what FMPy's does (docs/decisions/own-reader.md)."""

from __future__ import annotations

from pathlib import Path

import pytest
from fmpy import read_model_description

from warmlink.fmus.errors import InputError
from warmlink.fmus.packaging.model_description import model_description
from warmlink.fmus.thermal_link.component import COMPONENT as LINK
from warmlink.orchestration.system.description import parse_description
from warmlink.orchestration.system.xml import parse_xml

SOUND = model_description(LINK).decode()
DAMAGED: tuple[tuple[str, str, str, type[Exception] | None], ...] = (
    ('start="0.3302"', 'start="abc"', "length: 'abc' is not a number", None),
    ('name="width"', 'name="length"', "declares the variable length twice", None),
    ('valueReference="3"', f'valueReference="{1 << 40}"', "is not between 0 and 4294967295", None),
    ("<fmiModel", '<!DOCTYPE a [<!ENTITY b "c">]><fmiModel', "declares a document type", None),
    ('dependencies="', 'dependencies="9999 ', "refers to variable 9999, which is not declared", IndexError),
    ('valueReference="3" ', "", "ScalarVariable lacks its attribute valueReference", TypeError),
)


@pytest.mark.parametrize(("sound", "damaged", "sentence", "fmpy_raises"), DAMAGED)
def test_ours_says_what_is_wrong_and_fmpys_accepts_it_or_stumbles(
    sound: str, damaged: str, sentence: str, fmpy_raises: type[Exception] | None, tmp_path: Path
) -> None:
    assert sound in SOUND
    path = tmp_path / "modelDescription.xml"
    path.write_text(SOUND.replace(sound, damaged, 1), encoding="utf-8")
    with pytest.raises(InputError, match=sentence):
        parse_description(parse_xml(path.read_bytes(), "x"), path, "x")
    if fmpy_raises is None:
        assert read_model_description(str(path), validate=False).modelName == LINK.name
    else:
        with pytest.raises(fmpy_raises):
            read_model_description(str(path), validate=False)
