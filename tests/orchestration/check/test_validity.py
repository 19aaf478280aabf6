"""An FMU's problems are those that FMPy finds, also where its grammar of names is not asked."""

from __future__ import annotations

import string
from itertools import chain, product
from pathlib import Path
from types import SimpleNamespace

import pytest
from fmpy import validation

from warmlink.fmus.files import write_archive
from warmlink.orchestration.check.fmu import PLAIN_NAME, validity_problems

FORMS = [
    "speed",
    "_x1",
    "link.sensor_temperature[8]",
    "a.b[1,20].c",
    "der(speed)",
    "der(a.b[1,2].c[3])",
    "der(a,2)",
]


def illegal(names: list[str]) -> list[str]:
    """What FMPy's grammar of structured names has against some."""
    variables = [SimpleNamespace(name=name, sourceline=0) for name in names]
    description = SimpleNamespace(variableNamingConvention="structured", modelVariables=variables)
    problems: list[str] = validation._validate_variable_names(description)
    return problems


def test_every_form_and_every_character_of_a_plain_name_is_legal() -> None:
    names = [*FORMS, *(f"_{each}" for each in string.ascii_letters + string.digits)]
    assert [name for name in names if not PLAIN_NAME.fullmatch(name)] == []
    assert illegal(names) == []


def test_every_plain_name_of_few_parts_is_legal() -> None:
    parts = ["a", "2", "[3,4]", ".", "der(", ",", ")"]
    sequences = (product(parts, repeat=length) for length in range(1, 6))
    plain = [name for name in map("".join, chain(*sequences)) if PLAIN_NAME.fullmatch(name)]
    assert {"a2.a[3,4]", "der(a.a)", "der(a,2)"} <= set(plain)
    assert illegal(plain) == []


@pytest.mark.parametrize(
    "name", ["a b", "1a", "a[", "a[1]b", "a.", "", "der(a", "der(a,b)", "a\n", "é", "a[¹]"]
)
def test_a_name_that_is_not_plain_is_left_to_the_grammar(name: str) -> None:
    assert illegal([name])
    assert not PLAIN_NAME.fullmatch(name)


def fmu(path: Path, name: str, convention: str = "structured", file: str = "a/b") -> Path:
    text = f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="M" guid="1" variableNamingConvention="{convention}">
<CoSimulation modelIdentifier="M"/>
<ModelVariables><ScalarVariable name="{name}" valueReference="0" causality="output"
initial="calculated"><Real/></ScalarVariable></ModelVariables>
<ModelStructure><Outputs><Unknown index="1"/></Outputs><InitialUnknowns><Unknown index="1"/></InitialUnknowns>
</ModelStructure></fmiModelDescription>"""
    write_archive(path, {"modelDescription.xml": text.encode(), file: b""})
    return path


@pytest.mark.parametrize(
    ("name", "convention", "problem"),
    [
        ("a.b[1]", "structured", None),
        ("'a b'.c", "structured", None),
        ("a b", "structured", "is not a legal variable name"),
        ("a b", "flat", None),
    ],
)
def test_an_fmu_has_the_problems_that_fmpy_finds(
    name: str, convention: str, problem: str | None, tmp_path: Path
) -> None:
    path = fmu(tmp_path / "M.fmu", name, convention)
    found = validity_problems(path)
    assert found == validation.validate_fmu(str(path))
    assert [problem in each for each in found if problem] == [True] * bool(problem)
    assert bool(found) == bool(problem)


def test_a_backslash_is_a_problem_still(tmp_path: Path) -> None:
    assert "backslash" in validity_problems(fmu(tmp_path / "M.fmu", "a", file="a\\b"))[0]
