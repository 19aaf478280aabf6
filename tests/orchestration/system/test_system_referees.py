"""What is written runs in libcosim and in Ecos, each in a process of its own, with the same numbers."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from tests.referees import ecos, libcosim
from warmlink.orchestration.system.assemble import component, connected
from warmlink.orchestration.system.model import Connection, DefaultExperiment, System
from warmlink.orchestration.system.write import PARAMETER_SET, write_ssp

pytestmark = pytest.mark.platform

RAMP = """
from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Integer, Real

class {name}(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.slope, self.height, self.count = 1.0, 0.0, 0
        self.register_variable(Real("height", causality=Fmi2Causality.output))
        self.register_variable(
            Integer("count", causality=Fmi2Causality.output, variability=Fmi2Variability.discrete)
        )
        self.register_variable(
            Real("slope", causality=Fmi2Causality.parameter, variability=Fmi2Variability.fixed, start=1.0)
        )

    def do_step(self, time, step):
        self.height += self.slope * step
        self.count += 1
        return True
"""
SCALE = """
from pythonfmu import Boolean, Fmi2Causality, Fmi2Slave, Fmi2Variability, Integer, Real

FIXED = dict(causality=Fmi2Causality.parameter, variability=Fmi2Variability.fixed)

class {name}(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.seen, self.number, self.result, self.gain, self.negated = 0.0, 0, 0.0, 1.0, False
        self.register_variable(Real("seen", causality=Fmi2Causality.input, start=0.0))
        self.register_variable(
            Integer("number", causality=Fmi2Causality.input, variability=Fmi2Variability.discrete, start=0)
        )
        self.register_variable(Real("result", causality=Fmi2Causality.output))
        self.register_variable(Real("gain", start=1.0, **FIXED))
        self.register_variable(Boolean("negated", start=False, **FIXED))

    def do_step(self, time, step):
        self.result = self.gain * self.seen * (-1 if self.negated else 1) + 1000 * self.number
        return True
"""


@pytest.fixture(scope="module")
def cell(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Give an SSP of a ramp that drives a scale, with start values, a transformation and a step size."""
    pytest.importorskip("pythonfmu")
    folder = tmp_path_factory.mktemp("referees")
    fmus = {}
    for name, text in (("RefereeRamp", RAMP), ("RefereeScale", SCALE)):
        script = folder / f"{name.lower()}.py"
        script.write_text(text.format(name=name))
        command = [sys.executable, "-m", "pythonfmu", "build", "-f", str(script), "-d", str(folder)]
        subprocess.run(command, check=True, capture_output=True, timeout=120)
        fmus[name] = folder / f"{name}.fmu"
    parts = {
        "ramp": component("ramp", fmus["RefereeRamp"], {"slope": 3.0}),
        "scale": component("scale", fmus["RefereeScale"], {"gain": 5.0, "negated": True}),
    }
    connections = (
        Connection("ramp", "height", "scale", "seen", 2.0, 0.25),
        *connected(
            parts,
            [
                ("ramp.count", "scale.number"),
            ],
        ),
    )
    path = folder / "cell.ssp"
    write_ssp(System("cell", parts, connections, DefaultExperiment(0.0, 2.0, 0.5)), path)
    return path


# height rises by 3 * 0.5 a step; the scale sees 2 * height + 0.25 and the count of one step before.
EXPECTED = [[1.5 * n, -5.0 * (2.0 * 1.5 * (n - 1) + 0.25) + 1000.0 * (n - 1)] for n in range(1, 5)]


WATCHED = (("ramp.height", 0), ("scale.result", 2))


def test_libcosim_runs_it(cell: Path) -> None:
    np.testing.assert_allclose(libcosim(cell, 4, WATCHED), EXPECTED, rtol=1e-14)


def test_ecos_runs_it(cell: Path) -> None:
    np.testing.assert_allclose(ecos(cell, 4, 0.5, PARAMETER_SET, WATCHED), EXPECTED, rtol=1e-14)


def test_ecos_takes_no_parameter_set_unasked(cell: Path) -> None:
    """So our documentation names the set to ask for: without it the slope of the FMU itself stays."""
    np.testing.assert_array_equal(ecos(cell, 4, 0.5, None, WATCHED[:1]), [[0.5], [1.0], [1.5], [2.0]])
