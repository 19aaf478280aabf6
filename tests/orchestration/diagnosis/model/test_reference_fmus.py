"""FMUs that nobody here wrote: the Reference-FMUs' Dahlquist equation, with another decay than is said.

They are built from their sources: from the checkout that REFERENCE_FMUS names, or else a clone.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import zipfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from fmpy import platform, sharedLibraryExtension

from benchmarks.own_systems import experiment, measured, with_values, write_csv
from tests.orchestration.diagnosis.model.test_loop import Here
from warmlink.orchestration.diagnosis.answer.diagnosis import Diagnosis
from warmlink.orchestration.diagnosis.diagnose import diagnose_experiment, read
from warmlink.orchestration.diagnosis.model import driven
from warmlink.orchestration.fmu_store import FmuStore
from warmlink.orchestration.system.assemble import assemble, component, connected
from warmlink.orchestration.system.model import DefaultExperiment, System

ORIGIN = "https://github.com/modelica/Reference-FMUs"
NAME = "Dahlquist"
DECAY = 1 / 600
COLUMNS = {"x [1]": "decay.x"}
RATE = """
[[cause]]
name = "rate"
sentence = "It decays at another rate."
check = "Wait."
frees = ["decay.k"]
between = [1e-4, 1e-2]
"""
READING = """
[[cause]]
name = "offset"
sentence = "The reading is off."
check = "Compare it with another one."
reading = { of = "decay.x", offset = "1" }
between = [-0.5, 0.5]
[[cause]]
name = "late"
sentence = "The reading follows late."
check = "Step it."
reading = { of = "decay.x", lag = "s" }
between = ["0 s", "5 min"]
"""
LINK_COLUMNS = {
    "base [degC]": "link.base_temperature",
    "middle [degC]": "link.sensor_temperature[2]",
    "tip [degC]": "link.tip_temperature",
}
FREES = """
[[cause]]
name = "{0}"
sentence = "The {0} is another one."
check = "Measure it."
frees = ["{1}.{0}"]
between = ["{2}", "{3}"]
"""
LINK_CAUSES = RATE + "".join(
    FREES.format(*each)
    for each in (
        ("tip_conductance", "link", "0 W/K", "5 W/K"),
        ("convection_still", "link", "1 W/(m**2*K)", "30 W/(m**2*K)"),
        ("specific_heat", "link", "400 J/(kg*K)", "2000 J/(kg*K)"),
        ("power", "heater", "2 W", "40 W"),
    )
)


@pytest.fixture(scope="module")
def fmu(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The FMU, built for this machine."""
    folder = tmp_path_factory.mktemp("reference")
    source = Path(os.environ.get("REFERENCE_FMUS", folder / "source"))
    compiler = shutil.which("cc")
    if compiler is None:
        pytest.skip("there is no C compiler called cc")
    if not source.is_dir():
        clone = ["git", "clone", "--quiet", "--depth", "1", ORIGIN, str(source)]
        try:
            subprocess.run(clone, check=True, capture_output=True, timeout=20)
        except (OSError, subprocess.SubprocessError) as fault:
            pytest.skip(f"{ORIGIN} cannot be cloned ({fault}); name a checkout in REFERENCE_FMUS")
    library = folder / f"{NAME}{sharedLibraryExtension}"
    files = [source / "src" / "fmi2Functions.c", source / "src" / "cosimulation.c", source / NAME / "model.c"]
    options = ["-shared", "-fPIC", "-O1", "-w", "-DFMI_VERSION=2", "-DDISABLE_PREFIX"]
    folders = [f"-I{source / 'include'}", f"-I{source / NAME}"]
    subprocess.run([compiler, *options, *folders, *files, "-lm", "-o", library], check=True)
    with zipfile.ZipFile(folder / f"{NAME}.fmu", "w") as archive:
        archive.write(source / NAME / "FMI2.xml", "modelDescription.xml")
        archive.write(library, f"binaries/{platform}/{library.name}")
    return folder / f"{NAME}.fmu"


def diagnosed(fmu: Path, folder: Path, hidden: float, causes: str, seed: int) -> Diagnosis:
    """What is said of a run in which the decay is so many times what the system says."""
    base = assemble("Decay", {"decay": fmu}, (), {"decay": {"k": DECAY}})
    base = replace(base, default_experiment=DefaultExperiment(0.0, 3000.0, 10.0))
    path = experiment(folder, base, COLUMNS, causes)
    truth = with_values(base, {"decay": {"k": hidden * DECAY}})
    write_csv(measured(truth, COLUMNS, 0.005, seed, row=20.0, step=10.0), folder / "run.csv")
    return diagnose_experiment(read([path]))


@pytest.mark.parametrize("seed", range(3))
def test_a_hidden_rate_is_named(
    fmu: Path, tmp_path: Path, seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(driven, "_pool", Here)
    hidden = float(np.random.default_rng(seed).uniform(1.05, 2.0))
    found = diagnosed(fmu, tmp_path, hidden, RATE + READING, seed)
    assert (found.verdict, found.assessment.best.name) == ("named", "rate")
    best = found.assessment.best
    assert abs(best.theta[0] / DECAY - hidden) < 4 * float(np.sqrt(best.covariance()[0, 0])) / DECAY


def test_a_rate_that_is_no_candidate_is_unknown(
    fmu: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(driven, "_pool", Here)
    assert diagnosed(fmu, tmp_path, 1.5, READING, 1).verdict == "unknown"


@pytest.mark.slow
def test_a_hidden_loss_beside_it_is_named(fmu: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its decay drives the heater of a link that loses heat at its tip, in nine of ten random strengths.

    In Dahlquist's equation itself, der(x) = -k x, an extra loss is another rate and nothing else.
    """
    monkeypatch.setattr(driven, "_pool", Here)
    files = FmuStore("native").files(["Heater", "ThermalLink"])
    parts = {
        "decay": component("decay", fmu, {"k": DECAY / 2}),
        "heater": component("heater", files["Heater"], {"power": 10.0}),
        "link": component("link", files["ThermalLink"]),
    }
    wires = (("decay.x", "heater.on"), ("heater.heat_flow", "link.heat_flow"))
    base = System("Fading", parts, connected(parts, wires), DefaultExperiment(0.0, 3000.0, 10.0))
    path = experiment(tmp_path, base, LINK_COLUMNS, LINK_CAUSES)
    said = []
    for seed in range(10):
        random = np.random.default_rng(seed)
        hidden = float(np.exp(random.uniform(np.log(0.01), np.log(0.3))))
        truth = with_values(base, {"link": {"tip_conductance": hidden}})
        run = measured(truth, LINK_COLUMNS, 0.05, seed, row=20.0, step=0.1)
        write_csv(run, tmp_path / "run.csv")
        found = diagnose_experiment(read([path]))
        said.append((found.verdict, found.assessment.best.name))
    assert said.count(("named", "tip_conductance")) >= 9, said
