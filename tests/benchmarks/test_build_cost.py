"""What a build costs is measured, and steps are compared in pairs."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from benchmarks.build import build_cost, paired_steps
from warmlink.fmus.errors import InputError


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    pytest.importorskip("resource", reason="this platform does not tell a child's processor time")
    if not any(map(shutil.which, ("cc", "gcc", "clang"))):
        pytest.skip("there is no C compiler here")
    folder = tmp_path_factory.mktemp("built")
    cost = build_cost(["Heater"], folder)
    assert cost.what == "Heater"
    assert 0.05 < cost.compilers < 60
    assert 5 < cost.compiler_memory < 400
    return folder / "native" / "fmi2" / "Heater.fmu"


def test_a_system_beside_itself_takes_as_long(built: Path) -> None:
    pair = paired_steps(built, built)
    assert pair.system == "Heater"
    assert 0 < pair.here < 1e4
    assert 0.1 < pair.ratio < 10


def test_what_the_other_checkout_lacks_is_named(built: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"SixAxisArm\.fmu: no such file; give the folder"):
        paired_steps(built, tmp_path / "SixAxisArm.fmu")


def test_a_build_that_fails_is_no_cost(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="did you mean Heater"):
        build_cost(["Heatre"], tmp_path)
