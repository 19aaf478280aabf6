"""FMUs of FMI 1.0 for co-simulation, against FMPy."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from fmpy import simulate_fmu

from warmlink.orchestration.master.recording.result import Result
from warmlink.orchestration.master.run import simulate
from warmlink.orchestration.master.slaves.isolation import Isolation
from warmlink.orchestration.system.assemble import assemble, read_system
from warmlink.orchestration.system.description import read_description
from warmlink.orchestration.system.model import System
from warmlink.orchestration.system.write import write_ssp

from .hand_written import compiled

DESCRIPTION = """<fmiModelDescription fmiVersion="1.0" modelName="First" modelIdentifier="First" guid="first"
 numberOfContinuousStates="1" numberOfEventIndicators="0">
<UnitDefinitions><BaseUnit unit="m"/></UnitDefinitions>
<TypeDefinitions><Type name="Length"><RealType unit="m" nominal="2"/></Type></TypeDefinitions>
<DefaultExperiment startTime="0" stopTime="1"/>
<ModelVariables>
<ScalarVariable name="k" valueReference="0" variability="parameter"><Real start="2"/></ScalarVariable>
<ScalarVariable name="u" valueReference="1" causality="input"><Real start="0"/></ScalarVariable>
<ScalarVariable name="y" valueReference="2" causality="output"><Real declaredType="Length"/>
<DirectDependency/></ScalarVariable>
<ScalarVariable name="minus_y" valueReference="2" causality="output" alias="negatedAlias"><Real/>
<DirectDependency/></ScalarVariable>
<ScalarVariable name="most" valueReference="3" variability="parameter"><Real start="1e300"/></ScalarVariable>
<ScalarVariable name="steps" valueReference="0" variability="discrete" causality="output"><Integer/>
</ScalarVariable>
<ScalarVariable name="large" valueReference="0" variability="discrete" causality="output"><Boolean/>
</ScalarVariable>
<ScalarVariable name="text" valueReference="0" variability="discrete"><String/></ScalarVariable>
<ScalarVariable name="inner" valueReference="1"><Real/></ScalarVariable>
<ScalarVariable name="inner" valueReference="2"><Real/></ScalarVariable>
</ModelVariables>
<Implementation><CoSimulation_StandAlone>
<Capabilities canHandleVariableCommunicationStepSize="true" canInterpolateInputs="true"/>
</CoSimulation_StandAlone></Implementation></fmiModelDescription>"""


@pytest.fixture(scope="module")
def first(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return compiled(tmp_path_factory.mktemp("first"), Path(__file__).with_name("first.c"), DESCRIPTION)


def chain(fmu: Path) -> System:
    """Two in a row, the first with an input that does not change."""
    return assemble("chain", {"a": fmu, "b": fmu}, [("a.y", "b.u")], {"a": {"u": 3.0, "k": 0.5}})


def ran(system: System, form: str) -> Result:
    if form == "isolated":
        return simulate(system, 1.0, 0.1, isolation=Isolation())
    return simulate(system, 1.0, 0.1, stepping="preferred" if form == "preferred" else "plain")


@pytest.mark.parametrize("form", ["plain", "preferred", "isolated"])
def test_a_chain_follows_what_both_equations_give(first: Path, form: str) -> None:
    result = ran(chain(first), form)
    assert result.status == "completed", result.reason
    times = np.arange(11) * 0.1
    np.testing.assert_allclose(result["a.y"], 1.5 * times, rtol=0, atol=1e-12)
    np.testing.assert_allclose(result["b.y"], [0.2 * sum(1.5 * times[:n]) for n in range(11)], atol=1e-12)
    np.testing.assert_array_equal(result["a.minus_y"], -result["a.y"])
    assert result["a.steps"].tolist() == list(range(11))
    assert result["a.large"].tolist() == [1] * 11


def test_it_is_what_fmpy_gives(first: Path) -> None:
    ours = simulate(assemble("one", {"a": first}, (), {"a": {"u": 3.0}}), 1.0, 0.125)
    theirs = simulate_fmu(
        str(first),
        stop_time=1.0,
        step_size=0.125,
        output_interval=0.125,
        start_values={"u": 3.0},
        validate=False,
    )
    np.testing.assert_array_equal(ours["a.y"], theirs["y"])
    np.testing.assert_array_equal(ours["a.steps"], theirs["steps"])


def test_a_negated_alias_is_set_as_what_it_stands_for(first: Path) -> None:
    found = simulate(
        assemble("two", {"a": first, "b": first}, [("a.minus_y", "b.u")], {"a": {"u": 1.0}}), 1.0, 0.1
    )
    assert found["b.y"][-1] == pytest.approx(-np.sum(0.2 * 0.2 * np.arange(10)))


def test_units_types_and_what_is_declared_twice_are_read(first: Path) -> None:
    info = read_description(first)
    assert (info.fmi_version, info.interface, info.capabilities.variable_step) == (
        "1.0",
        "CoSimulation",
        True,
    )
    assert (info.variables["y"].unit, info.variables["y"].nominal) == ("m", 2.0)
    assert not info.feedthrough("y")
    assert info.feedthrough("steps") == {"u"}
    assert any("declares the variable inner twice" in told for told in info.remarks)
    assert info.variables["inner"].value_reference == 1
    assert not info.capabilities.interpolate_inputs


def test_an_ssp_of_it_is_written_and_read_again(first: Path, tmp_path: Path) -> None:
    write_ssp(chain(first), tmp_path / "chain.ssp")
    again = read_system(tmp_path / "chain.ssp", tmp_path / "read")
    np.testing.assert_array_equal(ran(again, "plain")["b.y"], ran(chain(first), "plain")["b.y"])


def test_a_refused_step_ends_the_run_with_what_it_logged(first: Path) -> None:
    result = simulate(assemble("one", {"a": first}, (), {"a": {"most": 0.55}}), 1.0, 0.1)
    assert result.status == "stopped"
    assert "error at 0.5 s: fmi1DoStep answered error; it logged: no step beyond 0.55 s" in (
        result.reason or ""
    )
    assert len(result.table) == 6
