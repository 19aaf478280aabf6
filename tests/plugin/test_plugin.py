"""A package of a stranger's adds a component, a law, a cause, a master algorithm and a command by itself."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

HERE = Path(__file__).parent

Warmlink = Callable[..., subprocess.CompletedProcess[str]]


@pytest.fixture
def warmlink(tmp_path: Path) -> Warmlink:
    """The command beside the package, which is installed in a folder of its own."""
    site = tmp_path / "site"
    shutil.copytree(HERE / "lumps", site / "lumps", ignore=shutil.ignore_patterns("__pycache__"))
    facts = site / "lumps-1.0.dist-info"
    facts.mkdir()
    (facts / "METADATA").write_text("Metadata-Version: 2.1\nName: lumps\nVersion: 1.0\n", "utf-8")
    shutil.copy(HERE / "entry_points.txt", facts)

    def run(*arguments: str) -> subprocess.CompletedProcess[str]:
        path = os.pathsep.join(filter(None, (str(site), os.environ.get("PYTHONPATH"))))
        return subprocess.run(
            [sys.executable, "-m", "warmlink", *arguments],
            cwd=tmp_path,
            env={**os.environ, "PYTHONPATH": path},
            capture_output=True,
            text=True,
        )

    return run


def test_what_it_adds_is_listed(warmlink: Warmlink) -> None:
    listed = json.loads(warmlink("list", "--json").stdout)
    assert listed["components"]["Lump"] == "Lump of metal that cools"
    assert listed["controllers"]["half"] == "Growth in proportion to the temperature at the tip"
    assert listed["masters"]["reversed"] == "Gauss-Seidel under another name."
    assert listed["systems"]["LumpBench"] == "a lump on a bench"
    assert "greet" in warmlink("--help").stdout


def test_its_command_is_carried_out(warmlink: Warmlink) -> None:
    assert warmlink("greet", "Ada").stdout == "Good morning, Ada\n"
    assert warmlink("greet", "Ada", "--loud").stdout == "Good morning, ADA\n"
    assert "Who is greeted." in warmlink("greet", "--help").stdout


@pytest.mark.slow
def test_its_law_runs_with_its_algorithm_and_its_component_is_built(
    warmlink: Warmlink, tmp_path: Path
) -> None:
    told = warmlink(
        *("run", "windshield_wiper", "--controller", "half", "--master", "reversed"),
        *("--step", "10 s", "--stop", "10 min", "--out", "o"),
    )
    assert told.returncode == 0, told.stderr
    metrics = json.loads((tmp_path / "o" / "metrics.json").read_text("utf-8"))
    assert metrics["controller"] == "half"
    built = warmlink("build", "Lump", "--fmus", "native", "--fmi", "2", "--out", "dist")
    assert built.returncode == 0, built.stderr
    assert (tmp_path / "dist" / "native" / "fmi2" / "Lump.fmu").is_file()


def test_its_cause_takes_part_in_every_diagnosis(warmlink: Warmlink, tmp_path: Path) -> None:
    script = (
        "from warmlink.orchestration.diagnosis.causes.catalogue import catalogue; "
        "print([each.frees for each in catalogue() if each.name == 'torque_constant_of_the_motor'])"
    )
    path = os.pathsep.join(filter(None, (str(tmp_path / "site"), os.environ.get("PYTHONPATH"))))
    told = subprocess.run(
        [sys.executable, "-c", script],
        env={**os.environ, "PYTHONPATH": path},
        capture_output=True,
        text=True,
        check=True,
    )
    assert told.stdout == "[('motor.torque_constant',)]\n"


@pytest.mark.parametrize(
    ("entry", "sentence"),
    [
        ("[warmlink.laws]\nhalf = lumps.nowhere:LAW", "does not load (ModuleNotFoundError"),
        ("[warmlink.components]\nlump = lumps.commands:greet", "is not a Component; mend that package"),
        ("[warmlink.commands]\nrun = lumps.commands:greet", "warmlink has a command of this name"),
    ],
)
def test_what_does_not_work_is_refused_with_the_package_that_adds_it(
    entry: str, sentence: str, warmlink: Warmlink, tmp_path: Path
) -> None:
    facts = tmp_path / "site" / "lumps-1.0.dist-info"
    (facts / "entry_points.txt").write_text(entry, "utf-8")
    told = warmlink("--help") if "commands]" in entry else warmlink("list")
    assert told.returncode == 2
    assert "the package lumps adds it to warmlink's" in told.stderr
    assert sentence in told.stderr
