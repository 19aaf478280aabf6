"""What lies in an FMU, and that building it twice gives the same bytes."""

from __future__ import annotations

import ast
import re
import tomllib
import zipfile
from pathlib import Path

import pytest

from warmlink.controllers.lag.component import COMPONENT as LAG
from warmlink.fmus.catalogue import Entry, catalogue
from warmlink.fmus.component import Component
from warmlink.fmus.component.join import join
from warmlink.fmus.files import write_archive
from warmlink.fmus.motor_heat_source.component import COMPONENT as MOTOR
from warmlink.fmus.packaging import release
from warmlink.fmus.packaging.documentation import documentation_page
from warmlink.fmus.packaging.python.fmu import build_python_fmus, bundle
from warmlink.fmus.temperature_sensors.component import COMPONENT as SENSORS
from warmlink.orchestration.check.fmu import validity_problems

ROOT = Path(__file__).parents[3]
every = pytest.mark.parametrize("entry", catalogue(), ids=lambda entry: entry.component.name)


def test_every_folder_that_declares_a_component_is_found() -> None:
    declaring = [path for home in ("fmus", "controllers") for path in (ROOT / home).glob("*/component.py")]
    # One that is made from a user's data declares none until then.
    folders = {path.parts[-3:-1] for path in declaring if "\nCOMPONENT = " in path.read_text("utf-8")}
    assert {entry.readme.parts[-3:-1] for entry in catalogue()} == folders


def test_validation_finds_nothing_in_any_fmu(python_fmus: dict[str, Path]) -> None:
    assert [validity_problems(path) for path in python_fmus.values()] == [[] for _ in python_fmus]


def test_builds_are_equal_byte_for_byte(python_fmus: dict[str, Path], tmp_path: Path) -> None:
    told: list[str] = []
    built = build_python_fmus(catalogue(), tmp_path / "python", told.append)
    assert told == list(python_fmus)
    for path in built:
        assert path.parent == tmp_path / "python"
        assert path.read_bytes() == python_fmus[path.stem].read_bytes(), path.stem
    assert sorted(p.name for p in (tmp_path / "python").iterdir()) == sorted(p.name for p in built)


def test_an_fmu_holds_what_fmi_names(python_fmus: dict[str, Path]) -> None:
    for name, path in python_fmus.items():
        with zipfile.ZipFile(path) as archive:
            names = archive.namelist()
            stem = archive.read("resources/slavemodule.txt").decode()
        assert names[0] == "modelDescription.xml"
        assert {
            "model.png",
            "documentation/index.html",
            "documentation/licenses/license.txt",
            f"binaries/linux64/{name}.so",
            f"binaries/win64/{name}.dll",
            f"resources/{stem}.py",
        } <= set(names)
        assert not [n for n in names if "__pycache__" in n or n.startswith("resources/pythonfmu")]


def test_bundled_modules_import_no_equally_named_ones(python_fmus: dict[str, Path]) -> None:
    top = re.compile(r"warmlink_\w+_[0-9a-f]{12}")
    for name, path in python_fmus.items():
        with zipfile.ZipFile(path) as archive:
            sources = {n: archive.read(n) for n in archive.namelist() if n.endswith(".py")}
        (package,) = {match[0] for n in sources if (match := top.match(n.removeprefix("resources/")))}
        for file, source in sources.items():
            for node in ast.walk(ast.parse(source)):
                if isinstance(node, ast.ImportFrom) and not node.level and node.module:
                    first = node.module.partition(".")[0]
                    assert first not in ("warmlink", "pythonfmu"), f"{name}: {file}"
                    assert not first.startswith("warmlink_") or first == package


def test_a_bundle_s_name_follows_its_contents(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(tmp_path))
    module = tmp_path / "my_law.py"
    module.write_text("from warmlink.fmus.component.arithmetic import clip\n", "utf-8")
    first = bundle(("my_law",), "stem")
    assert (
        first.files[f"{first.package}/my_law.py"]
        .decode()
        .startswith(f"from {first.package}.fmus.component.arithmetic")
    )
    assert first == bundle(("my_law",), "stem")
    module.write_text("from warmlink.fmus.component.arithmetic import clip  # else\n", "utf-8")
    assert bundle(("my_law",), "stem").package != first.package


def test_an_import_that_cannot_be_rewritten_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(tmp_path))
    (tmp_path / "law_that_imports.py").write_text("\nimport warmlink.fmus.errors\n", "utf-8")
    with pytest.raises(ValueError, match="law_that_imports, line 2: 'import warmlink"):
        bundle(("law_that_imports",), "stem")


def test_an_archive_that_fails_leaves_nothing(tmp_path: Path) -> None:
    target = tmp_path / "a.fmu"
    write_archive(target, {"b": b"1"})
    before = target.read_bytes()
    with pytest.raises(TypeError):
        write_archive(target, {"b": b"2", "c": None})  # type: ignore[dict-item]
    assert target.read_bytes() == before
    assert list(tmp_path.iterdir()) == [target]


@every
def test_the_page_has_every_variable_and_needs_no_other_file(entry: Entry) -> None:
    page = documentation_page(entry).decode()
    assert "<!-- variables -->" not in page
    assert page.count("<h1>") == 1
    for variable in (*entry.component.inputs, *entry.component.parameters, *entry.component.outputs):
        assert f"<code>{variable.name}" in page
    assert not re.search(r"(src|href)=", page)


def test_the_page_shows_values_in_their_display_units() -> None:
    link = next(entry for entry in catalogue() if entry.component.name == "ThermalLink")
    page = documentation_page(link).decode()
    row = next(line for line in page.splitlines() if "<code>length</code>" in line)
    assert "<td>mm</td>" in row
    assert ">330.2<" in row
    row = next(line for line in page.splitlines() if "<code>initial_temperature</code>" in line)
    assert "<td>degC</td>" in row
    assert ">22<" in row


@pytest.mark.parametrize(
    ("parts", "longest"),
    [
        ({"motor": MOTOR}, "1 s."),
        ({"sensors": SENSORS}, "sensors.sample_time."),
        ({"motor": MOTOR, "sensors": SENSORS}, "sensors.sample_time or 1 s, whichever is shorter."),
        ({"sensors": SENSORS, "law": LAG}, "the shortest sample time."),
    ],
)
def test_the_page_says_how_long_a_step_may_be(parts: dict[str, Component], longest: str) -> None:
    page = documentation_page(Entry(join("Cell", parts), __name__)).decode()
    assert f"One communication step lasts at most 10000 times {longest}" in page


def test_the_release_is_the_project_s() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    assert release.version() == project["version"]
    assert project["license"] == release.LICENSE
    assert release.COPYRIGHT in release.license_text() == (ROOT / "LICENSE").read_text("utf-8")


def test_an_archive_may_have_any_name_that_a_file_can_have(tmp_path: Path) -> None:
    target = tmp_path / f"{'x' * 251}.fmu"
    write_archive(target, {"b": b"1"})
    assert list(tmp_path.iterdir()) == [target]
