"""A law as Structured Text: declared, commented, importable, and the numbers of its C."""

import os
import re
from functools import cache
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np
import pandas
import pytest
from lxml import etree

import warmlink as wl
from tests.controllers.export.iec import MISSING, hours, of_c, of_structured_text, run, translated
from warmlink.controllers.export.core import Core, Precision, designed
from warmlink.controllers.export.plcopen import NAMESPACE, plcopen_xml
from warmlink.controllers.export.program.places import RESERVED
from warmlink.controllers.export.st_blocks import Blocks, blocks, structured_text
from warmlink.controllers.own import Law, component_of
from warmlink.controllers.start_values import by_scalar
from warmlink.fmus.component import Parameter, State
from warmlink.fmus.component.arithmetic import exp, finite, sqrt, stack, where
from warmlink.fmus.errors import InputError
from warmlink.orchestration.catalogue import controllers
from warmlink.orchestration.replay.learn import learnt_law

LAWS = sorted(name for name, component in controllers().items() if component.states)

with_matiec = pytest.mark.skipif(MISSING is not None, reason=str(MISSING))
"""Of tests that translate; the others read the text."""


class Settling(Law):
    """Growth that settles while it is hot."""

    parameters = (Parameter("gain", "m/K", 4e-6, "growth per kelvin"), Parameter("lag", "s", 90.0, "time"))
    states = (State("mean", "K"), State("worst", "K", size=2))

    def begin(self, u: Any, p: Any) -> dict[str, Any]:
        """Start values of the states by name."""
        first = where(finite(u.tip_temperature), u.tip_temperature, 295.15)
        return {"mean": first, "worst": stack(first, 0.0)}

    def update(self, x: Any, u: Any, p: Any, time: Any, step: Any) -> dict[str, Any]:
        """The states after a sample."""
        good = finite(u.tip_temperature)
        share = 1.0 - exp(-step / p.lag)
        mean = where(good, x.mean + share * (u.tip_temperature - x.mean), x.mean)
        return {"mean": mean, "worst": where(x.worst > mean, x.worst, mean)}

    def correction(self, x: Any, u: Any, p: Any, time: Any) -> Any:
        """The correction in m."""
        return p.gain * sqrt((x.mean - 295.15) ** 2 + 1e-3 * time / (time + p.lag))


@cache
def practice_log() -> pandas.DataFrame:
    """Two hours of a machine that the model does not fit."""
    return wl.hide(["radiation"], seed=3)


def exported(law: str, precision: Precision = "double") -> Core:
    name, _, learnt = law.partition(" ")
    component = component_of(Settling) if name == "Settling" else controllers()[name]
    if learnt:
        component = designed(component, by_scalar(learnt_law([practice_log()], name).values))
    return Core(component, law.replace(" ", "_"), precision)


def _slow(law: str) -> Any:
    """Observers are marked: their translation takes its time."""
    return pytest.param(law, marks=pytest.mark.slow) if law.startswith("observer") else law


LEARNT = [f"{law} learnt" for law in ("regression", "observer", "observer_drift")]


@pytest.fixture(scope="module", params=[*map(_slow, LAWS), "Settling", *map(_slow, LEARNT)])
def core(request: pytest.FixtureRequest) -> Core:
    return exported(request.param)


@pytest.fixture(scope="module")
def made(core: Core) -> Blocks:
    return blocks(core)


_WORD = re.compile(r"(?<![\w.])[A-Za-z]\w*")
_SAID = """if then else elsif end_if for to do end_for not and or sel abs exp ln sqrt sin cos expt true false
int_to_lreal lint_to_lreal lreal_to_lint"""
"""Words of the language, and functions of its standard, that a law may use."""


