"""The forward model against independent figures, an independent solver, and differences."""

from dataclasses import replace

import numpy as np
import pytest

from warmlink.orchestration.diagnosis.answer import separation
from warmlink.orchestration.diagnosis.causes.catalogue import catalogue
from warmlink.orchestration.diagnosis.data.measured import Run
from warmlink.orchestration.diagnosis.model.equations import Equations
from warmlink.orchestration.diagnosis.model.forward import Forward
from warmlink.orchestration.diagnosis.model.instruments import CLOCK, Readings
from warmlink.orchestration.diagnosis.model.simulation import NotSimulatedError
from warmlink.orchestration.diagnosis.model.steps import CHECK_CELLS, FINAL, SEARCH, Resolution, leaps
from warmlink.orchestration.diagnosis.practice.hidden import Truth, simulate
from warmlink.orchestration.diagnosis.practice.hide import INFORMATIVE
from warmlink.orchestration.machine.rig import rig
from warmlink.orchestration.scenarios.duties.duty import NO_PAD, Segment

OUTPUTS = (
    "motor.shaft_temperature",
    "motor.winding_temperature",
    "link.base_temperature",
    "link.sensor_temperature[2]",
    "link.tip_temperature",
    "link.elongation",
)
MICRO = np.array([1, 1, 1, 1, 1, 1e6])


def freed() -> list[str]:
    cell = rig("WarmupCell")
    return [v for cause in catalogue() if cause.kind == "plant" for v in cause.frees if v in cell.parameters]


def run_of(duty: tuple[Segment, ...], interval: float = 10.0) -> Run:
    return separation.run_of(duty, rig("WarmupCell"), [], 1.0, interval)


def forward(run: Run, resolution: Resolution, slots: list[str] | None = None) -> Forward:
    return Forward(Equations(rig("WarmupCell", resolution.cells), slots or [], OUTPUTS), run, {}, resolution)


def test_independent_figures_of_the_base_model_are_met() -> None:
    run = run_of((Segment(7200, 3.43, 2.5),))
    simulated = forward(run, FINAL)
    course = simulated(simulated.start_values(), np.array([600.0, 1800, 3600, 7200])).values
    assert course[:, 0] - 273.15 == pytest.approx([27.71, 35.78, 40.97, 43.40], abs=0.01)
    assert course[:, 5] * 1e6 == pytest.approx([14.07, 49.95, 75.77, 87.95], rel=1e-3)


