"""`warmlink reduce`: an FMU that passes its checks, and one sentence for each part that is none."""

import json
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("gmsh", reason="gmsh is not installed: pip install 'warmlink[cad]'")
pytest.importorskip("pymor", reason="pyMOR is not installed: pip install 'warmlink[cad]'")

from tests.orchestration.reduction.parts import bar, drawn
from warmlink.fmus.errors import InputError
from warmlink.orchestration import cli
from warmlink.orchestration.reduction.solid import point

FACES = ("--heat-face", "0, 10, 3 mm", "--tool-point", "330.2, 12.7, 3 mm")


def reduce(*arguments: object) -> None:
    given = ["reduce", *map(str, arguments)]
    cli.application(given)(given, standalone_mode=False)


@pytest.mark.slow
def test_a_part_becomes_an_fmu_that_passes_its_checks(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    part, out = bar(tmp_path / "bar.step"), tmp_path / "MyLink.fmu"
    capsys.readouterr()
    reduce(part, *FACES, "--order", 4, "--mesh-size", "20 mm", "--out", out, "--json")
    said = json.loads(capsys.readouterr().out)
    assert said["failed_checks"] == []
    assert said["order"] == 4
    assert said["error_over_tolerance"] > 1
    with zipfile.ZipFile(out) as fmu:
        page = fmu.read("documentation/index.html").decode()
        assert "displacement_error_bound" in fmu.read("modelDescription.xml").decode()
    assert f"{said['tetrahedra']} tetrahedra" in page
    assert "not met: the order was given" in page
    assert sorted(path.name for path in tmp_path.iterdir()) == ["MyLink.fmu", "MyLink.html", "bar.step"]
    report = (tmp_path / "MyLink.html").read_text("utf-8")
    assert "Where two thermometers tell most of the tool point" in report
    assert len(report) < 2.5e6


def test_faces_are_listed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    part = bar(tmp_path / "bar.step")
    capsys.readouterr()
    reduce(part, "--list-faces", "--json")
    assert "Faces of bar.step" in (tmp_path / "bar_faces.html").read_text("utf-8")
    faces = json.loads(capsys.readouterr().out)
    assert sorted(round(1e6 * face["area"], 3) for face in faces) == [
        161.29,
        161.29,
        2096.77,
        2096.77,
        8387.08,
        8387.08,
    ]


def two_boxes(occ: Any) -> None:
    occ.addBox(0, 0, 0, 100, 10, 10)
    occ.addBox(0, 50, 0, 100, 10, 10)


def open_box(occ: Any) -> None:
    occ.addRectangle(0, 0, 0, 100, 10)


def in_inches(occ: Any) -> None:
    occ.addBox(0, 0, 0, 330.2 * 25.4, 645.16, 161.29)


@pytest.mark.parametrize(
    ("draw", "sentence"),
    [
        (two_boxes, "holds 2 bodies; unite them"),
        (open_box, "holds 1 faces that close no solid, an open solid or a shell"),
        (in_inches, "the part is 8.39 m long, where links have 0.02 to 5 m; check its unit"),
    ],
)
def test_what_is_no_link_is_refused(draw: Callable[[Any], None], sentence: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=sentence):
        reduce(drawn(tmp_path / "part.step", draw), *FACES)


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (("--heat-face", "#9", *FACES[2:]), "--heat-face #9: no such face; .*--list-faces"),
        (("--heat-face", "flange", *FACES[2:]), "--heat-face flange: no such face"),
        (
            (*FACES[:2], "--tool-point", "1, 2 mm"),
            "--tool-point 1, 2 mm: is no point; write it with its unit",
        ),
        ((*FACES[:2], "--tool-point", "0, 1, 2 mm"), "lies on the heated face"),
        (
            (*FACES[:2], "--tool-point", "0, 12.7, 3.175 mm", "--tool-face", "330.2, 12.7, 3 mm"),
            "--tool-point 0, 12.7, 3.175 mm: is the middle of the heated face",
        ),
        ((*FACES, "--cooled", "#2;"), "--cooled : no such face"),
        ((*FACES, "--cooled", "#2;#3", "--cooled", "#3"), "--cooled: face #3 is named twice"),
        (
            (*FACES, "--material", "aluminum"),
            "--material aluminum: no such material; did you mean aluminium",
        ),
        ((*FACES, "--convection", "60 .. 2 W/(m2.K)"), "ends below where it begins"),
        ((*FACES, "--unit", "mm"), "a STEP file says its unit"),
        ((*FACES, "--out", "my link.fmu"), "names no FMU"),
        (FACES[:2], "both are needed"),
    ],
)
def test_options_that_fit_nothing_are_refused(
    options: tuple[str, ...], sentence: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match=sentence):
        reduce(bar(tmp_path / "bar.step"), *options, "--mesh-size", "30 mm")
    assert [path.name for path in tmp_path.iterdir()] == ["bar.step"]


