"""The steps of a run in C and on CasADi's machine: the same numbers, and when which of them serves."""

from pathlib import Path

import numpy as np
import pytest

from tests.orchestration.diagnosis.loggers import Logger, logged_run
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.data.rig import rig
from warmlink.orchestration.diagnosis.model import equations as module
from warmlink.orchestration.diagnosis.model.equations import Equations
from warmlink.orchestration.diagnosis.model.forward import Forward
from warmlink.orchestration.diagnosis.model.integrator import Courses
from warmlink.orchestration.diagnosis.model.steps import SEARCH

SLOTS = ("link.emissivity", "motor.coulomb_friction", "link.ambient_temperature", "motor.ambient_temperature")
OUTPUTS = ("motor.shaft_temperature", "link.tip_temperature")
ROOM = Courses(((2, 3),), np.linspace(0.0, 7200.0, 9))


def simulated(slots: tuple[str, ...] = SLOTS, derivatives: bool = True) -> tuple[Equations, list[Array]]:
    """Outputs, their derivatives by slot, and by a room that wanders, on inputs that change in many steps."""
    compiled = Equations(rig("WarmupCell", 10), slots, OUTPUTS, derivatives)
    run = logged_run(Logger(interval=8.0, jitter=3.0, room=0.8, pad_noise=0.1), seed=3)
    forward = Forward(compiled, run, {}, SEARCH)
    z = forward.start_values()
    course = forward(z, run.time)
    room = forward.responses(z, run.time, ROOM) if derivatives and slots else np.zeros(0)
    return compiled, [course.values, course.by_slot, room]


@pytest.mark.platform
@pytest.mark.parametrize(("slots", "derivatives"), [(SLOTS, True), (SLOTS, False), ((), True)])
def test_both_give_the_same_numbers(
    slots: tuple[str, ...], derivatives: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("WARMLINK_CACHE", str(tmp_path))
    monkeypatch.setattr(module, "_PAYS_FROM", np.inf)
    _, plain = simulated(slots, derivatives)
    monkeypatch.setattr(module, "_PAYS_FROM", 0)
    compiled, fast = simulated(slots, derivatives)
    if compiled.library() is None:
        pytest.skip("there is no C compiler")
    assert compiled.taken == 0
    for one, other in zip(plain, fast, strict=True):
        np.testing.assert_allclose(other, one, rtol=1e-9, atol=1e-9)


@pytest.mark.platform
def test_what_was_compiled_before_serves_at_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("WARMLINK_CACHE", str(tmp_path))
    monkeypatch.setattr(module, "_PAYS_FROM", 1)
    first, _ = simulated()
    if first.library() is None:
        pytest.skip("there is no C compiler")
    assert first.taken > 0
    assert simulated()[0].taken == 0


def test_without_a_compiler_casadi_serves(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("WARMLINK_CACHE", str(tmp_path))
    monkeypatch.setenv("CC", str(tmp_path / "no-compiler"))
    monkeypatch.setattr(module, "_PAYS_FROM", 1)
    compiled, _ = simulated()
    assert compiled.library() is None
    assert compiled.taken > 0
