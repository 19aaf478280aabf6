"""Arrays of foreign FMUs of FMI 3.0: element by element in a system, as a whole in SSP 2.0."""

from __future__ import annotations

import csv
import os
import shutil
import subprocess
import zipfile
from pathlib import Path

import pytest
from lxml import etree
from system.ssp_text import component, connection, connector, parameters, ssd, system

from warmlink.fmus.errors import InputError
from warmlink.orchestration.master.algorithms.explicit import GaussSeidel
from warmlink.orchestration.master.run import simulate
from warmlink.orchestration.system.assemble import assemble, read_system
from warmlink.orchestration.system.description import read_description
from warmlink.orchestration.system.model import FmuPart, System
from warmlink.orchestration.system.write import write_ssp

from .hand_written import compiled
from .pairs import wire

DESCRIPTION = """<fmiModelDescription fmiVersion="3.0" modelName="Arrays" instantiationToken="{a}">
  <CoSimulation modelIdentifier="Arrays" canHandleVariableCommunicationStepSize="true"/>
  <LogCategories><Category name="own"/></LogCategories>
  <ModelVariables>
    <Float64 name="u" valueReference="0" causality="input" start="1 2 3"><Dimension start="3"/></Float64>
    <Float64 name="gain" valueReference="1" causality="parameter" variability="tunable"
      start="1 0 0 0 1 0 0 0 1"><Dimension valueReference="9"/><Dimension start="3"/></Float64>
    <Float64 name="y" valueReference="2" causality="output"><Dimension valueReference="9"/></Float64>
    <UInt64 name="size" valueReference="9" causality="structuralParameter" variability="fixed" start="3"/>
  </ModelVariables>
  <ModelStructure><Output valueReference="2" dependencies=""/></ModelStructure>
</fmiModelDescription>"""