@pytest.mark.parametrize("points", [1, 63, 64, 65, 130])
def test_outputs_are_those_of_each_point_however_many_there_are(points: int) -> None:
    equations = Equations(rig("WarmupCell", 10), ["link.emissivity"], OUTPUTS)
    random = np.random.default_rng(points)
    x = random.uniform(290, 320, (len(equations.states), points))
    w = np.zeros((len(equations.rig.externals), points))
    z, p, time = np.zeros(1), equations.parameter_values, np.arange(points, dtype=float)
    together = equations.observe(x, z, p, w, time)
    for k in {0, points // 2, points - 1}:
        alone = equations.observe(x[:, k : k + 1], z, p, w[:, k : k + 1], time[k : k + 1])
        for each, one in zip(together, alone, strict=True):
            assert np.array_equal(each[k], one[0])


def test_another_solver_gives_the_same() -> None:
    run = run_of(INFORMATIVE)
    simulated = forward(run, FINAL)
    ours = simulated(simulated.start_values(), run.time).values
    truth = simulate(Truth(), list(INFORMATIVE), run.time)
    theirs = np.column_stack(
        [truth.shaft, truth.winding, truth.base, truth.middle, truth.tip, truth.elongation]
    )
    error = np.abs(ours - theirs) * MICRO
    assert error.max(axis=0).max() < 0.03  # K and um, at the switching of a 60 W pad
    assert np.sqrt(np.mean(error**2, axis=0)).max() < 0.005


def test_finer_steps_converge_with_second_order() -> None:
    run = run_of((Segment(900, 3.43, 2.5),), 100.0)

    def course(step: float) -> np.ndarray:
        resolution = Resolution(20, step, 0.0, step, np.inf)
        simulated = forward(run, resolution)
        return simulated(simulated.start_values(), run.time).values[-1, :5]

    finest = course(0.5)
    coarse, fine = (np.abs(course(step) - finest).max() for step in (20.0, 10.0))
    assert np.log2(coarse / fine) > 1.8


@pytest.mark.slow
def test_sensitivities_equal_differences() -> None:
    slots = freed()
    duty = tuple(replace(s, pad_mode=NO_PAD) for s in INFORMATIVE[:6])
    run = run_of(duty, 60.0)
    simulated = forward(run, Resolution(20, 0.5, 0.05, 15.0, np.inf), slots)
    z = simulated.start_values()
    exact = simulated(z, run.time).by_slot
    spans = {c.frees[0]: c.upper for c in catalogue()}
    for i, slot in enumerate(slots):
        step = 1e-4 * (abs(z[i]) or spans.get(slot, 1.0))
        up, down = z.copy(), z.copy()
        up[i] += step
        down[i] -= step
        difference = (simulated(up, run.time).values - simulated(down, run.time).values) / (2 * step)
        scale = np.abs(difference).max(axis=0) + 1e-12
        # The matrix is held in the derivative of a step, which costs a little where heat changes fast.
        assert (np.sqrt(np.mean((exact[:, :, i] - difference) ** 2, axis=0)) / scale).max() < 0.02, slot


def test_values_are_the_same_without_derivatives() -> None:
    run = run_of(INFORMATIVE)
    cell = rig("WarmupCell", SEARCH.cells)
    each = (Equations(cell, freed(), OUTPUTS, derivatives) for derivatives in (True, False))
    both, alone = (Forward(equations, run, {}, SEARCH) for equations in each)
    z = both.start_values()
    np.testing.assert_allclose(alone(z, run.time).values, both(z, run.time).values, rtol=1e-12)
    assert alone(z, run.time).by_slot.shape == (run.time.size, len(OUTPUTS), 0)


PAD_GOES_OFF = (
    Segment(1310, 2.27, 0.7, 294.5),
    Segment.with_pad(26, 304.0, 5.0, 2.99, 293.65),
    Segment.with_pad(600, 304.0, 5.0, 2.99, 297.0),
)
"""The room changes before the shaft gets warmer than its pad: what the leap before did bends only then."""


@pytest.mark.parametrize("duty", [INFORMATIVE[:6], PAD_GOES_OFF])
def test_a_leap_that_comes_sooner_does_what_a_run_with_a_further_row_does(duty: tuple[Segment, ...]) -> None:
    run = run_of(duty, 13.0)
    equations = Equations(rig("WarmupCell", 10), [], OUTPUTS, derivatives=False)
    simulated, fine = Forward(equations, run, {}, FINAL), Resolution(10, 0.5, 0.05, 12.0, 3e-5)
    z = simulated.start_values()
    rows = leaps(simulated._table)
    assert rows.size == len(duty) - 1
    found = simulated.sooner(z, run.time, rows, 2).by_slot.reshape(run.time.size, len(OUTPUTS), -1, 2)
    as_logged = Forward(equations, run, {}, fine)(z, run.time).values
    for k, row in enumerate(rows.tolist()):
        half, whole = (
            Forward(equations, run.sooner(row, share), {}, fine)(z, run.time).values - as_logged
            for share in (0.5, 1.0)
        )
        for part, exact in enumerate((half, whole - half)):
            assert np.linalg.norm(found[:, :, k, part] - exact) < 0.02 * np.linalg.norm(exact)


@pytest.mark.parametrize("late", [0.0, -36.0])
def test_instruments_show_what_a_leap_of_the_inputs_does_to_them_too(late: float) -> None:
    run = run_of(INFORMATIVE[:5], 20.0)
    equations = Equations(rig("WarmupCell", 10), [], OUTPUTS, derivatives=False)
    slots, z = (CLOCK, "sensors.stem_conduction[3]", "sensors.lag[1]"), np.array([late, 0.05, 70.0])

    def readings(of: Run, resolution: Resolution) -> Readings:
        return Readings(Forward(equations, of, {}, resolution), OUTPUTS, slots, run.time)

    fine = Resolution(10, 0.5, 0.05, 12.0, 3e-5)
    rows = np.array([75, 99])  # the room becomes warmer, and a pad begins to heat
    found = readings(run, FINAL).sooner(z, rows, 2).reshape(run.time.size, len(OUTPUTS), 2, 2)
    as_logged = readings(run, fine)(z)[0]
    for k, row in enumerate(rows.tolist()):
        exact = readings(run.sooner(row, 1.0), fine)(z)[0] - as_logged
        error = np.abs(found[:, :, k].sum(axis=2) - exact)
        assert np.all(error < 0.02 * np.abs(exact).max(axis=0) + 2e-3 / MICRO)


@pytest.mark.filterwarnings("error")
def test_heat_that_makes_more_heat_without_end_is_refused() -> None:
    run = run_of(INFORMATIVE)
    simulated = forward(run, SEARCH, ["motor.viscosity_temperature_coefficient"])
    with pytest.raises(NotSimulatedError, match="not finite"):
        simulated(np.array([-0.5]), run.time)


def test_the_fine_grid_is_fine_enough() -> None:
    run = run_of(INFORMATIVE)
    fine = forward(run, FINAL)
    finer = Forward(Equations(rig("WarmupCell", CHECK_CELLS), [], OUTPUTS), run, {}, fine)
    courses = [each(each.start_values(), run.time).values for each in (fine, finer)]
    assert np.sqrt(np.mean(((courses[0] - courses[1]) * MICRO) ** 2, axis=0)).max() < 0.003


def test_noisy_inputs_are_averaged_without_bias() -> None:
    random = np.random.default_rng(0)
    time = np.arange(0.0, 3600.0, 1.0)
    torque = 2.5 + 1.0 * random.standard_normal(time.size)
    inputs = {"motor.speed": np.full(time.size, 2.0), "motor.torque": torque}
    ends = []
    for resolution in (SEARCH, Resolution(20, 1.0, 0.0, 1.0, np.inf)):
        simulated = forward(Run("noisy", time, inputs, {}), resolution)
        ends.append(simulated(simulated.start_values(), time[-1:]).values[0])
    assert np.abs((ends[0] - ends[1]) * MICRO)[[0, 2, 3, 4, 5]].max() < 0.01
