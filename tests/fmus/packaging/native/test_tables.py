"""Tables among the resources of native and Python FMUs: the same numbers, and every fault in a sentence."""

from __future__ import annotations

import shutil
import zipfile
from pathlib import Path

import numpy as np
import pytest
from apart import run_apart

from warmlink.fmus.catalogue import Entry
from warmlink.fmus.component import Component
from warmlink.fmus.component.instance import Instance
from warmlink.fmus.component.join import join
from warmlink.fmus.component.table import RecordedTable
from warmlink.fmus.files import write_archive
from warmlink.fmus.motor_heat_source.component import COMPONENT as MOTOR
from warmlink.fmus.packaging.beside import FOLDER
from warmlink.fmus.packaging.native.compile import Compiler
from warmlink.fmus.packaging.native.fmu import FmiVersion, native_fmu_files
from warmlink.fmus.packaging.python.fmu import build_python_fmus
from warmlink.fmus.packaging.tabled import table_in, with_table
from warmlink.fmus.recorded_duty.component import COMPONENT, duty_table, playing
from warmlink.orchestration.check.fmu import validity_problems
from warmlink.orchestration.master.slaves.slave import SlaveError
from warmlink.orchestration.simulation import simulate
from warmlink.orchestration.system.description import read_description

from .running import Native

HOME = "warmlink.fmus.recorded_duty.component"


def random_table(rows: int, even: bool) -> RecordedTable:
    generator = np.random.default_rng(rows)
    steps = np.full(rows, 2.0) if even else 10 ** generator.uniform(-2, 2, rows)
    drawn = generator.uniform(0, 4, (2, rows))
    columns = {"speed": drawn[0], "torque": drawn[1], "ambient_temperature": 290 + 3 * drawn[0]}
    modes = {"pad_mode": generator.integers(0, 3, rows)}
    return duty_table(np.cumsum(steps), {**columns, **modes}, ["torque", "ambient_temperature"])


def fmu_of(component: Component, version: FmiVersion, compiler: Compiler, folder: Path) -> Path:
    path = folder / f"fmi{version[0]}" / f"{component.name}.fmu"
    write_archive(path, native_fmu_files(Entry(component, HOME), version, [compiler]))
    return path


@pytest.mark.parametrize("version", ["2.0", "3.0"])
@pytest.mark.parametrize(("rows", "even"), [(1, True), (2, False), (1000, True), (1000, False)])
def test_every_row_is_the_same_number_in_c(
    rows: int, even: bool, version: FmiVersion, c_compiler: Compiler, tmp_path: Path
) -> None:
    table = random_table(rows, even)
    component = playing(COMPONENT, table)
    native = Native(fmu_of(component, version, c_compiler, tmp_path), component)
    native.initialize()
    step = max(0.5, 1.01 * table.end / 2000)
    times = [0.0]
    found = [[native.get(name) for name in component.y.names]]
    while times[-1] <= table.end:
        native.step(times[-1], step)
        times.append(times[-1] + step)
        found.append([native.get(name) for name in component.y.names])
    assert np.array_equal(np.array(found), table.over(np.array(times)))
    told = f"recorded_duty: its table ends at {table.end:g} s; the last row holds from then on"
    assert native.messages == ([told] if rows > 1 else [])
    native.close()


@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_a_joined_component_plays_in_c_as_in_python(
    version: FmiVersion, c_compiler: Compiler, tmp_path: Path
) -> None:
    wires = [(f"duty.{name}", f"motor.{name}") for name in COMPONENT.y.names]
    table = random_table(300, even=False)
    joined = join("Driven", {"duty": playing(COMPONENT, table), "motor": MOTOR}, wires)
    native = Native(fmu_of(joined, version, c_compiler, tmp_path), joined)
    python = Instance(joined)
    for each in (native, python):
        each.initialize()
    for k in range(100):
        for each in (native, python):
            each.step(7.3 * k, 7.3)
        for name in (
            "motor.shaft_temperature",
            "motor.winding_temperature",
            "duty.torque",
            "motor.heat_flow",
        ):
            assert native.get(name) == pytest.approx(python.get(name), rel=1e-9)
    native.close()


def test_a_state_that_is_saved_brings_back_the_same_row(c_compiler: Compiler, tmp_path: Path) -> None:
    component = playing(COMPONENT, random_table(1000, even=False))
    native = Native(fmu_of(component, "2.0", c_compiler, tmp_path), component)
    native.initialize()
    native.step(0.0, 4000.0)
    saved = native.fmu.serializeFMUstate(native.fmu.getFMUState())
    before = [native.get(name) for name in component.y.names]
    native.step(4000.0, 3000.0)
    native.fmu.setFMUState(native.fmu.deSerializeFMUstate(saved))
    assert [native.get(name) for name in component.y.names] == before
    native.step(4000.0, 3000.0)
    native.close()


