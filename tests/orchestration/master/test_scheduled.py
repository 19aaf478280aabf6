"""FMUs of FMI 3.0 for scheduled execution: the master ticks their periodic clocks and those of countdown."""

from __future__ import annotations

from pathlib import Path

import pytest

from warmlink.orchestration.master.run import simulate
from warmlink.orchestration.system.assemble import assemble
from warmlink.orchestration.system.description import read_description

from .hand_written import compiled

DESCRIPTION = """<fmiModelDescription fmiVersion="3.0" modelName="Clocked" instantiationToken="x">
<ScheduledExecution modelIdentifier="Clocked"/>
<ModelVariables>
<Clock name="beat" valueReference="1" causality="input" intervalVariability="constant" intervalDecimal="0.5"
 shiftDecimal="0.25" priority="1"/>
<Clock name="echo" valueReference="2" causality="input" intervalVariability="countdown" priority="2"/>
<Clock name="first" valueReference="3" causality="input" intervalVariability="calculated"
 shiftDecimal="0.25"/>
<Clock name="alarm" valueReference="4" causality="input" intervalVariability="triggered" priority="3"/>
<Float64 name="ticks" valueReference="10" causality="output" variability="discrete"/>
<Float64 name="late" valueReference="11" causality="output" variability="discrete"/>
<Float64 name="order" valueReference="12" causality="output" variability="discrete"/>
</ModelVariables>
<ModelStructure><Output valueReference="10" dependencies=""/><Output valueReference="11" dependencies=""/>
<Output valueReference="12" dependencies=""/></ModelStructure></fmiModelDescription>"""


@pytest.fixture(scope="module")
def clocked(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return compiled(tmp_path_factory.mktemp("clocked"), Path(__file__).with_name("clocked.c"), DESCRIPTION)


@pytest.mark.parametrize("step", [0.125, 0.25, 1.0])
def test_clocks_tick_at_their_times_whatever_the_step(clocked: Path, step: float) -> None:
    """At 0.25 s, 0.75 s ... before the end of a step; and 0.1 s after each third of these."""
    result = simulate(assemble("one", {"a": clocked}), 3.0, step)
    assert result.status == "completed", result.reason
    assert result["a.ticks"].tolist() == [sum(0.25 + 0.5 * n < t for n in range(10)) for t in result.times]
    assert result["a.late"][-1] == pytest.approx(2.85)
    assert result["a.order"][-1] == 0, "a clock of a lower priority came first"
    assert result.remarks == ("a.alarm: is a triggered clock, which nothing ticks here",)


def test_its_description_says_when_clocks_tick(clocked: Path) -> None:
    info = read_description(clocked)
    assert info.interface == "ScheduledExecution"
    beat = info.variables["beat"].clock
    assert beat is not None
    assert (beat.kind, beat.interval, beat.shift, beat.priority) == ("constant", 0.5, 0.25, 1)
    assert info.variables["ticks"].clock is None
