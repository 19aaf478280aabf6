"""One process for each FMU."""

from __future__ import annotations

import os
import struct
import subprocess
import sys
import time
from multiprocessing.connection import Connection
from pathlib import Path

import numpy as np
import pytest

from warmlink.fmus.errors import InputError
from warmlink.orchestration.master.algorithms.iterated import FixedPoint
from warmlink.orchestration.master.run import simulate
from warmlink.orchestration.master.slaves.isolation import Isolation
from warmlink.orchestration.master.slaves.other_process import OtherProcess, ProcessEndedError
from warmlink.orchestration.system.model import FmuPart, System, Value

from .pairs import wire

LIMITS = Isolation(time_limit=0.5)


def pair(fmu: Path, **values: Value) -> System:
    wires = (wire("a.y -> b.u"), wire("b.y -> a.u", factor=-1.0))
    parameters = {"y": 1.0, **values}
    return System("s", {"a": FmuPart("a", fmu), "b": FmuPart("b", fmu, {}, parameters)}, wires)


def single(fmu: Path, **values: Value) -> System:
    return System("s", {"b": FmuPart("b", fmu, {}, values)})


def test_isolated_slaves_give_the_same_values(trivial2: Path) -> None:
    inside = simulate(pair(trivial2), 3.0, 0.25, FixedPoint())
    outside = simulate(pair(trivial2), 3.0, 0.25, FixedPoint(), isolation=LIMITS)
    assert outside.status == "completed"
    np.testing.assert_array_equal(inside.table.values, outside.table.values)


def test_a_crash_is_named_and_the_results_are_kept(trivial2: Path) -> None:
    result = simulate(pair(trivial2, fail_at=2.1, fail_status=5), 5.0, 0.5, isolation=LIMITS)
    assert result.reason == "b: crash at 2 s: its process died in step (signal SIGSEGV)"
    np.testing.assert_array_equal(result.times, [0, 0.5, 1, 1.5, 2])
    assert np.all(np.isfinite(result.table.values))


def die_at_an_answer(pipe: Connection) -> None:
    """Write that an answer of 100 bytes follows, and the first four of them."""
    os.write(pipe.fileno(), struct.pack("!i", 100) + b"half")
    os._exit(7)


@pytest.mark.skipif(os.name == "nt", reason="a pipe of Windows has whole messages")
def test_a_process_that_dies_at_an_answer_has_ended() -> None:
    other = OtherProcess("other", die_at_an_answer)
    assert other.answer(60.0) is None
    with pytest.raises(ProcessEndedError, match="exit code 7"):
        other.answer(60.0)
    other.end()


def test_a_process_that_an_interruption_left_behind_does_not_outlive_its_parent() -> None:
    # It ignores SIGTERM, with which Python ends what is left at its exit, and then waits for.
    code = (
        "from warmlink.orchestration.master.slaves.other_process import OtherProcess\n"
        "from tests.orchestration.master.test_isolation import wait_for_ever\n"
        "other = OtherProcess('other', wait_for_ever)\n"
        "other.answer(60.0)\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60)


def wait_for_ever(pipe: Connection) -> None:
    """Be at something that has no end."""
    while True:
        time.sleep(1.0)


def test_a_step_that_never_returns_meets_the_time_limit(trivial2: Path) -> None:
    result = simulate(single(trivial2, fail_at=2.1, fail_status=6), 5.0, 0.5, isolation=LIMITS)
    assert "b: time limit at 2 s: step has not returned within 0.5 s" in str(result.reason)
    assert result.times[-1] == 2.0


def test_errors_cross_the_border_as_they_are(trivial2: Path) -> None:
    result = simulate(single(trivial2, fail_at=2.1, fail_status=3), 5.0, 0.5, isolation=LIMITS)
    assert result.reason == "b: error at 2 s: fmi2DoStep answered error; it logged: it fails from 2.1"
    with pytest.raises(InputError, match=r"b\.nothing: the FMU has no such variable"):
        simulate(single(trivial2, nothing=1.0), 1.0, 0.5, isolation=LIMITS)
