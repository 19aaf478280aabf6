"""The cell in a browser's engine: the numbers of the native run, at every step."""

import importlib.util
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.node import node
from warmlink.fmus.catalogue import Entry
from warmlink.fmus.component import Component
from warmlink.fmus.heater.component import COMPONENT as HEATER
from warmlink.fmus.packaging.native.fmu import browser_module, build_native_fmus
from warmlink.fmus.recorded_duty.component import COMPONENT as PLAYER
from warmlink.fmus.recorded_duty.component import duty_table, playing
from warmlink.orchestration.catalogue import controller
from warmlink.orchestration.machine.shipped import WARMUP_CELL
from warmlink.orchestration.master.run import simulate
from warmlink.orchestration.report.live.page import packed
from warmlink.orchestration.system.assemble import component
from warmlink.orchestration.system.model import DefaultExperiment, System

pytestmark = pytest.mark.platform

RUN = """
import { engine } from "${page}/engine.js";
const run = await engine(given.module);
let result;
try {
  const columns = run(given.watched, given.steps, given.step, given.values);
  result = columns.map((each) => [...each]);
} catch (fault) {
  result = fault.message;
}
"""


@pytest.fixture(scope="module", autouse=True)
def _zig() -> None:
    if importlib.util.find_spec("ziglang") is None:
        pytest.skip('ziglang is not installed: pip install "warmlink[live]"')


def job(whole: Component, steps: int, watched: list[str], values: dict[str, float]) -> dict[str, Any]:
    references = {scalar.name: scalar.reference for scalar in whole.scalars()}
    return {
        "module": packed(browser_module(whole)),
        "watched": [references[name] for name in watched],
        "steps": steps,
        "step": 1.0,
        "values": [(references[name], value) for name, value in values.items()],
    }


@pytest.mark.slow
def test_the_cell_gives_the_native_numbers_at_every_step(tmp_path: Path) -> None:
    """To the last bit, except for the noise of instruments: the two platforms' logarithms differ in it."""
    whole = WARMUP_CELL.joined(controller("lag"))
    values = {
        "duty.duration[1]": 1200.0,
        "duty.duration[2]": 600.0,
        "duty.segment_speed[2]": 0.0,
        "link.length": 0.4,
        **{f"sensors.noise[{i}]": 0.1 for i in range(1, 9)},
    }
    watched = [s.name for s in whole.scalars() if s.reference >= whole.p.size + whole.u.size]
    (fmu,) = build_native_fmus([Entry(whole, "warmlink.orchestration.machine.machine")], tmp_path)
    system = System("Alone", {"whole": component("whole", fmu, values)}, (), DefaultExperiment(0, 7200, 1))
    native = simulate(system, 7200.0, 1.0)
    given = job(whole, 7200, watched, values)
    for name, ours in zip(watched, node(RUN, given), strict=True):
        theirs = native[f"whole.{name}"]
        tolerance = 1e-12 * np.abs(theirs).max() if name.startswith(("sensors.", "camera.")) else 0.0
        np.testing.assert_allclose(ours, theirs, rtol=0.0, atol=tolerance, err_msg=name)


def test_a_refusal_is_the_components_sentence() -> None:
    assert node(RUN, job(HEATER, 20, ["heat_flow"], {"initial_temperature": -0.1})) == (
        "Heater.initial_temperature: -0.1 K is not positive; give a value above 0 K"
    )


PLAYED = """
import { engine } from "${page}/engine.js";
let result;
try {
  const run = await engine(given.module, [given.table]);
  result = run(given.watched, 40, 1.0, []).map((each) => [...each]);
} catch (fault) {
  result = fault.message;
}
"""


def test_a_table_of_any_length_is_played() -> None:
    generator = np.random.default_rng(4)
    times = np.cumsum(generator.uniform(0.1, 3.0, 20_000)) - 1.0
    columns = {"speed": generator.uniform(0, 4, times.size), "torque": generator.uniform(0, 3, times.size)}
    whole = playing(PLAYER, duty_table(times, columns, ["torque"]))
    (played,) = whole.tables
    given = {"module": packed(browser_module(whole)), "watched": [0, 1, 2]}
    found = node(PLAYED, {**given, "table": packed(played.content)})
    np.testing.assert_array_equal(np.array(found).T, played.table.over(np.arange(41.0))[:, :3])
    damaged = played.content[:-8] + bytes(8)
    told = node(PLAYED, {**given, "table": packed(damaged)})
    assert told == "the table of the recorded duty is damaged, its checksum differs"
