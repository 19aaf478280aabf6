"""The smoke test inside an FMU: its files fit together, and another tool finds its results."""

from __future__ import annotations

import csv
import io
from pathlib import Path
from xml.etree import ElementTree as ET

import fmpy
import pytest
from lxml import etree

from warmlink.fmus.catalogue import catalogue
from warmlink.fmus.packaging.beside import FOLDER, reference_files
from warmlink.fmus.packaging.native.fmu import FmiVersion, build_native_fmus
from warmlink.orchestration.system.archive import read_member
from warmlink.orchestration.system.check import checked_value
from warmlink.orchestration.system.description import read_description
from warmlink.orchestration.system.ssp.parameter_values import read_ssv

ENTRIES = {entry.component.name: entry for entry in catalogue()}


@pytest.mark.parametrize("name", ENTRIES)
def test_the_manifest_names_the_files_that_are_there(name: str) -> None:
    files = reference_files(ENTRIES[name].component)
    schema = Path(fmpy.__file__).parent / "ssp/schema/SystemStructureParameterValues.xsd"
    for path in ("nominal.ssv", "smoke-test.ssv"):
        etree.XMLSchema(file=str(schema)).assertValid(etree.fromstring(files[f"{FOLDER}/{path}"]))
    root = ET.fromstring(files.pop(f"{FOLDER}/fmi-ls-manifest.xml"))
    assert {f"{FOLDER}/{each.get('source')}" for each in root.iter("Related")} == set(files)
    experiment = ET.fromstring(files[f"{FOLDER}/smoke-test.exp"])
    assert {f"{FOLDER}/{each.get('source')}" for each in experiment.iterfind("Experiment/*")} < set(files)


@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_fmpy_finds_the_results_of_the_smoke_test(version: FmiVersion, tmp_path: Path) -> None:
    (fmu,) = build_native_fmus([ENTRIES["TemperatureSensors"]], tmp_path, version)
    info = read_description(fmu)
    starts = {}
    for name in ("nominal.ssv", "smoke-test.ssv"):
        (tmp_path / name).write_bytes(read_member(fmu, f"{FOLDER}/{name}"))
        given = read_ssv(tmp_path / name)
        starts |= {k: checked_value(info.variables[k], v.value, k) for k, v in given.items()}
    assert len(starts) == len(info.with_causality("parameter")) + len(info.with_causality("input"))
    told = ET.fromstring(read_member(fmu, f"{FOLDER}/smoke-test.exp")).find("Experiment")
    assert told is not None
    rows = list(csv.DictReader(io.StringIO(read_member(fmu, f"{FOLDER}/smoke-test.csv").decode())))
    stop, step = float(told.get("stopTime", "")), float(told.get("stepSize", ""))
    found = fmpy.simulate_fmu(
        str(fmu), start_values=starts, stop_time=stop, step_size=step, output_interval=step
    )
    for row, values in zip(rows, found, strict=True):
        for output in info.outputs:
            assert float(row[output]) == pytest.approx(float(values[output]), rel=1e-6, abs=1e-15), output
