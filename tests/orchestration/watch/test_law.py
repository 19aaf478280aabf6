"""What a law leaves of the growth is judged, and what an alarm offers can be used."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from benchmarks.watch import HEADERS, WatchedCell
from tests.orchestration.watch.conftest import RATE, SLIPS, SOUND, lines_of
from warmlink.fmus.errors import InputError
from warmlink.orchestration.diagnosis.data.experiment import read_experiment
from warmlink.orchestration.diagnosis.data.measured import read_run
from warmlink.orchestration.machine.heat_paths import rig_of
from warmlink.orchestration.products.watch import watch
from warmlink.orchestration.scenarios.overrides import parameters_of
from warmlink.orchestration.watch.law import LawError, ShadowLaw, growth_weights, law_error, law_named
from warmlink.orchestration.watch.naming import Explanation
from warmlink.orchestration.watch.offers import (
    EXPERIMENT_FILE,
    LAW_FILE,
    MODEL_FILE,
    WINDOW_FILE,
    changed_parameters,
    write_offer,
)
from warmlink.orchestration.watch.ticks import Tick
from warmlink.orchestration.written.quantities import quantity

pytestmark = pytest.mark.xdist_group("sound cell")  # which one worker makes

RIG = rig_of("WarmupCell")
GROWTH = RIG.columns["elongation"]
SEEN = (RIG.columns["base_temperature"], RIG.columns["tip_temperature"], GROWTH)


def ticks_of(cell: WatchedCell) -> list[Tick]:
    return list(cell.watcher.recent)


def test_the_growth_has_to_be_measured() -> None:
    assert growth_weights(RIG, SEEN[:2]) is None
    assert growth_weights(RIG, SEEN) == pytest.approx([0, 0, 1])
    assert law_error(None, RIG, SEEN, is_logged=False, tick=60.0) is None
    with pytest.raises(InputError, match=r"log link\.elongation"):
        law_error(law_named("regression", None), RIG, SEEN[:2], is_logged=False, tick=60.0)
    with pytest.raises(InputError, match="none of its thermometers is logged"):
        law_error(law_named("regression", None), RIG, (GROWTH,), is_logged=False, tick=60.0)


@pytest.mark.parametrize("name", ["regression", "observer_drift"])
def test_a_law_in_shadow_goes_on_from_its_state(
    name: str, sound_cell: tuple[WatchedCell, np.ndarray]
) -> None:
    cell, law = sound_cell[0], law_named(name, None).component
    outputs, ticks = cell.watcher.machine.outputs, ticks_of(cell)[:20]

    def made() -> LawError:
        weights = growth_weights(RIG, outputs)
        assert weights is not None
        return LawError(weights, ShadowLaw(law, RIG, outputs, 60.0))

    whole, first, second = made(), made(), made()
    left = [whole.add(each) for each in ticks]
    before = [first.add(each) for each in ticks[:9]]
    second.restore(json.loads(json.dumps(first.state())))
    assert [*before, *(second.add(each) for each in ticks[9:])] == left
    assert abs(left[-1]) < abs(ticks[-1].readings[outputs.index(GROWTH)]), "it takes out some of it"


def test_errors_lean_in_standard_deviations_of_the_sound_part() -> None:
    law = LawError(np.array([1.0]), opening=[1e-6, 3e-6, np.nan, 1e-6, 3e-6])
    assert law.learn()[:2] == [1e-6, 3e-6]
    lean, known = law.leans([2e-6, 4e-6, np.nan, 1.0])
    assert lean == pytest.approx([0.0, 2.0, 0.0, 5.0])
    assert known.tolist() == [1, 1, 0, 1]


def test_an_alarm_offers_its_rows_and_parameters(
    sound_cell: tuple[WatchedCell, np.ndarray], tmp_path: Path
) -> None:
    watcher = sound_cell[0].watcher
    machine, learnt = watcher.machine, watcher.learnt
    assert learnt is not None
    friction = next(each for each in machine.hypotheses if each.name == "friction_level")
    cause = Explanation("friction_level", friction, 0.25, 0.01, 300.0, 0.0, 50.0)
    designed = list[dict[str, float]]()

    def design(parameters: dict[str, float], path: Path) -> None:
        designed.append(dict(parameters))
        path.write_text("gains")

    ticks = ticks_of(sound_cell[0])
    system = "WarmupCell"
    files = write_offer(tmp_path / "alarm-1", system, machine, learnt, ticks, [cause], design)
    assert files == [WINDOW_FILE, EXPERIMENT_FILE, MODEL_FILE, LAW_FILE]
    written = parameters_of(tmp_path / "alarm-1" / MODEL_FILE)
    offered = {name: quantity(text, RIG.unit(name)) for name, text in written.items()}
    assert offered["motor.friction_factor"] == pytest.approx(1.25)
    assert offered == pytest.approx(designed[0])
    run = read_run(tmp_path / "alarm-1" / WINDOW_FILE, RIG)
    assert run.time.size == len(ticks)
    base = machine.outputs.index(RIG.columns["base_temperature"])
    assert run.readings[RIG.columns["base_temperature"]][3] == ticks[3].readings[base]
    offset = next(each for each in machine.hypotheses if each.reading.any())
    of_reading = replace_cause(cause, offset)
    files = write_offer(tmp_path / "two", system, machine, learnt, ticks, [of_reading], None)
    assert files == [WINDOW_FILE, EXPERIMENT_FILE]
    experiment = read_experiment(tmp_path / "two" / EXPERIMENT_FILE)
    assert experiment.known == pytest.approx(changed_parameters(machine, learnt, None))
    assert experiment.runs[0].time.size == len(ticks)


def replace_cause(cause: Explanation, hypothesis: object) -> Explanation:
    return cause._replace(hypothesis=hypothesis)  # type: ignore[arg-type]


@pytest.mark.slow
def test_a_law_that_no_longer_fits_is_an_alarm_of_its_own(table: np.ndarray, tmp_path: Path) -> None:
    rows = table.copy()
    after = rows[:, 0] > 3600 * SLIPS
    rows[after, HEADERS.index("base_temperature [degC]")] -= 3.0  # so that all is sound but the law
    growth = rows[:, HEADERS.index("elongation [um]")]
    correction = growth + np.random.default_rng(1).normal(0, 0.3, growth.size) - np.where(after, 4.0, 0.0)
    lines = lines_of(rows)
    text = [
        f"{lines[0]},correction [um]",
        *(f"{a},{b!r}" for a, b in zip(lines[1:], correction.tolist(), strict=True)),
    ]
    path = tmp_path / "cell.csv"
    path.write_text("\n".join(text) + "\n", "utf-8")
    found = watch(path, sound=f"{SOUND} h", alarms=f"{RATE} per day", out=tmp_path / "out")
    assert [each["verdict"] for each in found.alarms] == ["law"]
    assert "the law leaves +" in found.alarms[0]["told"]
    assert 0 < found.alarms[0]["time_s"] - 3600 * SLIPS < 1800