@pytest.fixture(scope="module")
def arrays(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return compiled(tmp_path_factory.mktemp("arrays"), Path(__file__).with_name("arrays.c"), DESCRIPTION)


def test_the_state_space_of_the_reference_fmus_runs(tmp_path: Path) -> None:
    """FMU of the Modelica Association, built from its sources, against the results that lie beside them."""
    import fmpy

    source, compiler = Path(os.environ.get("REFERENCE_FMUS", "")), shutil.which("gcc")
    if compiler is None or not (source / "StateSpace").is_dir():
        pytest.skip("name a checkout of github.com/modelica/Reference-FMUs in REFERENCE_FMUS; it needs gcc")
    library = tmp_path / f"StateSpace{fmpy.sharedLibraryExtension}"
    units = [
        source / "StateSpace/model.c",
        *(source / "src" / f"{n}.c" for n in ("fmi3Functions", "cosimulation")),
    ]
    folders = [f"-I{source / name}" for name in ("include", "StateSpace")]
    flags = ["-O1", "-fPIC", "-shared", "-w", "-DFMI_VERSION=3", "-DDISABLE_PREFIX"]
    subprocess.run([compiler, *flags, *folders, *units, "-o", library, "-lm"], check=True)
    with zipfile.ZipFile(tmp_path / "StateSpace.fmu", "w") as archive:
        archive.write(source / "StateSpace/FMI3.xml", "modelDescription.xml")
        archive.write(library, f"binaries/{fmpy.platform_tuple}/{library.name}")
    alone = System("s", {"a": FmuPart("a", tmp_path / "StateSpace.fmu")})
    run = simulate(alone, 10.0, 1.0, GaussSeidel())
    assert run.status == "completed", run.reason
    with (source / "StateSpace/StateSpace_out.csv").open() as stream:
        published = [[float(text) for text in row["y"].split()] for row in csv.DictReader(stream)]
    assert [[run[f"a.y[{i}]"][k] for i in (1, 2, 3)] for k in range(11)] == published


def test_arrays_are_their_elements(arrays: Path) -> None:
    info = read_description(arrays)
    assert info.arrays["u"] == info.with_causality("input") == ("u[1]", "u[2]", "u[3]")
    assert info.outputs == ("y[1]", "y[2]", "y[3]")
    assert [info.variables[f"gain[{i},{i}]"].start for i in (1, 2, 3)] == [1.0, 1.0, 1.0]
    last = info.variables["gain[3,2]"]
    assert (last.value_reference, last.element, last.elements, last.start) == (1, 7, 9, 0.0)


def test_elements_are_wired_set_and_recorded_alone(arrays: Path) -> None:
    values = {"a": {"gain[1,2]": 10.0}, "b": {"u[2]": -1.0, "gain[2,2]": 2.0}}
    parts = {name: FmuPart(name, arrays, {}, given) for name, given in values.items()}
    wired = System("s", parts, (wire("a.y[1] -> b.u[3]"), wire("b.y[2] -> a.u[1]", factor=0.5)))
    run = simulate(wired, 2.0, 1.0, GaussSeidel(("b", "a")), record=["a.y[1]", "b.y[3]", "a.u[1]", "a.u[2]"])
    assert run.status == "completed", run.reason
    # b.y[2] = 2 * -1, so a.u[1] = -1 and a.y[1] = -1 + 10 * 2; b takes it a step later.
    assert [run[name][-1] for name in ("a.y[1]", "b.y[3]", "a.u[1]", "a.u[2]")] == [19.0, 19.0, -1.0, 2.0]


def written(folder: Path, fmu: Path, second: str, size: int) -> System:
    whole = f'<ssc:Real/><ssc:Dimension size="{size}"/>'
    ends = component("a", "resources/A.fmu", connector("y", "output", whole))
    ends += component("b", "resources/A.fmu", connector(second, "input", whole))
    path = folder / "arrays.ssp"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("SystemStructure.ssd", ssd(system(ends, connection("a.y", f"b.{second}")), "2.0"))
        archive.write(fmu, "resources/A.fmu")
    return read_system(path, folder / "work")


def test_an_array_is_connected_as_a_whole_in_ssp_2(arrays: Path, tmp_path: Path) -> None:
    read = written(tmp_path, arrays, "u", 3)
    assert [link.target for link in read.connections] == ["b.u[1]", "b.u[2]", "b.u[3]"]
    read.components["a"].values["gain[3,1]"] = 4.0
    run = simulate(read, 1.0, 1.0, GaussSeidel(("a", "b")))
    assert [run[f"b.y[{i}]"][-1] for i in (1, 2, 3)] == [1.0, 2.0, 7.0]


def test_a_connector_of_another_size_is_refused(arrays: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"a\.y: is declared with 2 elements, but has 3 in its FMU"):
        written(tmp_path, arrays, "u", 2)


def test_a_structural_parameter_says_how_large_arrays_are(tmp_path: Path, arrays: Path) -> None:
    """Two rows in place of three, from a parameter set, and of what is set alone the rest stays."""
    bound = parameters("size:UInt64:2").replace("UInt64", "Integer")
    gain = parameters("gain[2,1]:Real:10", name="gain")
    shown = connector("y", "output", '<ssc:Float64/><ssc:Dimension size="2"/>')
    part = component("a", "resources/A.fmu", shown, bound + gain)
    with zipfile.ZipFile(tmp_path / "small.ssp", "w") as archive:
        archive.writestr("SystemStructure.ssd", ssd(system(part), "2.0"))
        archive.write(arrays, "resources/A.fmu")
    read = read_system(tmp_path / "small.ssp", tmp_path / "work")
    assert read.components["a"].values == {"size": 2, "gain[2,1]": 10.0}
    run = simulate(read, 1.0, 1.0)
    assert run.status == "completed", run.reason
    assert [name for name in run.table.names if name.startswith("a.y")] == ["a.y[1]", "a.y[2]"]
    assert [run[f"a.y[{n}]"][-1] for n in (1, 2)] == [1.0, 10.0 * 1.0 + 2.0]
    write_ssp(read, tmp_path / "again.ssp", version="2.0")
    again = read_system(tmp_path / "again.ssp", tmp_path / "again")
    assert again.components["a"].values == read.components["a"].values


def written_entries(path: Path) -> dict[str, bytes]:
    with zipfile.ZipFile(path) as archive:
        return {name: archive.read(name) for name in archive.namelist() if not name.endswith(".fmu")}


def test_arrays_of_fmi_3_are_written_whole_in_ssp_2(tmp_path: Path, arrays: Path) -> None:
    """And by their elements in SSP 1.0, which knows none; both are read again as they were."""
    gain = {f"gain[{i},{j}]": float(i == j) + 0.5 for i in (1, 2, 3) for j in (1, 2, 3)}
    wires = [(f"a.y[{n}]", f"b.u[{n}]") for n in (1, 2, 3)] + [("b.y[2]", "a.u[3]")]
    made = assemble("arrays", {"a": arrays, "b": arrays}, wires, {"a": gain, "b": {"gain[1,2]": 4.0}})
    write_ssp(made, tmp_path / "two.ssp", version="2.0")
    write_ssp(made, tmp_path / "one.ssp")
    for name in ("one", "two"):
        again = read_system(tmp_path / f"{name}.ssp", tmp_path / name)
        assert set(again.connections) == set(made.connections)
        assert {part: held.values for part, held in again.components.items()} == {
            part: held.values for part, held in made.components.items()
        }
    entries = written_entries(tmp_path / "two.ssp")
    root = etree.fromstring(entries["SystemStructure.ssd"])
    assert root.get("version") == "2.0"
    links = [dict(each.attrib) for each in root.iter("{*}Connection")]
    ends = {"startElement": "a", "startConnector": "y", "endElement": "b", "endConnector": "u"}
    assert links[0] == ends
    assert (links[1]["startIndices"], links[1]["endIndices"]) == ("2", "3")
    connectors = {each.get("name"): each for each in root.iter("{*}Connector")}
    assert connectors["u"].find("{*}Float64") is not None
    assert [each.get("size") for each in connectors["gain"].iterfind("{*}Dimension")] == ["3", "3"]
    (whole,) = etree.fromstring(entries["resources/a.ssv"]).iter("{*}Parameter")
    assert whole.get("name") == "gain"
    assert whole.find("{*}Real").get("value").split()[:2] == ["1.5", "0.5"]
    (one,) = etree.fromstring(entries["resources/b.ssv"]).iter("{*}Parameter")
    assert one.get("name") == "gain[1,2]"
