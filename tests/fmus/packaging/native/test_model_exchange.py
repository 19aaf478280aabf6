"""Model exchange: hosts that integrate get what co-simulation computes, in FMI 2.0 and 3.0."""

from __future__ import annotations

import ctypes
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from fmpy.fmi2 import FMU2Model
from fmpy.fmi3 import FMU3Model

from warmlink.fmus.catalogue import Entry, catalogue
from warmlink.fmus.component import Component
from warmlink.fmus.files import write_archive
from warmlink.fmus.packaging.native.compile import Compiler
from warmlink.fmus.packaging.native.fmu import FmiVersion, native_fmu_files
from warmlink.fmus.packaging.views import exchanged_states, opened
from warmlink.fmus.plant import plant
from warmlink.orchestration.check.fmu import validity_problems

from .conftest import BuildNative

CONTINUOUS = {e.component.name: opened(e.component) for e in catalogue() if exchanged_states(e.component)}
STARTS: dict[str, dict[str, float]] = {
    "Heater": {"on": 1.0, "heat_capacity": 50.0, "contact_resistance": 0.5},
    "MotorHeatSource": {"speed": 3.43, "torque": 2.5, "pad_mode": 2, "pad_temperature": 303.15},
    "Remainder": {"speed": 3.0, "temperature_weight[1]": 1.0, "elongation_weight[1]": 1e-6, "scale[1]": 3.0},
    "ThermalLink": {"heat_flow": 5.0, "speed": 3.0, "emissivity": 0.5},
}
every = pytest.mark.parametrize("name", CONTINUOUS)
both = pytest.mark.parametrize("version", ["2.0", "3.0"])


def test_the_continuous_components_offer_it() -> None:
    assert set(CONTINUOUS) == set(STARTS)


def disagreement(path: Path, component: Component, starts: dict[str, float]) -> dict[str, float]:
    """Largest difference of each output between CVODE and co-simulation, as a share of its largest value."""
    outputs = component.y.names[: component.output_count]
    common: dict[str, Any] = {"stop_time": 100.0, "output_interval": 0.05, "output": outputs}
    own = fmpy.simulate_fmu(str(path), fmi_type="CoSimulation", start_values=starts, **common)
    tight = {"solver": "CVode", "relative_tolerance": 1e-10}
    theirs = fmpy.simulate_fmu(str(path), fmi_type="ModelExchange", start_values=starts, **tight, **common)
    assert len(own) == len(theirs) == 2001
    assert np.ptp(own[outputs[0]]) > 0
    return {name: np.abs(own[name] - theirs[name]).max() / (np.abs(own[name]).max() or 1) for name in outputs}


@both
@every
def test_cvode_and_co_simulation_agree(name: str, version: FmiVersion, native_fmu: BuildNative) -> None:
    """To 1e-6 of each output's largest value; the estimate of an error, which is tiny, to 1e-3."""
    found = disagreement(native_fmu(name, version), CONTINUOUS[name], STARTS[name])
    assert found.pop("discretisation_error", 0.0) <= 1e-3
    assert max(found.values()) <= 1e-6, found


@both
def test_joined_plants_agree_too(version: FmiVersion, c_compiler: Compiler, tmp_path: Path) -> None:
    joined, path = plant(8), tmp_path / "Plant.fmu"
    write_archive(path, native_fmu_files(Entry(joined, "warmlink.fmus.plant"), version, [c_compiler]))
    assert validity_problems(path) == []
    starts = {"motor.speed": 3.43, "link.speed": 3.43, "motor.torque": 2.5}
    found = disagreement(path, joined, starts)
    assert found.pop("link.discretisation_error") <= 1e-3
    assert max(found.values()) <= 1e-6, found


@pytest.fixture(params=["2.0", "3.0"])
def model(request: pytest.FixtureRequest, native_fmu: BuildNative, tmp_path: Path) -> Iterator[Any]:
    """A motor that its host integrates, in continuous-time mode after 0 s."""
    path = str(native_fmu("MotorHeatSource", request.param))
    description = fmpy.read_model_description(path)
    kind = FMU2Model if request.param == "2.0" else FMU3Model
    instance = kind(
        guid=description.guid,
        unzipDirectory=fmpy.extract(path, str(tmp_path)),
        modelIdentifier=description.modelExchange.modelIdentifier,
        instanceName="motor",
    )
    instance.instantiate()
    if request.param == "2.0":
        instance.setupExperiment(startTime=0.0)
    instance.enterInitializationMode()
    instance.exitInitializationMode()
    yield instance
    instance.freeInstance()


