"""The cell without NaN: readings that hold their last value, and flags that say so."""

from __future__ import annotations

import zipfile
from collections.abc import Iterable, Mapping
from pathlib import Path

import numpy as np
import pytest

from warmlink.controllers.interface import compensator, error_parameters, error_std, law_outputs
from warmlink.fmus.catalogue import Entry
from warmlink.fmus.component import Component, Record, State, Values
from warmlink.fmus.component.arithmetic import Number, finite, where
from warmlink.fmus.component.instance import Instance
from warmlink.fmus.errors import InputError
from warmlink.fmus.packaging.native.fmu import build_native_fmus
from warmlink.fmus.packaging.views import flagged
from warmlink.orchestration.catalogue import components
from warmlink.orchestration.fmu_store import FmuStore
from warmlink.orchestration.machine.read import is_ours
from warmlink.orchestration.machine.shipped import WARMUP_CELL
from warmlink.orchestration.master.algorithms.explicit import GaussSeidel
from warmlink.orchestration.master.run import simulate
from warmlink.orchestration.products.build import build
from warmlink.orchestration.system.assemble import read_system
from warmlink.orchestration.system.write import write_ssp


class SmallLaw:
    """Growth by two thermometers and the camera, as far as there are readings; it is soon compiled."""

    @staticmethod
    def begin(u: Record, p: Record) -> Values:
        return {"estimate": 0.0}

    @staticmethod
    def update(x: Record, u: Record, p: Record, time: Number, step: Number) -> Values:
        temperatures = (u.shaft_temperature, u.base_temperature)
        terms = [*(4e-6 * (each - u.ambient_temperature) for each in temperatures), u.measured_drift]
        return {"estimate": sum(where(finite(each), each, 0.0) for each in terms)}

    @staticmethod
    def outputs(x: Record, u: Record, p: Record, time: Number) -> Values:
        return law_outputs(x.estimate, error_std(x.estimate, p), p)


LAW = compensator(
    "SmallLaw", str(SmallLaw.__doc__), SmallLaw, error_parameters(5e-6), [State("estimate", "m")]
)
WITH_READINGS = [components()["TemperatureSensors"], components()["DriftCamera"], LAW]
DROPOUTS: Mapping[str, Mapping[str, float | int]] = {
    "sensors": {"fault_kind[1]": 4, "fault_time[1]": 60.0, "fault_kind[5]": 4, "noise[3]": 0.05},
    "camera": {"fault_kind": 4, "fault_time": 100.0},
}


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    shipped = FmuStore("native").files({kind for kind in WARMUP_CELL.parts.values() if kind})
    return shipped | built([LAW], tmp_path_factory.mktemp("plain"))


@pytest.fixture(scope="module")
def told(plain: dict[str, Path], tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """The same FMUs with flags."""
    return plain | built(map(flagged, WITH_READINGS), tmp_path_factory.mktemp("flags"))


def built(chosen: Iterable[Component], folder: Path) -> dict[str, Path]:
    home = "warmlink.orchestration.machine.machine"
    return {path.stem: path for path in build_native_fmus([Entry(each, home) for each in chosen], folder)}


@pytest.mark.slow
def test_the_cell_with_flags_does_what_the_cell_with_nan_does(
    plain: dict[str, Path], told: dict[str, Path], tmp_path: Path
) -> None:
    runs = []
    for name, fmus in (("plain", plain), ("told", told)):
        path = tmp_path / f"{name}.ssp"
        write_ssp(WARMUP_CELL.system(fmus, LAW.name, DROPOUTS), path)
        runs.append(simulate(read_system(path, tmp_path / name), 200.0, 1.0, GaussSeidel()))
    with_nan, with_flags = runs
    for name in ("compensator.correction", "compensator.ready", "link.elongation"):
        np.testing.assert_array_equal(with_flags[name], with_nan[name])
    assert np.ptp(with_nan["compensator.correction"]) > 0
    assert not np.isnan(with_flags.table.values).any()
    for reading, flag in (
        ("sensors.reading[1]", "sensors.reading_valid[1]"),
        ("sensors.reading[5]", "sensors.reading_valid[5]"),
        ("camera.measured_drift", "camera.measured_drift_valid"),
    ):
        known = ~np.isnan(with_nan[reading])
        np.testing.assert_array_equal(with_flags[flag].astype(bool), known)
        np.testing.assert_array_equal(with_flags[reading][known], with_nan[reading][known])
        assert not known.all()


def test_a_system_with_ports_shows_its_flags(told: dict[str, Path], tmp_path: Path) -> None:
    path = tmp_path / "ports.ssp"
    write_ssp(WARMUP_CELL.system(told, LAW.name), path, WARMUP_CELL.ports)
    text = zipfile.ZipFile(path).read("SystemStructure.ssd").decode()
    assert 'name="reading_valid[8]" kind="output"' in text


def test_a_joined_cell_has_the_flags_of_its_parts() -> None:
    early = {
        "sensors": {**DROPOUTS["sensors"], "fault_time[1]": 20.0},
        "camera": {**DROPOUTS["camera"], "fault_time": 40.0},
    }
    cell = WARMUP_CELL.joined(LAW, early)
    assert flagged(cell).default_stop_time == cell.default_stop_time
    found: dict[str, list[float]] = {}
    for each in (cell, flagged(cell)):
        running = Instance(each, each.name)
        running.begin(0.0)
        running.initialize()
        for i in range(70):
            running.step(float(i), 1.0)
            for name in ("compensator.correction", "sensors.reading[1]", "camera.measured_drift_valid"):
                if name in each.y.index:
                    found.setdefault(f"{name} {len(each.outputs)}", []).append(float(running.get(name)))
    with_nan, nan, with_flags, held, valid = found.values()
    assert with_nan == with_flags
    assert with_nan[-1] != 0
    assert np.isnan(nan[-1])
    assert held[-1] == held[-2] == nan[18]
    assert valid[35] == 1.0
    assert valid[-1] == 0.0


def test_fmus_with_flags_are_not_taken_for_those_without(
    plain: dict[str, Path], told: dict[str, Path]
) -> None:
    for each in WITH_READINGS:
        assert is_ours(plain[each.name], each)
        assert not is_ours(told[each.name], each)


@pytest.mark.parametrize(("fmus", "scenario"), [("all", None), ("native", "cell.toml")])
def test_flags_are_for_shipped_native_fmus(fmus: str, scenario: str | None, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="`valid_flags`: is for the shipped native FMUs"):
        build((), tmp_path / "dist", fmus=fmus, scenario=scenario, valid_flags=True)
    assert not (tmp_path / "dist").exists()
