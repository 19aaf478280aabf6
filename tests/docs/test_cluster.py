"""docs/cluster.md: its recipes run as they stand, with smaller numbers, on a cluster of one node."""

from __future__ import annotations

import json
import re
import socket
import subprocess
import sys
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import Any
from urllib.request import urlopen

import pytest

from benchmarks.kills import finished_runs, results
from tests.docs.slurm import Slurm, slurm, until
from tests.documented import DOCS, blocks

pytestmark = [pytest.mark.slow, pytest.mark.platform]

PAGE = (DOCS / "cluster.md").read_text("utf-8")
(LOGIN,) = blocks(PAGE, "python")
ONE_NODE, NODES, DASHBOARD = blocks(PAGE, "sh")
(JOURNAL,) = blocks(PAGE, "toml")

SMALL = {ONE_NODE: "--cpus-per-task=2", NODES: "--ntasks=2"}
"""Option that stands above the recipe's own number."""

STUDY = """
controller = "lag"
duty_cycles = ["windshield_wiper", "stop_and_go"]
[parameters]
"compensator.gain" = { min = "2 um/W", max = "8 um/W" }
"compensator.time_constant" = { min = "10 min", max = "3 h", log = true }
[objective]
metric = "max_abs_um"
"""
TRIALS = "[tune]\ntrials = 64\n"
AT = 40
"""Finished runs after which a job is disturbed."""


@pytest.fixture(scope="module")
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Slurm]:
    with slurm(tmp_path_factory.mktemp("slurm")) as cluster:
        yield cluster


@pytest.fixture(scope="module")
def undisturbed(cluster: Slurm, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    folder = tmp_path_factory.mktemp("plain")
    (folder / "study.toml").write_text(STUDY + TRIALS)
    cluster.said("warmlink", "tune", "study.toml", "--out", "study", folder=folder)
    return results(folder / "study")


@pytest.fixture
def study(tmp_path: Path) -> Path:
    (tmp_path / "study.toml").write_text(STUDY + TRIALS)
    return tmp_path / "study"


def submitted(cluster: Slurm, recipe: str, folder: Path) -> str:
    script = folder / "job.sh"
    script.write_text(recipe)
    return cluster.submit(script, SMALL[recipe])


def test_dask_jobqueue(cluster: Slurm, undisturbed: dict[str, Any], study: Path) -> None:
    pytest.importorskip("dask_jobqueue", reason="dask-jobqueue is missing: pip install dask-jobqueue")
    smaller = re.sub(r"(cores|processes)=8", r"\1=2", LOGIN).replace('"8 GB"', '"2 GB"')
    assert smaller != LOGIN
    (study.parent / "study_on_slurm.py").write_text(smaller)
    cluster.said("python", "study_on_slurm.py", folder=study.parent)
    assert results(study) == undisturbed


@pytest.mark.parametrize("recipe", [ONE_NODE, NODES], ids=["one node", "nodes"])
def test_a_job_whose_node_fails_goes_on(
    recipe: str, cluster: Slurm, undisturbed: dict[str, Any], study: Path
) -> None:
    job = submitted(cluster, recipe, study.parent)
    until(lambda: finished_runs(study) >= AT, "the first runs")
    cluster.fail_the_node(job)
    before = finished_runs(study)
    assert AT <= before < len(undisturbed["runs.jsonl"])
    assert cluster.ended(job) == "COMPLETED"
    assert results(study) == undisturbed


@pytest.mark.parametrize("recipe", [ONE_NODE, NODES], ids=["one node", "nodes"])
def test_a_job_that_was_killed_goes_on_when_it_is_submitted_again(
    recipe: str, cluster: Slurm, undisturbed: dict[str, Any], study: Path
) -> None:
    job = submitted(cluster, recipe, study.parent)
    until(lambda: finished_runs(study) >= AT, "the first runs")
    cluster.said("scancel", "--full", "--signal=KILL", job)
    assert cluster.ended(job) in ("CANCELLED", "FAILED")
    assert AT <= finished_runs(study) < len(undisturbed["runs.jsonl"])
    assert cluster.ended(submitted(cluster, recipe, study.parent)) == "COMPLETED"
    assert results(study) == undisturbed


def test_the_journal_and_its_dashboard(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    if find_spec("optuna_dashboard") is None:
        pytest.skip("optuna-dashboard is missing: pip install optuna-dashboard")
    monkeypatch.setenv("PATH", f"{Path(sys.executable).parent}:/usr/bin:/bin")
    journal, command = (text.replace("/shared", str(tmp_path)) for text in (JOURNAL, DASHBOARD))
    (tmp_path / "study.toml").write_text(STUDY + journal)
    tune = [sys.executable, "-m", "warmlink", "tune", "study.toml", "--trials", "3"]
    told = subprocess.run(tune, cwd=tmp_path, capture_output=True, text=True, check=True).stdout
    assert f"study   {command.strip()}" in told
    with socket.socket() as port:
        if port.connect_ex(("127.0.0.1", 8080)) == 0:
            pytest.skip("port 8080, the dashboard's, is taken")
    server = subprocess.Popen(["bash", "-euc", f"exec {command}"], stderr=subprocess.DEVNULL)
    try:
        until(lambda: shown() is not None, "the dashboard")
        assert [each["study_name"].partition("-")[0] for each in shown()["study_summaries"]] == ["study"]
    finally:
        server.terminate()
        server.wait()


def shown() -> Any:
    """What the dashboard answers; None while it does not."""
    try:
        with urlopen("http://127.0.0.1:8080/api/studies") as answer:
            return json.load(answer)
    except OSError:
        return None