def test_every_name_is_declared_once_and_is_no_word_of_the_language(made: Blocks) -> None:
    types = {name for name, _, _ in made.arrays} | {made.state[0], "BOOL", "INT", "LINT", "REAL", "LREAL"}
    functions: set[str] = set()
    for unit in made.units:
        variables = [each for section in unit.sections.values() for each in section]
        names = [each.name.lower() for each in variables]
        assert len(names) == len(set(names)), unit.name
        assert not RESERVED & ({*names} - {"i", "j", "k", "side"}), unit.name
        assert all(each.type in types or each.type.startswith("ARRAY [0..") for each in variables), unit.name
        text = re.sub(r"\b\d[\d.]*(E-?\d+)?", "0", "\n".join(unit.body))
        arguments = {word.lower() for word in re.findall(r"[(,]\s*(\w+) :=", text)}
        known = {*names, *_SAID.split(), *functions, *arguments, unit.name.lower()}
        assert {word.lower() for word in _WORD.findall(text)} <= known, unit.name
        (functions if unit.head == "FUNCTION" else types).add(
            unit.name.lower() if unit.returns else unit.name
        )


def test_constants_stand_in_one_block_with_units_in_comments(core: Core, made: Blocks) -> None:
    with_constants = [unit.name for unit in made.units if unit.sections.get("VAR CONSTANT")]
    assert with_constants == [core.name]
    parameters = {variable.name: variable.unit for variable in core.component.parameters}
    told = {each.name: each.told for each in made.units[-1].sections["VAR CONSTANT"]}
    assert {*told} & {*parameters}
    for name in {*told} & {*parameters}:
        assert told[name].startswith(f"{parameters[name]}: "), name
    text = structured_text(core)
    assert max(map(len, text.splitlines())) <= 110
    assert re.search(r"SHA-256 [0-9a-f]{16}", text)


def test_what_a_restart_needs_is_retained(core: Core, made: Blocks) -> None:
    retained = [each.name for each in made.units[-1].sections["VAR RETAIN"]]
    assert retained == (["retained"] if core.goes_on else [])


def test_the_xml_holds_the_same_units(core: Core, made: Blocks) -> None:
    root = ET.fromstring(plcopen_xml(core))
    space = {"p": NAMESPACE, "h": "http://www.w3.org/1999/xhtml"}
    units = root.findall("p:types/p:pous/p:pou", space)
    assert [each.get("name") for each in units] == [unit.name for unit in made.units]
    for each, unit in zip(units, made.units, strict=True):
        assert each.findtext("p:body/p:ST/h:xhtml", namespaces=space) == "\n".join(unit.body)
        names = [variable.get("name") for variable in each.findall("p:interface/*/p:variable", space)]
        assert names == [variable.name for section in unit.sections.values() for variable in section]


SCHEMA = os.environ.get("WARMLINK_TC6", "")
"""The schema of PLCopen's TC6, `tc6_xml_v201.xsd`, which Beremiz and others hold."""


@pytest.mark.platform
@pytest.mark.skipif(not SCHEMA, reason="the schema of PLCopen is not there: give its file as WARMLINK_TC6")
@pytest.mark.parametrize("precision", ["double", "single"])
def test_the_xml_is_valid_by_the_schema_of_plcopen(core: Core, precision: Precision) -> None:
    schema = etree.XMLSchema(etree.parse(SCHEMA))
    text = plcopen_xml(Core(core.component, core.name, precision))
    assert schema.validate(etree.fromstring(text.encode())), schema.error_log


def test_another_design_is_another_hash() -> None:
    one, other = controllers()["lag"], designed(controllers()["lag"], {"time_constant": 500.0})
    assert Core(one, "lag", "double").origin() != Core(other, "lag", "double").origin()


def test_a_law_that_decides_with_if_is_refused_in_a_sentence() -> None:
    class Deciding(Settling):
        """Growth by an if."""

        def correction(self, x: Any, u: Any, p: Any, time: Any) -> Any:
            return p.gain if x.mean > 300.0 else 0.0

    with pytest.raises(InputError, match="decides with where"):
        structured_text(Core(component_of(Deciding), "deciding", "double"))