MOTOR = CONTINUOUS["MotorHeatSource"]
COUNT = MOTOR.x.size


def vector(values: Any = None) -> Any:
    return (ctypes.c_double * COUNT)(*([] if values is None else values))


def rates(model: Any, states: Any = None) -> np.ndarray:
    found = vector()
    if states is not None:
        model.setContinuousStates(vector(states), COUNT)
    (model.getDerivatives if hasattr(model, "getDerivatives") else model.getContinuousStateDerivatives)(
        found, COUNT
    )
    return np.array(found)


def reference(component: Component, name: str) -> int:
    return next(s.reference for s in component.scalars() if s.name == name)


def new_states(model: Any) -> tuple[bool, ...]:
    answer = (
        model.newDiscreteStates if hasattr(model, "newDiscreteStates") else model.updateDiscreteStates
    )()
    return tuple(bool(each) for each in answer[:5])


def test_derivatives_by_states_are_those_of_the_rates(model: Any) -> None:
    states, own = exchanged_states(MOTOR), vector()
    assert new_states(model) == (False,) * 5
    model.enterContinuousTimeMode()
    model.getContinuousStates(own, COUNT)
    x = np.array(own) + np.array([30.0, 10.0, 0.0])
    model.setContinuousStates(vector(x), COUNT)
    heat_flow = reference(MOTOR, "heat_flow")
    for i, state in enumerate(states):
        unknowns = [*(s.rate.reference for s in states), heat_flow]
        derivative = model.getDirectionalDerivative(unknowns, [state.state.reference], [1.0])
        step = np.eye(COUNT)[i]
        slopes = (rates(model, x + step) - rates(model, x - step)) / 2
        np.testing.assert_allclose(derivative[:COUNT], slopes, rtol=1e-6, atol=1e-12)
    model.setContinuousStates(vector(x), COUNT)
    assert derivative[COUNT] == 0.0
    by_shaft = model.getDirectionalDerivative([heat_flow], [states[1].state.reference], [1.0])
    assert list(by_shaft) == [1.0]


def test_nominals_and_variables_are_the_states(model: Any) -> None:
    nominals, own = vector(), vector()
    model.getNominalsOfContinuousStates(nominals, COUNT)
    assert list(nominals) == [300.0, 300.0, 1e4]
    model.getContinuousStates(own, COUNT)
    states = exchanged_states(MOTOR)
    get = model.getFloat64 if hasattr(model, "getFloat64") else model.getReal
    assert get([s.state.reference for s in states]) == list(own)
    np.testing.assert_array_equal(get([s.rate.reference for s in states]), rates(model))


def test_nothing_happens_but_by_the_host(model: Any) -> None:
    """No event indicator, no event after a step; a mode jumps in event mode alone."""
    new_states(model)
    model.enterContinuousTimeMode()
    model.setTime(5.0)
    before = rates(model)
    assert [bool(each) for each in model.completedIntegratorStep()][:2] == [False, False]
    whole = model.setInt64 if hasattr(model, "setInt64") else model.setInteger
    pad = [reference(MOTOR, "pad_mode")]
    with pytest.raises(Exception, match="status 3"):
        whole(pad, [1])
    assert (rates(model) == before).all()
    model.enterEventMode()
    whole(pad, [1])
    (model.setFloat64 if hasattr(model, "setFloat64") else model.setReal)(
        [reference(MOTOR, "pad_power")], [15.0]
    )
    new_states(model)
    model.enterContinuousTimeMode()
    assert rates(model)[1] == pytest.approx(before[1] + 15.0 / 1500.0)
    with pytest.raises(Exception, match="status 2"):
        model.setContinuousStates(vector([np.nan] * COUNT), COUNT)
    assert np.isfinite(rates(model)).all()
    model.terminate()
