"""FMUs for model exchange: against analytic solutions, FMPy's CVode and co-simulation by the same FMU."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fmpy import simulate_fmu

from warmlink.fmus.errors import InputError
from warmlink.orchestration.fmu_store import FmuStore
from warmlink.orchestration.master.algorithms.explicit import GaussSeidel
from warmlink.orchestration.master.algorithms.iterated import FixedPoint
from warmlink.orchestration.master.recording.checkpoint import LongRun
from warmlink.orchestration.master.recording.result import Result
from warmlink.orchestration.master.run import simulate
from warmlink.orchestration.master.slaves.isolation import Isolation
from warmlink.orchestration.system.assemble import assemble, connected, read_system
from warmlink.orchestration.system.described import described
from warmlink.orchestration.system.description import read_description
from warmlink.orchestration.system.model import FmuPart, Implementation, System, Value
from warmlink.orchestration.system.write import write_ssp

from .hand_written import compiled

NAMES = ("time", "h", "fall", "u", "count", "last", "flaw")
KINDS = {"h": "output", "count": "output", "u": "input", "last": "parameter", "flaw": "parameter"}
STARTS = {"u": "0", "last": "1e9", "flaw": "0"}


def description(version: str) -> str:
    """Model description of the model in `exchange.c`."""
    if version == "1.0":
        return description_of_fmi1()
    modern, variables = version == "3.0", []
    for i, name in enumerate(NAMES[1:], start=1):
        kind = KINDS.get(name, "local")
        start = f' start="{STARTS[name]}"' if name in STARTS else ""
        fixed = ' variability="fixed"' if kind == "parameter" else ""
        fixed = ' variability="discrete"' if name == "count" else fixed
        head = f'name="{name}" valueReference="{i}" causality="{kind}"{fixed}'
        variables.append(
            f"<Float64 {head}{start}/>"
            if modern
            else f"<ScalarVariable {head}><Real{start}/></ScalarVariable>"
        )
    for i, state in enumerate((1, 2), start=7):
        of = f'name="der{i}" valueReference="{i}"'
        number = f'derivative="{state}"'
        variables.append(
            f"<Float64 {of} {number}/>"
            if modern
            else f"<ScalarVariable {of}><Real {number}/></ScalarVariable>"
        )
    if modern:
        structure = "".join(f'<Output valueReference="{i}" dependencies=""/>' for i in (1, 4))
        structure += "".join(f'<ContinuousStateDerivative valueReference="{i}"/>' for i in (7, 8))
        structure += '<EventIndicator valueReference="1"/>'
    else:
        unknowns = "".join(f'<Unknown index="{i}" dependencies=""/>' for i in (1, 4))
        structure = f"<Outputs>{unknowns}</Outputs>"
        structure += '<Derivatives><Unknown index="7"/><Unknown index="8"/></Derivatives>'
    token = 'instantiationToken="x"' if modern else 'guid="x" numberOfEventIndicators="1"'
    state = "canGetAndSetFMUState" if modern else "canGetAndSetFMUstate"
    return (
        f'<fmiModelDescription fmiVersion="{version}" modelName="Exchange" {token}>'
        f'<ModelExchange modelIdentifier="Exchange" {state}="true"/>'
        f"<ModelVariables>{''.join(variables)}</ModelVariables>"
        f"<ModelStructure>{structure}</ModelStructure></fmiModelDescription>"
    )


def description_of_fmi1() -> str:
    variables = []
    for i, name in enumerate(NAMES[1:], start=1):
        kind = KINDS.get(name, "internal")
        start = f' start="{STARTS[name]}"' if name in STARTS else ""
        role = ' variability="parameter"' if kind == "parameter" else f' causality="{kind}"'
        role += ' variability="discrete"' if name == "count" else ""
        inner = "<DirectDependency/>" if kind == "output" else ""
        head = f'name="{name}" valueReference="{i}"{role}'
        variables.append(f"<ScalarVariable {head}><Real{start}/>{inner}</ScalarVariable>")
    counts = 'numberOfContinuousStates="2" numberOfEventIndicators="1"'
    return (
        f'<fmiModelDescription fmiVersion="1.0" modelName="x" modelIdentifier="Exchange" guid="x" {counts}>'
        f"<ModelVariables>{''.join(variables)}</ModelVariables></fmiModelDescription>"
    )


@pytest.fixture(scope="module", params=["1.0", "2.0", "3.0"])
def ball(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    source = Path(__file__).with_name("exchange.c")
    return compiled(tmp_path_factory.mktemp("exchange"), source, description(request.param))


def ran(fmu: Path, step: float = 0.125, stop: float = 1.5, by: Any = None, **values: Value) -> Result:
    given = {"a": values} if values else {}
    return simulate(assemble("one", {"a": fmu}, (), given), stop, step, by)


def height(time: float) -> float:
    """Height in m of a ball that falls from 1 m and bounces with half its speed."""
    fall = math.sqrt(2 / 9.81)
    if time <= fall:
        return 1 - 0.5 * 9.81 * time**2
    began, speed = fall, 0.5 * 9.81 * fall
    while time > began + 2 * speed / 9.81:
        began, speed = began + 2 * speed / 9.81, 0.5 * speed
    return speed * (time - began) - 0.5 * 9.81 * (time - began) ** 2


@pytest.mark.parametrize("step", [0.125, 0.01, 1.0])
def test_it_bounces_when_it_should(ball: Path, step: float) -> None:
    result = ran(ball, step, 1.0)  # where infinitely many bounces end at 1.35 s
    assert result.status == "completed", result.reason
    np.testing.assert_allclose(result["a.h"], [height(t) for t in result.times], rtol=0, atol=1e-12)


def test_it_is_what_cvode_gives(ball: Path) -> None:
    ours = ran(ball, 0.125, 1.0)
    theirs = simulate_fmu(
        str(ball),
        stop_time=1.0,
        output_interval=0.125,
        relative_tolerance=1e-10,
        record_events=False,
        validate=False,
    )
    np.testing.assert_allclose(ours["a.h"], theirs["h"], rtol=0, atol=1e-8)


def test_time_events_are_met_and_an_end_is_asked_for(ball: Path) -> None:
    ended = ran(ball, 0.25, 4.0, u=9.81, last=3.0)
    assert ended.status == "ended"
    assert "ended at 3 s: the model asks to end the simulation" in (ended.reason or "")
    assert ended["a.count"].tolist() == [0] * 4 + [1] * 4 + [2] * 4 + [3]
    across = ran(ball, 1.5, 3.0, u=9.81)
    assert across["a.count"].tolist() == [0, 1, 3]


def test_inputs_are_held_during_a_step(ball: Path) -> None:
    """One ball's height is the other's wind."""
    pair = assemble("pair", {"a": ball, "b": ball}, [("a.h", "b.u")], {"a": {"u": 9.81}})
    result = simulate(pair, 0.25, 0.25)
    assert result["b.h"][-1] == pytest.approx(1 - 0.5 * (9.81 - 1) * 0.25**2, abs=1e-12)


def test_steps_are_repeated_to_the_last_bit(ball: Path) -> None:
    pair = assemble("pair", {"a": ball, "b": ball}, [("a.h", "b.u"), ("b.h", "a.u")])
    once, again = (simulate(pair, 1.0, 0.125, FixedPoint()) for _ in range(2))
    assert once.status == "completed", once.reason
    np.testing.assert_array_equal(once["b.h"], again["b.h"])
    coarse = simulate(pair, 1.0, 0.125, GaussSeidel())
    assert 0 < abs(coarse["b.h"][-1] - once["b.h"][-1]) < 0.1


def test_isolated_it_is_the_same(tmp_path: Path) -> None:
    ball = compiled(tmp_path, Path(__file__).with_name("exchange.c"), description("2.0"))
    alone = simulate(assemble("one", {"a": ball}), 1.0, 0.125, isolation=Isolation())
    np.testing.assert_array_equal(alone["a.h"], ran(ball, 0.125, 1.0)["a.h"])


@pytest.mark.parametrize(
    ("flaw", "told"),
    [(1.0, "its discrete states do not agree in 1000 rounds"), (2.0, "more than 10000 events up to")],
)
def test_events_without_an_end_are_a_failure_in_a_sentence(ball: Path, flaw: float, told: str) -> None:
    from warmlink.orchestration.master.slaves import integration

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(integration, "MOST_EVENTS", 10)
        told = told.replace("10000", "10")
        found = ran(ball, 1000.0, 1000.0, u=9.81, flaw=flaw)
    assert told in (found.reason or "")
    assert found.status == "stopped"


STARTED: dict[str, dict[str, Value]] = {"motor": {"speed": 3.43, "torque": 2.5}, "link": {"speed": 3.43}}


def pair(motor: Implementation, link: Implementation) -> System:
    """A motor and its link, the model's own equations in either interface."""
    files = FmuStore("native").files(["MotorHeatSource", "ThermalLink"])
    parts = {
        "motor": FmuPart("motor", files["MotorHeatSource"], {}, dict(STARTED["motor"]), motor),
        "link": FmuPart("link", files["ThermalLink"], {}, dict(STARTED["link"]), link),
    }
    wires = [("motor.heat_flow", "link.heat_flow"), ("link.base_temperature", "motor.link_base_temperature")]
    return System("pair", parts, connected(parts, wires))


