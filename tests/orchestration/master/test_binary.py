"""Binary and String variables of FMI 3.0 are set, passed along, to other processes too, and written."""

from __future__ import annotations

from pathlib import Path

import pytest

from warmlink.fmus.errors import InputError
from warmlink.orchestration.master.algorithms.explicit import GaussSeidel
from warmlink.orchestration.master.run import simulate
from warmlink.orchestration.master.slaves.isolation import Isolation
from warmlink.orchestration.system.assemble import assemble, read_system
from warmlink.orchestration.system.model import System
from warmlink.orchestration.system.write import write_ssp

from .hand_written import compiled

DESCRIPTION = """<fmiModelDescription fmiVersion="3.0" modelName="Blob" instantiationToken="x">
<CoSimulation modelIdentifier="Blob" canHandleVariableCommunicationStepSize="true"/>
<ModelVariables>
<Binary name="bytes" valueReference="0" causality="input"/>
<Binary name="backwards" valueReference="1" causality="output"/>
<String name="text" valueReference="2" causality="input"><Start value=""/></String>
<String name="twice" valueReference="3" causality="output"/>
<Int64 name="words" valueReference="4" causality="output"/>
</ModelVariables>
<ModelStructure><Output valueReference="1" dependencies=""/><Output valueReference="3" dependencies=""/>
<Output valueReference="4" dependencies=""/></ModelStructure></fmiModelDescription>"""


@pytest.fixture(scope="module")
def chain(tmp_path_factory: pytest.TempPathFactory) -> System:
    blob = compiled(tmp_path_factory.mktemp("blob"), Path(__file__).with_name("blob.c"), DESCRIPTION)
    wires = [("a.backwards", "b.bytes"), ("a.twice", "b.text")]
    return assemble("chain", {"a": blob, "b": blob}, wires, {"a": {"bytes": "00ff10", "text": "ab"}})


@pytest.mark.parametrize("form", ["plain", "preferred", "isolated", "written"])
def test_bytes_and_texts_are_passed_along(chain: System, tmp_path: Path, form: str) -> None:
    """Three bytes, of which the first is 0 in the end, and four times two letters."""
    if form == "written":
        write_ssp(chain, tmp_path / "chain.ssp", version="2.0")
        chain = read_system(tmp_path / "chain.ssp", tmp_path / "work")
    isolation = Isolation() if form == "isolated" else None
    stepping = {"preferred": "preferred"}.get(form, "auto")
    run = simulate(chain, 2.0, 1.0, GaussSeidel(), isolation=isolation, stepping=stepping)
    assert run.status == "completed", run.reason
    assert run["a.words"][-1] == 100_000 * 4 + 1000 * 3 + 0x10
    assert run["b.words"][-1] == 100_000 * 8 + 1000 * 3 + 0x00


def test_what_is_no_row_of_bytes_is_refused(chain: System) -> None:
    fmu = chain.components["a"].fmu
    with pytest.raises(
        InputError, match=r"a\.bytes: '0f1' is not hexadecimal; give two digits for each byte"
    ):
        assemble("one", {"a": fmu}, (), {"a": {"bytes": "0f1"}})
