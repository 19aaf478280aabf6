"""`warmlink export` with the parameter set that `warmlink design` writes."""

import re
import shutil
import subprocess
from pathlib import Path

import pytest

import warmlink as wl
from warmlink.controllers.export.c_files import source
from warmlink.controllers.export.core import Core, designed
from warmlink.orchestration.catalogue import controller
from warmlink.orchestration.cli import main
from warmlink.orchestration.system.ssp.parameter_values import write_ssv

OWN_LAW = Path(__file__).parents[1] / "studies" / "my_law.py"
EXPORT = ["warmlink", "export", "lag", "--design", "lag.ssv", "--out", "plc"]


def _code(text: str) -> str:
    """C without the comment that says what it was made of."""
    return text.partition("*/")[2]


def test_the_values_of_a_design_are_those_of_the_core(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    write_ssv(
        {"compensator.time_constant": 500.0, "motor.joint_conductance": 2.0}, Path("lag.ssv"), name="lag"
    )
    monkeypatch.setattr("sys.argv", EXPORT)
    with pytest.raises(SystemExit) as end:
        main()
    assert not end.value.code, capsys.readouterr().err
    wanted = _code(source(Core(designed(controller("lag"), {"time_constant": 500.0}), "lag", "double")))
    assert _code(Path("plc/lag.c").read_text("utf-8")) == wanted
    assert wanted != _code(source(Core(controller("lag"), "lag", "double")))


def test_a_law_of_ones_own_is_exported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    shutil.copy(OWN_LAW, "my_law.py")
    monkeypatch.setattr("sys.argv", ["warmlink", "export", "my_law.py:MyLaw"])
    with pytest.raises(SystemExit) as end:
        main()
    assert not end.value.code, capsys.readouterr().err
    written = Path(capsys.readouterr().out.split()[1])
    assert written.is_file()
    subprocess.run(["cc", "-std=c99", "-fsyntax-only", written], check=True)


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("motor.joint_conductance", "holds nothing for a compensator"),
        ("compensator.nosuch", "LagCompensator has no such variable"),
    ],
)
def test_what_is_no_design_of_the_law_is_refused(
    name: str, said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    write_ssv({name: 2.0}, Path("lag.ssv"))
    monkeypatch.setattr("sys.argv", EXPORT)
    with pytest.raises(SystemExit) as end:
        main()
    assert end.value.code == 2
    assert said in capsys.readouterr().err
    assert not Path("plc").exists()


@pytest.mark.platform
@pytest.mark.skipif(shutil.which("arm-none-eabi-gcc") is None, reason="arm-none-eabi-gcc is not installed")
def test_the_readme_states_what_the_law_that_is_recommended_needs() -> None:
    """At most 16 kB of code and constants, and 2 kB of stack."""
    readme = wl.export("regression").files["README.md"]
    rows = re.findall(r"^\| (Cortex-\w+) \| (\d+) \| (\d+) \|$", readme, re.MULTILINE)
    assert [name for name, _, _ in rows] == ["Cortex-M7", "Cortex-M4F"]
    for _, code, stack in rows:
        assert 1024 < int(code) < 16 * 1024
        assert 256 < int(stack) <= 2 * 1024