def test_another_interface_of_an_fmu_is_another_run(tmp_path: Path) -> None:
    long_run = LongRun(tmp_path, every=5, resume=True)
    simulate(pair("CoSimulation", "CoSimulation"), 1.0, 0.1, long_run=long_run)
    with pytest.raises(InputError, match="belongs to another run"):
        simulate(pair("CoSimulation", "ModelExchange"), 1.0, 0.1, long_run=long_run)


@pytest.mark.parametrize(
    "kinds",
    [("ModelExchange", "CoSimulation"), ("any", "ModelExchange"), ("ModelExchange", "ModelExchange")],
)
def test_a_mixed_system_is_the_co_simulated_one(kinds: tuple[Implementation, Implementation]) -> None:
    """To the error of the solver inside our co-simulation FMUs."""
    own, mixed = (simulate(pair(*each), 3.0, 0.05) for each in (("any", "any"), kinds))
    assert mixed.status == "completed", mixed.reason
    for name in ("link.elongation", "motor.shaft_temperature", "motor.heat_flow"):
        size = np.ptp(own[name])
        np.testing.assert_allclose(mixed[name], own[name], rtol=0, atol=1e-4 * size)


def test_an_ssp_says_which_interface(tmp_path: Path) -> None:
    write_ssp(pair("ModelExchange", "any"), tmp_path / "pair.ssp")
    read = read_system(tmp_path / "pair.ssp", tmp_path / "work")
    assert [each.implementation for each in read.components.values()] == ["ModelExchange", "any"]
    assert described(read.components["motor"]).interface == "ModelExchange"
    np.testing.assert_array_equal(
        simulate(read, 10.0, 1.0)["link.elongation"],
        simulate(pair("ModelExchange", "any"), 10.0, 1.0)["link.elongation"],
    )


def test_an_interface_that_is_not_offered_is_refused(ball: Path) -> None:
    assert read_description(ball).used_as("any").interface == "ModelExchange"
    with pytest.raises(InputError, match=r"Exchange\.fmu: offers ModelExchange, not CoSimulation"):
        read_description(ball).used_as("CoSimulation")
    heat = FmuStore("native").files(["DutyCycle"])["DutyCycle"]
    with pytest.raises(InputError, match="offers CoSimulation, not ModelExchange; export the model for it"):
        read_description(heat).used_as("ModelExchange")
