"""FMI 2.0 slaves: native ones of plain C, and one made with pythonfmu."""

from __future__ import annotations

import ctypes
import math
import os
import tempfile
import textwrap
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from warmlink.fmus.errors import InputError
from warmlink.fmus.packaging.native.compile import PLATFORMS
from warmlink.orchestration.master.algorithms.explicit import GaussSeidel, Jacobi
from warmlink.orchestration.master.assembly import assemble
from warmlink.orchestration.master.run import simulate
from warmlink.orchestration.master.slaves import library, versions
from warmlink.orchestration.master.slaves.slave import RunSpan
from warmlink.orchestration.master.slaves.versions import Fmi2Slave
from warmlink.orchestration.system.archive import unpack
from warmlink.orchestration.system.description import read_description
from warmlink.orchestration.system.model import Connection, FmuPart, System, Value

from .pairs import wire


def system(fmu: Path, *wires: Connection, **values: dict[str, Value]) -> System:
    components = {n: FmuPart(n, fmu, {}, v) for n, v in values.items()}
    return System("s", components, wires)


def test_all_types_are_set_and_got(trivial2: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    assembly = assemble(system(trivial2, a={}))
    (slave,) = assembly.slaves
    names = ("u", "fail_status", "on", "label", "rate")
    slave.set(names, [0.25, 3, True, "größe", 2.0])
    assert slave.get(names) == [0.25, 3, True, "größe", 2.0]
    assert slave.get(("off", "z")) == [False, 0.25]
    slave.terminate()
    slave.terminate()
    assert list(tmp_path.rglob("modelDescription.xml"))
    assembly.close()
    assert not list(tmp_path.rglob("modelDescription.xml"))


@pytest.mark.parametrize(
    ("declared", "asked"),
    [(("logEvents", "logStatusError"), [1]), (("logEvents",), []), ((), [4])],
)
def test_only_declared_categories_are_logged(
    trivial2: Path, declared: tuple[str, ...], asked: list[int], tmp_path: Path
) -> None:
    counts: list[int] = []

    class Watched(Fmi2Slave):
        def function(self, name: str) -> Any:
            if name == "SetDebugLogging":
                return lambda component, on, count, categories: counts.append(count)
            return super().function(name)

    info = replace(read_description(trivial2), log_categories=declared)
    Watched("a", info, unpack(trivial2, tmp_path)).terminate()
    assert counts == asked


@pytest.mark.parametrize("version", [2, 3])
def test_an_fmu_runs_from_a_folder_named_from_the_working_folder(
    version: int, request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fmu: Path = request.getfixturevalue(f"trivial{version}")
    monkeypatch.chdir(tmp_path)
    assembly = assemble(system(fmu, a={}), unpacked=Path("unpacked"))
    assert assembly.slaves[0].get(("gain",)) == [1.0]
    assembly.slaves[0].terminate()
    assert Path.cwd() == tmp_path


def test_an_fmu_runs_where_the_working_folder_is_gone(
    trivial2: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    gone = tmp_path / "gone"
    gone.mkdir()
    monkeypatch.chdir(gone)
    gone.rmdir()
    assert simulate(system(trivial2, a={}), 1.0, 0.5).status == "completed"


def test_what_is_kept_nowhere_is_no_hindrance(
    trivial2: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setenv("WARMLINK_CACHE", str(tmp_path / "file" / "below"))
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    (tmp_path / f"warmlink-cache-{os.getuid()}").touch()
    assert simulate(system(trivial2, a={}), 1.0, 0.5, stepping="plain").status == "completed"


def test_a_loop_of_two_equals_the_recursion(trivial2: Path) -> None:
    # x' = y, y' = -x by Jacobi with held inputs is the explicit Euler recursion.
    wires = (wire("a.y -> b.u"), wire("b.y -> a.u", factor=-1.0, offset=1.0))
    result = simulate(system(trivial2, *wires, a={}, b={"rate": 0.5}), 5.0, 0.25, Jacobi())
    x, y = 0.0, 0.0
    for point in range(21):
        assert result["a.y"][point] == x
        assert result["b.y"][point] == y
        x, y = x + 0.25 * (1.0 - y), y + 0.5 * 0.25 * x
    assert result["a.steps"][-1] == 20
    assert result.status == "completed"


def test_booleans_and_integers_travel(trivial2: Path) -> None:
    wires = (wire("a.off -> b.on"), wire("a.steps -> b.switched"))
    result = simulate(
        system(trivial2, *wires, a={"on": True}, b={}),
        3.0,
        1.0,
        GaussSeidel(),
        record=["b.off", "b.switched"],
    )
    np.testing.assert_array_equal(result["b.off"], [1, 1, 1, 1])
    np.testing.assert_array_equal(result["b.switched"], [0, 1, 2, 3])


def test_the_slaves_own_words_are_heard_after_somebody_else_listened(trivial2: Path) -> None:
    """The proxy for log calls, which FMPy itself may use in this process, tells one listener alone."""
    failing = system(trivial2, a={"fail_at": 3.5, "fail_status": 3})
    simulate(failing, 10.0, 1.0)
    fmpy, proxy = pytest.importorskip("fmpy.fmi2"), pytest.importorskip("fmpy.logging")
    deaf = fmpy.fmi2CallbackFunctions()
    deaf.logger = fmpy.fmi2CallbackLoggerTYPE(lambda *line: None)
    proxy.addLoggerProxy(ctypes.byref(deaf))
    assert "it logged: it fails from 3.5" in str(simulate(failing, 10.0, 1.0).reason)


@pytest.mark.parametrize("name", PLATFORMS)
def test_libraries_are_looked_for_where_our_own_fmus_have_them(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of Linux on ARM, as containers on a new Mac run, they were looked for where those of x86-64 are."""
    machine, _, system = name.partition("-")
    here = SimpleNamespace(platform={"windows": "win32"}.get(system, system), maxsize=2**63 - 1)
    monkeypatch.setattr(library, "sys", here)
    monkeypatch.setattr(library, "platform", SimpleNamespace(machine=lambda: machine))
    assert library.platform_name("fmi2") == PLATFORMS[name].fmi2
    assert library.platform_name("fmi3") == name


def test_where_fmpy_has_no_library_nobody_listens_to_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(versions, "platform_name", lambda prefix: "aarch64-linux")
    assert versions._proxy.__wrapped__() is None


@pytest.mark.parametrize(("status", "name"), [(2, "discard"), (3, "error"), (4, "fatal")])
def test_a_bad_status_stops_the_run_with_the_slaves_own_words(trivial2: Path, status: int, name: str) -> None:
    result = simulate(system(trivial2, a={}, b={"fail_at": 3.5, "fail_status": status}), 10.0, 1.0, Jacobi())
    assert result.error is not None
    assert (result.error.slave, result.error.status) == ("b", name)
    assert f"fmi2DoStep answered {name}; it logged: it fails from 3.5" in str(result.reason)
    assert result.times[-1] == 3.0
    assert np.all(np.isfinite(result.table.values))


def test_nan_from_an_fmu_is_named(trivial2: Path) -> None:
    result = simulate(system(trivial2, a={"fail_at": 3.5, "fail_status": 7}), 10.0, 1.0)
    assert result.error is not None
    assert (result.error.variable, result.error.time) == ("y", 4.0)


def test_states_restore_and_serialise(trivial2: Path) -> None:
    assembly = assemble(system(trivial2, a={}, b={}))
    a, b = assembly.slaves
    for slave in (a, b):
        slave.setup(RunSpan(0.0))
        slave.enter_initialization()
        slave.exit_initialization()
    a.step(0.0, 1.0)
    state, data = a.state(), a.serialize()
    a.step(1.0, 1.0)
    assert a.get(("y",)) == [2.0]
    a.restore(state)
    a.free(state)
    b.deserialize(data)
    assert a.get(("y",)) == b.get(("y",)) == [1.0]
    a.set(("u",), [1.0])
    a.set_input_derivatives(("u",), 1, [3.0])
    a.step(1.0, 2.0)
    assert a.get(("y",)) == [1.0 + 2.0 + 6.0]
    for slave in (a, b):
        slave.terminate()
    assembly.close()


def test_unknown_names_and_missing_platforms_are_said(trivial2: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"a\.nothing: the FMU has no such variable"):
        simulate(system(trivial2, a={"nothing": 1.0}), 1.0, 1.0)
    import zipfile

    other = tmp_path / "other.fmu"
    with zipfile.ZipFile(trivial2) as old, zipfile.ZipFile(other, "w") as new:
        new.writestr("modelDescription.xml", old.read("modelDescription.xml"))
        new.writestr("binaries/amiga/Trivial.library", b"")
    with pytest.raises(InputError, match=r"a: other\.fmu holds no library for .* \(it has: amiga\)"):
        simulate(system(other, a={}), 1.0, 1.0)


PYTHON_SLAVE = """
from pythonfmu import Boolean, Fmi2Causality, Fmi2Slave, Fmi2Variability, Real
from pythonfmu.enums import Fmi2Status

class Spring(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.u, self.y, self.label, self.broken = 1.0, 0.0, "", False
        self.register_variable(Real("u", causality=Fmi2Causality.input))
        self.register_variable(Real("y", causality=Fmi2Causality.output))
        self.register_variable(
            Boolean("broken", causality=Fmi2Causality.parameter, variability=Fmi2Variability.tunable))

    def do_step(self, t, h):
        if self.broken and t >= 2:
            self.log("the spring broke", Fmi2Status.error)
            return False
        self.y += h * self.u
        return True
"""


@pytest.fixture(scope="module")
def springs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    from pythonfmu.builder import FmuBuilder

    folder = tmp_path_factory.mktemp("python")
    script = folder / "spring_of_master_tests.py"
    script.write_text(textwrap.dedent(PYTHON_SLAVE))
    built: Path = FmuBuilder.build_FMU(str(script), dest=str(folder), needsExecutionTool="false")
    return Path(built)


def test_python_fmus_run_and_their_log_is_heard(springs: Path) -> None:
    wires = (wire("a.y -> b.u"), wire("b.y -> a.u", factor=-1.0))
    result = simulate(system(springs, *wires, a={}, b={"y": 1.0}), 1.0, 0.01, Jacobi())
    assert result.status == "completed"
    assert result["b.y"][-1] == pytest.approx(math.cos(1.0), abs=0.01)
    result = simulate(system(springs, a={"broken": True}), 5.0, 1.0)
    # pythonfmu answers fmi2Terminated for every step that returns False.
    assert result.reason == (
        "a: terminated at 2 s: fmi2DoStep answered discard and asks to end the simulation; "
        "it logged: the spring broke"
    )