@pytest.mark.parametrize("form", ["2.0", "3.0", "python"])
def test_another_table_goes_in_without_a_compiler(form: str, c_compiler: Compiler, tmp_path: Path) -> None:
    entry = Entry(COMPONENT, HOME)
    if form == "python":
        (plain,) = build_python_fmus([entry], tmp_path / "python")
    else:
        plain = fmu_of(COMPONENT, "3.0" if form == "3.0" else "2.0", c_compiler, tmp_path)
    table = random_table(50, even=False)
    fmu = with_table(plain, table)
    assert fmu.name == plain.name
    assert table_in(fmu).digest == table.digest
    assert with_table(fmu, table) in (fmu, with_table(plain, table))
    assert not validity_problems(fmu)
    with zipfile.ZipFile(fmu) as archive:
        tried = archive.read(f"{FOLDER}/smoke-test.csv").decode().splitlines()
    for line in tried[1:]:
        time, *values = map(float, line.split(","))
        assert values == pytest.approx(table.over(np.array([time]))[0], rel=1e-6)
    found = simulate(fmu, stop=2000, step=20.0)
    columns = [found[next(n for n in found.table.names if n.endswith(name))] for name in COMPONENT.y.names]
    assert np.allclose(np.array(columns).T, table.over(found.times), rtol=1e-9, atol=0)


@pytest.mark.parametrize("form", ["2.0", "3.0", "python"])
def test_no_two_tables_make_one_fmu_to_a_host(form: str, c_compiler: Compiler, tmp_path: Path) -> None:
    """Libcosim loads one FMU for all of a GUID in a system, and plays its table for each."""
    tables = [random_table(rows, even=True) for rows in (20, 21)]
    if form == "python":
        fmus = [
            *build_python_fmus([Entry(playing(COMPONENT, tables[0]), HOME)], tmp_path),
            *build_python_fmus([Entry(COMPONENT, HOME)], tmp_path / "plain"),
        ]
    else:
        version: FmiVersion = "3.0" if form == "3.0" else "2.0"
        fmus = [
            fmu_of(playing(COMPONENT, tables[0]), version, c_compiler, tmp_path),
            fmu_of(COMPONENT, version, c_compiler, tmp_path / "plain"),
        ]
    fmus += [with_table(fmus[1], tables[1]), with_table(fmus[0], tables[1])]
    guids = [read_description(fmu).guid for fmu in fmus]
    assert len({*guids[:3]}) == 3
    assert guids[2] == guids[3]


@pytest.mark.parametrize("version", ["2.0", "3.0"])
@pytest.mark.parametrize(
    ("damage", "sentence"),
    [
        (None, "cannot be read; give the folder"),
        (lambda content: content[:-1] + bytes([content[-1] ^ 1]), "is damaged, its checksum differs"),
        (lambda content: content.replace(b"speed", b"spxxd"), "is no table of these columns"),
        (lambda content: content[:-16], "does not hold its rows"),
        (lambda content: content[:20], "is no table of these columns"),
    ],
)
def test_a_missing_or_damaged_table_is_refused(
    version: FmiVersion, damage: object, sentence: str, c_compiler: Compiler, tmp_path: Path
) -> None:
    component = playing(COMPONENT, random_table(20, even=False))
    path, place = fmu_of(component, version, c_compiler, tmp_path), "resources/rows.table"
    with zipfile.ZipFile(path) as archive:
        files = {name: archive.read(name) for name in archive.namelist()}
    held = files.pop(place)
    if callable(damage):
        files[place] = damage(held)
    write_archive(path, files)
    with pytest.raises(SlaveError, match=sentence):
        simulate(path, stop=10, step=1.0)


def test_a_folder_with_blanks_and_umlauts_is_found(c_compiler: Compiler, tmp_path: Path) -> None:
    path = fmu_of(playing(COMPONENT, random_table(20, even=True)), "2.0", c_compiler, tmp_path)
    home = tmp_path / "über 100 % & more"
    home.mkdir()
    there = Path(shutil.copy(path, home))
    with zipfile.ZipFile(there) as archive:
        archive.extractall(home / "unpacked")
    found = simulate(there, stop=10, step=1.0)
    assert found.reason is None or found.error is None


@pytest.mark.parametrize("form", ["native", "python"])
@pytest.mark.parametrize("host", ["fmpy", "libcosim"])
def test_other_hosts_hand_over_the_table(host: str, form: str, c_compiler: Compiler, tmp_path: Path) -> None:
    pytest.importorskip({"libcosim": "libcosimpy"}.get(host, host))
    table = random_table(40, even=False)
    component = playing(COMPONENT, table)
    if form == "native":
        fmu = fmu_of(component, "2.0", c_compiler, tmp_path)
    else:
        (fmu,) = build_python_fmus([Entry(component, HOME)], tmp_path / "python")
    names = component.y.names
    asked = {"fmu": str(fmu), "set": {}, "watch": names, "step": 1.0, "steps": 20}
    rows = run_apart(f"run_{host}", jobs=[asked]).result[0]["rows"]
    assert np.array(rows) == pytest.approx(table.over(np.arange(1.0, 21.0)), rel=1e-9)


@pytest.mark.parametrize("damaged", [False, True])
def test_a_python_fmu_without_its_table_refuses_the_first_step(damaged: bool, tmp_path: Path) -> None:
    component = playing(COMPONENT, random_table(20, even=False))
    (path,) = build_python_fmus([Entry(component, HOME)], tmp_path)
    with zipfile.ZipFile(path) as archive:
        files = {name: archive.read(name) for name in archive.namelist()}
    held = files.pop("resources/rows.table")
    if damaged:
        files["resources/rows.table"] = held[:-1] + b"x"
    write_archive(path, files)
    found = simulate(path, stop=10, step=1.0)
    assert found.reason is not None
    assert ("its checksum differs" if damaged else "cannot be read") in found.reason