def test_a_point_has_one_unit_or_three() -> None:
    for text in ("25.4, 6, 0 mm", "25.4 mm, 6 mm, 0 mm", "2.54 cm, 6 mm, 0 m"):
        np.testing.assert_allclose(point(text, "tool_point"), [0.0254, 0.006, 0.0])
    for text in ("25.4, 6, 0", "25.4 mm, 6 mm", "1 mm, 2 mm, 3", "a, b, c mm"):
        with pytest.raises(InputError, match="is no point"):
            point(text, "tool_point")


@pytest.mark.parametrize(
    ("name", "content", "sentence"),
    [
        ("part.step", "ISO-10303-21; no more", "is broken"),
        ("part.msh", "$MeshFormat\n4.1 0 8\n", "is broken, or no mesh"),
        ("part.stl", "solid", "is neither STEP nor mesh"),
        ("absent.step", None, "no such file"),
    ],
)
def test_a_file_that_is_broken_is_refused(
    name: str, content: str | None, sentence: str, tmp_path: Path
) -> None:
    if content is not None:
        (tmp_path / name).write_text(content)
    unit = ("--unit", "mm") if name.endswith(".msh") else ()
    with pytest.raises(InputError, match=sentence):
        reduce(tmp_path / name, *FACES, *unit)


def test_a_mesh_wants_its_unit(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="a mesh does not say its unit; give --unit mm"):
        reduce(bar(tmp_path / "bar.msh", mesh=40.0), *FACES)


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (("--order", "40"), "--order 40: on this mesh there are 14 patterns; give no more"),
        (("--tolerance", "1e-30 m"), "14 patterns leave an error .* allow a larger --tolerance"),
    ],
)
def test_more_patterns_than_a_mesh_has_are_refused(
    options: tuple[str, ...], sentence: str, tmp_path: Path
) -> None:
    import meshio

    points = 100.0 * np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]])
    meshio.write(tmp_path / "part.inp", meshio.Mesh(points, [("tetra", [[0, 1, 2, 3], [1, 2, 3, 4]])]))
    with pytest.raises(InputError, match=sentence):
        reduce(tmp_path / "part.inp", *FACES, "--unit", "mm", *options)


POINTS = 100.0 * np.array(
    [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1], [2, 1, 1], [1, 2, 1], [2, 2, 2]]
)
TETRAHEDRA = ("tetra", [[0, 1, 2, 3], [1, 2, 3, 4]])


@pytest.mark.parametrize("corners", [[4, 5, 6], [0, 1, 4], [1, 2, 3]], ids=["apart", "beside", "inside"])
def test_a_group_of_triangles_that_are_no_surface_is_refused(corners: list[int], tmp_path: Path) -> None:
    """Heat would leave the part through a plane inside it."""
    import meshio

    cells = [TETRAHEDRA, ("triangle", [[0, 1, 2], corners])]
    meshio.write(tmp_path / "part.inp", meshio.Mesh(POINTS, cells, cell_sets={"datum": [[], [0, 1]]}))
    with pytest.raises(InputError, match="the group datum has triangles that are none of the part's surface"):
        reduce(tmp_path / "part.inp", *FACES, "--unit", "mm")


def test_groups_that_share_triangles_are_refused(tmp_path: Path) -> None:
    """The heated face would be cooled as a part of the other."""
    import meshio

    cells = [TETRAHEDRA, ("triangle", [[0, 1, 2], [0, 1, 3]])]
    sets = {"skin": [[], [0, 1]], "flange": [[], [1]]}
    meshio.write(tmp_path / "part.inp", meshio.Mesh(POINTS, cells, cell_sets=sets))
    with pytest.raises(InputError, match=r"groups (skin and flange|flange and skin) share triangles"):
        reduce(tmp_path / "part.inp", *FACES, "--unit", "mm")


def test_a_mesh_that_is_not_of_tetrahedra_alone_is_refused(tmp_path: Path) -> None:
    """What the others fill would be missing from the part."""
    import meshio

    cells = [TETRAHEDRA, ("hexahedron", [[0, 1, 2, 3, 4, 5, 6, 7]])]
    meshio.write(tmp_path / "part.inp", meshio.Mesh(POINTS, cells))
    with pytest.raises(
        InputError, match="cells of the type hexahedron; mesh the whole solid with tetrahedra"
    ):
        reduce(tmp_path / "part.inp", *FACES, "--unit", "mm")
