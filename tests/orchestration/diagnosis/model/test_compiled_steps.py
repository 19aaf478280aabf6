"""The steps of a run in C and on CasADi's machine: the same numbers, and when which of them serves."""

import ctypes
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest

from tests.orchestration.diagnosis.loggers import HALF, PADDED, Logger, logged_run
from warmlink.fmus.errors import InputError
from warmlink.fmus.packaging.native.compile import PLATFORMS, compilers
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.model import equations as module
from warmlink.orchestration.diagnosis.model.equations import Equations
from warmlink.orchestration.diagnosis.model.forward import Forward
from warmlink.orchestration.diagnosis.model.integrator import Courses
from warmlink.orchestration.diagnosis.model.steps import SEARCH
from warmlink.orchestration.machine.rig import rig
from warmlink.orchestration.scenarios.duties.duty import Segment

SLOTS = ("link.emissivity", "motor.coulomb_friction", "link.ambient_temperature", "motor.ambient_temperature")
OUTPUTS = ("motor.shaft_temperature", "link.tip_temperature")
ROOM = Courses(((2, 3),), np.linspace(0.0, 7200.0, 9))


def simulated(
    slots: tuple[str, ...] = SLOTS, derivatives: bool = True, duty: Sequence[Segment] = HALF
) -> tuple[Equations, list[Array]]:
    """Outputs, and their derivatives by slot, by a room that wanders, and by when inputs change.

    The inputs change in many steps.
    """
    compiled = Equations(rig("WarmupCell", 10), slots, OUTPUTS, derivatives)
    run = logged_run(Logger(interval=8.0, jitter=3.0, room=0.8, pad_noise=0.1), seed=3, duty=duty)
    forward = Forward(compiled, run, {}, SEARCH)
    z = forward.start_values()
    course = forward(z, run.time)
    room = forward.responses(z, run.time, ROOM) if derivatives and slots else np.zeros(0)
    sooner = forward.sooner(z, run.time, np.arange(40, 360, 40), 2)
    return compiled, [course.values, course.by_slot, room, sooner.by_slot]


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
    monkeypatch.setattr(module, "_PAYS_FROM", np.inf)
    assert simulated()[0].taken == 0


@pytest.mark.platform
def test_a_long_course_is_compiled_before_it_begins(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """All of it went through CasADi's machine, which counted afterwards how much that had been."""
    monkeypatch.setenv("WARMLINK_CACHE", str(tmp_path))
    compiled, _ = simulated(duty=PADDED)
    if compiled.library() is None:
        pytest.skip("there is no C compiler")
    assert compiled.taken < module._PAYS_FROM


def test_without_a_compiler_casadi_serves(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("WARMLINK_CACHE", str(tmp_path))
    monkeypatch.setenv("CC", str(tmp_path / "no-compiler"))
    monkeypatch.setattr(module, "_PAYS_FROM", 1)
    compiled, _ = simulated()
    assert compiled.library() is None
    assert compiled.taken > 0


@pytest.mark.platform
@pytest.mark.parametrize("damage", [lambda content: content[: len(content) // 2], lambda _: b""])
def test_a_damaged_library_is_compiled_anew(
    damage: Callable[[bytes], bytes], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("WARMLINK_CACHE", str(tmp_path))
    monkeypatch.setattr(module, "_PAYS_FROM", 1)
    if simulated()[0].library() is None:
        pytest.skip("there is no C compiler")
    (file,) = (tmp_path / "steps").glob("*.kept")
    whole = file.read_bytes()
    file.write_bytes(damage(whole))
    assert simulated()[0].library() is not None
    assert file.read_bytes() == whole


@pytest.mark.platform
def test_where_nothing_compiled_may_be_loaded_casadi_serves(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("WARMLINK_CACHE", str(tmp_path))
    monkeypatch.setattr(module, "_PAYS_FROM", 1)
    if simulated()[0].library() is None:
        pytest.skip("there is no C compiler")

    def refuse(library: bytes) -> ctypes.CDLL:
        raise InputError("what was compiled does not load")

    monkeypatch.setattr(module, "loaded", refuse)
    found, _ = simulated()
    assert found.library() is None
    assert found.taken > 0


@pytest.mark.platform
def test_windows_finds_the_loop_in_the_library() -> None:
    try:
        (compiler,) = compilers([PLATFORMS["x86_64-windows"]])
    except InputError:
        pytest.skip("zig is not installed")
    built = Equations(rig("WarmupCell", 10), SLOTS, OUTPUTS)
    assert b"integrate\0" in compiler.library(built._sources, "steps")
