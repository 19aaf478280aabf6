"""FMI 3.0 slaves with event mode: early return, events that are foretold, discrete inputs; against FMPy."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from fmpy import simulate_fmu

from warmlink.orchestration.master.run import simulate
from warmlink.orchestration.system.assemble import assemble
from warmlink.orchestration.system.description import read_description
from warmlink.orchestration.system.model import Value

from .hand_written import compiled

DESCRIPTION = """<fmiModelDescription fmiVersion="3.0" modelName="Eventful" instantiationToken="x">
<CoSimulation modelIdentifier="Eventful" hasEventMode="true" mightReturnEarlyFromDoStep="true"
 canHandleVariableCommunicationStepSize="true"/>
<ModelVariables>
<Float64 name="level" valueReference="0" causality="output"/>
<Float64 name="slope" valueReference="1" causality="input" variability="discrete" start="1"/>
<Float64 name="rounds" valueReference="2" causality="output" variability="discrete"/>
<Float64 name="foretells" valueReference="3" causality="parameter" variability="fixed" start="0"/>
</ModelVariables>
<ModelStructure><Output valueReference="0" dependencies=""/><Output valueReference="2" dependencies=""/>
</ModelStructure></fmiModelDescription>"""


@pytest.fixture(scope="module")
def eventful(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("eventful")
    return compiled(folder, Path(__file__).with_name("eventful.c"), DESCRIPTION)


def level(time: float, slope: float = 1.0) -> float:
    """Level after it rose and was halved at each whole second, after that of the time itself."""
    held = 0.0
    for _ in range(int(time + 1e-9)):
        held = 0.5 * (held + slope)
    return held + slope * (time - int(time + 1e-9))


@pytest.mark.parametrize("foretells", [0.0, 1.0])
@pytest.mark.parametrize("step", [0.25, 1.0, 2.5])
def test_events_come_at_their_time_whatever_the_step(eventful: Path, step: float, foretells: float) -> None:
    values: dict[str, dict[str, Value]] = {"a": {"slope": 2.0, "foretells": foretells}}
    result = simulate(assemble("one", {"a": eventful}, (), values), 5.0, step)
    assert result.status == "completed", result.reason
    np.testing.assert_allclose(result["a.level"], [level(t, 2.0) for t in result.times], rtol=1e-12)
    assert result["a.rounds"].tolist() == [int(t + 1e-9) for t in result.times]


def test_it_is_what_fmpy_gives(eventful: Path) -> None:
    ours = simulate(assemble("one", {"a": eventful}), 5.0, 0.25)
    options = {"use_event_mode": True, "early_return_allowed": True, "record_events": False}
    theirs = simulate_fmu(
        str(eventful), stop_time=5.0, step_size=0.25, output_interval=0.25, validate=False, **options
    )
    rows = [np.flatnonzero(np.abs(theirs["time"] - t) < 1e-9)[-1] for t in ours.times]
    np.testing.assert_array_equal(ours["a.level"], theirs["level"][rows])


def test_discrete_inputs_are_set_between_steps(eventful: Path) -> None:
    """The second one's slope is the first one's count, which changes at whole seconds."""
    pair = assemble("pair", {"a": eventful, "b": eventful}, [("a.rounds", "b.slope")])
    result = simulate(pair, 2.0, 0.5, stepping="preferred")
    assert result.status == "completed", result.reason
    assert result["b.level"].tolist() == [0.0, 0.0, 0.0, 0.5, 0.5]


def test_info_says_so(eventful: Path) -> None:
    assert read_description(eventful).capabilities.event_mode