@pytest.mark.platform
@with_matiec
@pytest.mark.parametrize("precision", ["double", "single"])
def test_matiec_translates_it_without_a_word(core: Core, precision: Precision, tmp_path: Path) -> None:
    assert translated(Core(core.component, core.name, precision), tmp_path) == ""


@pytest.mark.platform
@with_matiec
def test_matiec_translates_the_program_that_the_docs_show(tmp_path: Path) -> None:
    page = (Path(__file__).parents[3] / "docs" / "plc.md").read_text("utf-8")
    (program,) = re.findall(r"^PROGRAM .*?^END_PROGRAM\n", page, re.MULTILINE | re.DOTALL)
    assert translated(exported("regression"), tmp_path, program) == ""


RESTARTS = {0.25: 30.0, 0.5: 600.0, 0.75: 20000.0}
"""Share of the time after which the controller was off, and for how many s."""


@pytest.mark.platform
@with_matiec
@pytest.mark.parametrize("count", [3600, pytest.param(86400, marks=pytest.mark.slow)])
def test_it_gives_the_numbers_of_the_c(core: Core, count: int, tmp_path: Path) -> None:
    """Bit for bit, restarts, drop-outs and faults too; but `analytic` needs erf, which the standard lacks."""
    rows, size = hours(tuple(core.component.u.names), count), core.component.y.size
    restarts = {int(share * count): passed for share, passed in RESTARTS.items()}
    libraries = of_structured_text(core, tmp_path), of_c(core, tmp_path)
    st, c = (run(each, rows, size, restarts) for each in libraries)
    place = core.component.y.index["correction"]
    assert np.abs(c[:, place]).max() > 1e-5
    if core.name == "analytic":
        np.testing.assert_allclose(st, c, rtol=1e-9, atol=1e-18)
        return
    np.testing.assert_array_equal(st, c)
    if core.goes_on:
        first = int(0.25 * count)
        assert abs(st[first, place] - st[first - 1, place]) < 1e-9, "a restart makes no leap"


@pytest.mark.platform
@with_matiec
@pytest.mark.parametrize("count", [3600, pytest.param(86400, marks=pytest.mark.slow)])
def test_single_precision_loses_less_than_a_tenth_of_a_micrometre(
    core: Core, count: int, tmp_path: Path
) -> None:
    """An observer took a thermometer back a sample earlier, and was off by 0.21 um."""
    rows, size = hours(tuple(core.component.u.names), count), core.component.y.size
    single, double = tmp_path / "single", tmp_path / "double"
    for folder in (single, double):
        folder.mkdir()
    restarts = {int(share * count): passed for share, passed in RESTARTS.items()}
    real = run(of_structured_text(Core(core.component, core.name, "single"), single), rows, size, restarts)
    lreal = run(of_c(core, double), rows, size, restarts)
    place = core.component.y.index["correction"]
    assert np.abs(real[:, place] - lreal[:, place]).max() < 0.1e-6
    if core.goes_on:
        first = int(0.25 * count)
        assert abs(real[first, place] - real[first - 1, place]) < 1e-9, "a restart makes no leap"


def test_the_clock_counts_samples_as_that_of_the_c_does() -> None:
    """In REAL a clock to which 0.1 s are added stands still after 24 days, and is off by percents before."""
    component = component_of(Settling)
    core = Core(designed(component, {"sample_time": 0.1}), "settling", "single")
    law = blocks(core).units[-1]
    assert [line.strip() for line in law.body if "elapsed :=" in line and "run_" not in line] == [
        "elapsed := LINT_TO_REAL(samples) * 0.1;"
    ]
    assert [line.strip() for line in law.body if line.strip().startswith("samples :=")] == [
        "samples := samples + 1;"
    ]
    assert ("samples", "LINT") in [(each.name, each.type) for each in law.sections["VAR"]]
