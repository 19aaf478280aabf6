"""The modules that a Python FMU carries."""

import ast
import gc
from collections.abc import Iterator
from pathlib import Path

import pytest

from warmlink.fmus.packaging.python.fmu import bundle
from warmlink.orchestration.written.expression import Expression


@pytest.fixture
def finalisers_that_parse() -> Iterator[None]:
    """Garbage collections at every turn, which parse as a traceback in a finaliser does."""

    def parse(phase: str, info: dict[str, int]) -> None:
        ast.parse("a + (b * c)")

    before = gc.get_threshold()
    gc.callbacks.append(parse)
    gc.set_threshold(5)
    yield
    gc.set_threshold(*before)
    gc.callbacks.remove(parse)


@pytest.mark.usefixtures("finalisers_that_parse")
def test_a_finaliser_that_parses_does_not_make_sound_source_fail() -> None:
    carried = bundle(("warmlink.fmus.thermal_link.component",), "link")
    assert "warmlink.fmus.thermal_link.equations" in carried.modules
    text = "link.elongation * (1 + " * 12 + "motor.speed" + ")" * 12
    assert Expression(text, "score").variables == ("link.elongation", "motor.speed")


def test_the_data_beside_a_module_is_carried() -> None:
    carried = bundle(("warmlink.controllers.observer_drift.component",), "law")
    homes = [path.split("/")[1:-1] for path in carried.files if path.endswith(".json")]
    assert sorted(homes) == [["controllers", "observer"], ["controllers", "observer_drift"]]


def test_only_what_types_alone_need_is_left_out(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "law_of_ones_own.py").write_text(
        "from typing import TYPE_CHECKING\n"
        "if TYPE_CHECKING:\n    from warmlink.fmus.files import scratch_folder\n"
        "if not TYPE_CHECKING:\n    from warmlink.fmus.names import listed\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    carried = bundle(("law_of_ones_own",), "stem").modules
    assert "warmlink.fmus.names" in carried
    assert "warmlink.fmus.files" not in carried


def test_public_names_are_imported_from_where_they_are_declared(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    source = (
        "from warmlink import (\n    Law,\n    State as Kept,\n)\nfrom warmlink import where\n\nLAST = 7\n"
    )
    (tmp_path / "law_from_the_face.py").write_text(source)
    monkeypatch.syspath_prepend(tmp_path)
    carried = bundle(("law_from_the_face",), "stem")
    assert {"warmlink.controllers.own", "warmlink.fmus.component.variables"} <= carried.modules.keys()
    assert "warmlink" not in carried.modules
    written = carried.files[f"{carried.package}/law_from_the_face.py"].decode()
    imported = {
        (node.module, alias.name, alias.asname)
        for node in ast.walk(ast.parse(written))
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }
    assert imported == {
        (f"{carried.package}.controllers.own", "Law", None),
        (f"{carried.package}.fmus.component.variables", "State", "Kept"),
        (f"{carried.package}.fmus.component.arithmetic", "where", None),
    }
    assert written.splitlines()[-1] == "LAST = 7"
    assert len(written.splitlines()) == len(source.splitlines())
