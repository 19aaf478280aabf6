"""What a ModelStructure tells of outputs and of the size of a model's equations, in each version of FMI."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
from lxml import etree

from warmlink.fmus.errors import InputError
from warmlink.orchestration.system.model import FmuVariable
from warmlink.orchestration.system.model_structure import outputs_of, sizes_of

NAMES = {1: ("x",), 2: ("y[1]", "y[2]"), 3: ("u",)}


def root(text: str) -> Any:
    return etree.fromstring(f"<fmiModelDescription>{text}</fmiModelDescription>")


def structure(inside: str, more: str = "") -> Any:
    return root(f"<ModelStructure>{inside}</ModelStructure>{more}")


def test_dependencies_are_names_none_where_none_are_declared_and_empty_where_there_are_none() -> None:
    told = '<Output valueReference="2" dependencies="1 3"/><Output valueReference="1" dependencies=""/>'
    found = outputs_of(structure(told + '<Output valueReference="3"/>'), 3, NAMES, "m")
    assert found == {"y[1]": ("x", "u"), "y[2]": ("x", "u"), "x": (), "u": None}
    second = '<Outputs><Unknown index="1" dependencies="3"/></Outputs>'
    assert outputs_of(structure(second), 2, NAMES, "m") == {"x": ("u",)}
    assert outputs_of(structure(second), 3, NAMES, "m") == {}


@pytest.mark.parametrize("told", ['valueReference="9"', 'valueReference="1" dependencies="3 9"'])
def test_what_is_not_declared_is_refused(told: str) -> None:
    with pytest.raises(InputError, match="m: ModelStructure refers to variable 9, which is not declared"):
        outputs_of(structure(f"<Output {told}/>"), 3, NAMES, "m")


def test_states_and_indicators_are_counted_as_each_version_says_them(variable: FmuVariable) -> None:
    variables = {"x": variable, "y[1]": variable, "y[2]": variable, "u": replace(variable, dimensions=(2, 3))}
    third = "".join(f'<ContinuousStateDerivative valueReference="{k}"/>' for k in (2, 3))
    third += '<EventIndicator valueReference="1"/>'
    assert sizes_of(structure(third), 3, NAMES, variables, "m") == (8, 1)
    second = structure('<Derivatives><Unknown index="1"/><Unknown index="2"/></Derivatives>')
    assert sizes_of(second, 2, NAMES, variables, "m") == (2, 0)
    second.set("numberOfEventIndicators", "4")
    assert sizes_of(second, 2, NAMES, variables, "m") == (2, 4)
    first = root("")
    first.set("numberOfContinuousStates", "5")
    assert sizes_of(first, 1, NAMES, variables, "m") == (5, 0)


@pytest.fixture
def variable() -> FmuVariable:
    """A continuous number."""
    return FmuVariable("x", 1, "Real", "Real", "local", "continuous")
