"""FMUs of FMI 3.0 with arrays: the same bits as with scalars, and as many values as there are elements."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from fmpy.fmi3 import FMU3Slave

from warmlink.fmus.catalogue import catalogue
from warmlink.fmus.files import write_archive
from warmlink.fmus.packaging.native.compile import Compiler
from warmlink.fmus.packaging.native.fmu import native_fmu_files
from warmlink.orchestration.check.fmu import check_fmu, validity_problems
from warmlink.orchestration.fmu_store import FmuStore
from warmlink.orchestration.machine.shipped import WARMUP_CELL
from warmlink.orchestration.master.algorithms.explicit import GaussSeidel
from warmlink.orchestration.master.run import simulate

from .conftest import BuildNative

ENTRIES = {entry.component.name: entry for entry in catalogue()}
SENSORS, DUTY, LAW = "TemperatureSensors", "DutyCycle", "RegressionCompensator"
EIGHT = np.arange(8.0)
STARTS: Mapping[str, Mapping[str, Any]] = {
    SENSORS: {
        "noise": [0.1] * 8,
        "fault_kind": [0, 1, 2, 3, 4, 3, 2, 1],
        "fault_size": 0.5 * EIGHT,
        "fault_rate": 1e-3 * EIGHT,
        "temperature": 300.0 + EIGHT,
    },
    DUTY: {"segment_speed": 0.1 * np.arange(32.0), "duration": [5.0] * 32, "segment_pad_mode": [0, 2] * 16},
    LAW: {
        "shaft_temperature": 310.0,
        "base_temperature": 305.0,
        "sensor_std": 0.1 * (1 + np.arange(5.0)),
        "moments": [2.0 * (s.start or 0.0) for s in ENTRIES[LAW].component.scalars() if "moments" in s.name],
    },
}


@pytest.fixture(scope="module")
def arrays(c_compiler: Compiler, tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Path]:
    """Function of a component's name that gives its FMU with arrays."""
    folder = tmp_path_factory.mktemp("arrays")

    def build(name: str) -> Path:
        path = folder / f"{name}.fmu"
        if not path.is_file():
            write_archive(path, native_fmu_files(ENTRIES[name], "3.0", [c_compiler], arrays=True))
        return path

    return build


@pytest.mark.parametrize("name", STARTS)
def test_the_same_bits_in_fmpy(name: str, arrays: Callable[[str], Path], native_fmu: BuildNative) -> None:
    component = ENTRIES[name].component
    assert validity_problems(arrays(name)) == []
    common: dict[str, Any] = {"stop_time": 60.0, "step_size": 1.0, "output_interval": 1.0}
    whole = fmpy.simulate_fmu(
        str(arrays(name)), start_values=STARTS[name], output=[v.name for v in component.outputs], **common
    )
    sizes = {v.name: v.size for v in (*component.inputs, *component.parameters)}
    starts = {
        key if sizes[key] is None else f"{key}[{i}]": value
        for key, values in STARTS[name].items()
        for i, value in enumerate(np.atleast_1d(values).tolist(), start=1)
    }
    alone = fmpy.simulate_fmu(
        str(native_fmu(name, "3.0")), start_values=starts, output=component.y.names, **common
    )
    for variable in component.outputs:
        found = whole[variable.name].reshape(61, -1)
        expected = np.array([alone[scalar] for scalar in variable.scalar_names]).T
        np.testing.assert_array_equal(found, expected)
    assert any(np.ptp(np.nan_to_num(alone[scalar])) > 0 for scalar in component.y.names)


@pytest.mark.slow
def test_the_same_bits_in_our_master(arrays: Callable[[str], Path], native_fmu: BuildNative) -> None:
    kinds = set(WARMUP_CELL.parts_with(LAW).values())
    scalars = FmuStore("native").files(kinds)
    values = {
        "sensors": {"noise[1]": 0.1, "fault_kind[3]": 3, "fault_rate[3]": 1e-3},
        "duty": {"duration[1]": 50.0, "duration[2]": 60.0, "segment_speed[2]": 3.0, "segment_torque[2]": 2.5},
    }
    changed = {name: arrays(name) for name in (SENSORS, DUTY, LAW, "ThermalLink")}
    one, other = (
        simulate(WARMUP_CELL.system(fmus, LAW, values), 120.0, 1.0, GaussSeidel())
        for fmus in (scalars, scalars | changed)
    )
    for name in (
        "compensator.correction",
        "link.elongation",
        *(f"sensors.reading[{i}]" for i in range(1, 9)),
    ):
        np.testing.assert_array_equal(other[name], one[name])
    assert np.ptp(one["compensator.correction"]) > 0


@pytest.mark.slow
def test_check_finds_nothing(arrays: Callable[[str], Path]) -> None:
    quick = ["runs its default experiment", "state restore is bit-identical", "directional derivatives"]
    results = check_fmu(arrays("ThermalLink"), cases=[*quick, "dependencies proven by perturbation"])
    assert len(results) > 4
    assert {result.verdict for result in results} == {"pass"}


@pytest.fixture
def link(arrays: Callable[[str], Path], tmp_path: Path) -> Iterator[Any]:
    path = str(arrays("ThermalLink"))
    description = fmpy.read_model_description(path)
    slave = FMU3Slave(
        guid=description.guid,
        unzipDirectory=fmpy.extract(path, str(tmp_path)),
        modelIdentifier="ThermalLink",
        instanceName="link",
    )
    slave.messages = []
    slave.instantiate(logMessage=lambda *call: slave.messages.append(call[-1].decode()))
    slave.references = {v.name: v.valueReference for v in description.modelVariables}
    slave.enterInitializationMode()
    slave.exitInitializationMode()
    yield slave
    slave.freeInstance()


def test_wrong_numbers_of_values_are_refused(link: Any) -> None:
    reference = link.references["sensor_temperature"]
    assert link.getFloat64([reference], nValues=8) == [295.15] * 8
    assert link.getFloat64([reference, link.references["time"], reference], nValues=17)[8] == 0.0
    for references, count in (([reference], 1), ([reference], 7), ([reference, reference], 8)):
        with pytest.raises(Exception, match="status 3"):
            link.getFloat64(references, nValues=count)
        assert "of an array one for each element" in link.messages[-1]
    with pytest.raises(Exception, match="status 3"):
        link.getFloat64([reference + 1], nValues=1)
    assert "within an array" in link.messages[-1]


def test_derivatives_are_by_and_of_each_element(link: Any) -> None:
    reference, heat = link.references["sensor_temperature"], link.references["heat_flow"]
    unknowns = (ctypes.c_uint32 * 2)(reference, link.references["surface_heat_loss"])
    knowns = (ctypes.c_uint32 * 2)(link.references["ambient_temperature"], heat)
    seed, found = (ctypes.c_double * 2)(1.0, 0.0), (ctypes.c_double * 9)(*[7.0] * 9)
    link.fmi3GetDirectionalDerivative(link.component, unknowns, 2, knowns, 2, seed, 2, found, 9)
    assert list(found[:8]) == [0.0] * 8
    assert found[8] < 0
    link.setFloat64([heat], [5.0])
    orders, values = (ctypes.c_int32 * 2)(1, 1), (ctypes.c_double * 9)()
    link.fmi3GetOutputDerivatives(link.component, unknowns, 2, orders, values, 9)
    assert values[0] > 0
    assert list(values[1:8]) == [0.0] * 7
