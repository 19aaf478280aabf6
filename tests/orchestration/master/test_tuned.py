"""A tunable parameter that changes in a run: the same effect in FMPy, in libcosim and in our master."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.fmus.packaging.native.running import Native
from tests.referees import libcosim
from warmlink.fmus.errors import InputError
from warmlink.fmus.heater.component import COMPONENT as HEATER
from warmlink.fmus.thermal_link.component import COMPONENT as LINK
from warmlink.orchestration.fmu_store import FMU_KINDS, FmuStore
from warmlink.orchestration.machine.shipped import machine_named
from warmlink.orchestration.master.algorithms.doubling import StepDoubling
from warmlink.orchestration.master.algorithms.explicit import GaussSeidel, Jacobi
from warmlink.orchestration.master.algorithms.iterated import FixedPoint
from warmlink.orchestration.master.algorithms.tuned import Change, Retuned
from warmlink.orchestration.master.run import simulate
from warmlink.orchestration.system.model import System
from warmlink.orchestration.system.write import write_ssp

from .mock import MockSlave, real
from .pairs import assembly, counter, wire

STEPS, AT = 60, 30
LATER = 12.0
"""W, where the heater has 6."""
WATCHED = ("link.elongation", "heater.heat_flow", "sensors.reading[3]")
CHANGES = (Change(AT, "heater", "power", LATER), Change(AT, "sensors", "offset[3]", 0.5))


@pytest.fixture(scope="module", params=FMU_KINDS)
def bench(request: pytest.FixtureRequest) -> System:
    rod = machine_named("BenchRod")
    return rod.system(FmuStore(request.param).files(rod.parts.values()), None, rod.shown)


def run(bench: System, *changes: Change) -> np.ndarray:
    result = simulate(bench, float(STEPS), 1.0, Retuned(Jacobi(), changes))
    assert result.status == "completed"
    return np.column_stack([result[name] for name in WATCHED])


def test_it_acts_from_its_time_on_and_not_before(bench: System) -> None:
    plain, tuned = run(bench), run(bench, *CHANGES)
    np.testing.assert_array_equal(plain[: AT + 1], tuned[: AT + 1])
    assert list(tuned[[AT, AT + 1], 1]) == [6.0, LATER]
    assert tuned[-1, 0] > 1.2 * plain[-1, 0]
    # The offset of the sensor acts on its next sample, whatever the heat does.
    offset = run(bench, CHANGES[1])[:, 2] - plain[:, 2]
    np.testing.assert_allclose(offset, np.where(np.arange(STEPS + 1) > AT, 0.5, 0.0), atol=1e-12)


def test_between_communication_points_it_acts_from_the_later_one_on(bench: System) -> None:
    early = [replace(change, time=AT - 0.4) for change in CHANGES]
    np.testing.assert_array_equal(run(bench, *early), run(bench, *CHANGES))


@pytest.mark.platform
def test_libcosim_agrees(bench: System, tmp_path: Path) -> None:
    write_ssp(bench, tmp_path / "bench.ssp")
    elongation, heat_flow, power = (
        next(s.reference for s in component.scalars() if s.name == name)
        for component, name in ((LINK, "elongation"), (HEATER, "heat_flow"), (HEATER, "power"))
    )
    asked = [(WATCHED[0], elongation), (WATCHED[1], heat_flow)]
    change = (AT, "heater", power, LATER)
    theirs = libcosim(tmp_path / "bench.ssp", STEPS, asked, change)
    np.testing.assert_allclose(theirs, run(bench, CHANGES[0])[1:, :2], rtol=0, atol=1e-12)


def test_fmpy_agrees(bench: System) -> None:
    if b"warmlink_heater" in bench.components["heater"].fmu.read_bytes():
        pytest.skip("a Python FMU cannot be loaded beside another in this process")
    heater = Native(bench.components["heater"].fmu, HEATER)
    link = Native(bench.components["link"].fmu, LINK)
    heater.set({"on": 1.0})
    for part in (heater, link):
        part.enter()
    link.set({"heat_flow": heater.get("heat_flow")})
    heater.set({"link_base_temperature": link.get("base_temperature")})
    for part in (heater, link):
        part.fmu.exitInitializationMode()
    rows = []
    for step in range(STEPS):
        if step == AT:
            heater.set({"power": LATER})
        for part in (heater, link):
            part.step(float(step), 1.0)
        rows.append([link.get("elongation"), heater.get("heat_flow")])
        link.set({"heat_flow": heater.get("heat_flow")})
        heater.set({"link_base_temperature": link.get("base_temperature")})
    np.testing.assert_allclose(rows, run(bench, CHANGES[0])[1:, :2], rtol=0, atol=1e-15)
    for part in (heater, link):
        part.close()


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (Change(1.0, "oven", "power", 1.0), "oven.power: no slave has such a variable; did you mean"),
        (
            Change(1.0, "heater", "powr", 1.0),
            "heater.powr: no slave has such a variable; did you mean heater.power?",
        ),
        (
            Change(1.0, "heater", "heat_capacity", 1.0),
            "heater.heat_capacity: is fixed, not tunable; set it before the run",
        ),
        (Change(1.0, "heater", "power", -1.0), "heater.power: -1"),
    ],
)
def test_what_cannot_be_tuned_is_refused(bench: System, change: Change, sentence: str) -> None:
    with pytest.raises(InputError) as refusal:
        simulate(bench, 2.0, 1.0, Retuned(GaussSeidel(), (change,)))
    assert str(refusal.value).startswith(sentence)


def test_step_doubling_compares_anew_after_a_change() -> None:
    # Until then a ramp, which no comparison finds an error in; from then on with an oscillation.
    source = MockSlave(
        "source",
        inputs={"size": 0.0},
        outputs={"y": lambda x, u, t: 50.0 * t + u["size"] * np.sin(6.0 * t)},
        variables=[replace(real("size", "parameter", variability="tunable"), initial="exact")],
    )
    chosen = Retuned(StepDoubling(FixedPoint(), {"x.y": 1e-2}), (Change(AT, "source", "size", 1.0),))
    result = simulate(assembly([source, counter("x", 1.0)], wire("source.y -> x.u")), 45.0, 1.0, chosen)
    late = np.maximum(result.times, AT)
    exact = 25.0 * result.times**2 + (np.cos(6.0 * AT) - np.cos(6.0 * late)) / 6.0
    assert np.max(np.abs(result["x.y"] - exact)) <= 1e-2
