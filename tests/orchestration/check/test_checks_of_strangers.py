"""What the checks say of other people's FMUs: slow ones, those that lack a library, and proofs of nothing."""

from __future__ import annotations

import shutil
import subprocess
import sys
import time
import zipfile
from pathlib import Path

import pytest

from tests.orchestration.master.hand_written import compiled
from tests.orchestration.master.test_told import description
from warmlink import simulate
from warmlink.fmus.errors import InputError
from warmlink.orchestration.check import fmu
from warmlink.orchestration.check.fmu import check_fmu
from warmlink.orchestration.cli import main

pytestmark = pytest.mark.skipif(
    not sys.platform.startswith("linux"), reason="libraries are loaded as on Linux"
)
SINE = "double sin(double), absent(double); double f(double x) { return sin(x)"
TOLD = Path(__file__).parents[1] / "master" / "told.c"


def library(folder: Path, text: str, *flags: str) -> Path:
    """A library of a few lines of C."""
    compiler = shutil.which("gcc") or shutil.which("clang")
    if compiler is None:
        pytest.skip("needs a C compiler: install gcc or clang")
    (folder / "a.c").write_text(text)
    command = [compiler, "-fPIC", "-shared", "-w", "a.c", *flags, "-o", "a.so"]
    subprocess.run(command, cwd=folder, check=True)
    return folder / "a.so"


def test_a_library_that_does_not_name_libm_gets_a_remark(tmp_path: Path) -> None:
    """Nearly every host has loaded libm."""
    verdict, detail = fmu._loading(library(tmp_path, f"{SINE}; }}"), 10.0)
    assert (verdict, detail.startswith("does not name libm, whose sin it calls")) == ("remark", True)
    assert fmu._loading(library(tmp_path, f"{SINE}; }}", "-lm"), 10.0)[0] == "pass"


@pytest.mark.parametrize("flags", [(), ("-lm",)])
def test_a_library_that_needs_more_than_libm_fails(tmp_path: Path, flags: tuple[str, ...]) -> None:
    verdict, detail = fmu._loading(library(tmp_path, f"{SINE} + absent(x); }}", *flags), 10.0)
    assert verdict == "fail"
    assert "undefined symbol" in detail


def test_a_folder_with_a_blank_in_its_name_is_no_fault_of_a_library(tmp_path: Path) -> None:
    folder = tmp_path / "my fmus:1"
    folder.mkdir()
    assert fmu._loading(library(folder, "int f(void) { return 1; }"), 10.0)[0] == "pass"


def test_a_library_that_needs_python_says_so(tmp_path: Path) -> None:
    text = "extern char _Py_NoneStruct; char *f(void) { return &_Py_NoneStruct; }"
    verdict, detail = fmu._loading(library(tmp_path, text), 10.0)
    assert verdict == "remark"
    assert detail.startswith("needs Python in the host's process (undefined symbol: _Py_NoneStruct)")


def test_a_library_that_hangs_while_it_loads_is_left(tmp_path: Path) -> None:
    text = (
        "extern unsigned sleep(unsigned); __attribute__((constructor)) static void hang(void) { sleep(99); }"
    )
    assert fmu._loading(library(tmp_path, text), 0.5) == ("fail", "it has not loaded within 0.5 s")


def test_the_judgement_of_names_has_a_limit_too(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """FMPy takes minutes for some public FMUs."""
    made = compiled(tmp_path, TOLD, description("2.0"))
    monkeypatch.setattr(fmu, "_find_problems", never)
    began = time.monotonic()
    result = check_fmu(made, 0.5, cases=[])[0]
    assert time.monotonic() - began < 30.0
    assert (result.verdict, result.detail.split(";")[0]) == ("remark", "FMPy has not judged it within 0.5 s")


def never(pipe: object, path: Path) -> None:
    time.sleep(60.0)


def test_a_slow_fmu_is_checked_as_far_as_time_allows(tmp_path: Path) -> None:
    """Which is no fault of it."""
    text = TOLD.read_text().replace(
        "    s->r[FORWARD] = forward;", "    usleep(20000);\n    s->r[FORWARD] = forward;"
    )
    source = tmp_path / "slow.c"
    source.write_text(f"#include <unistd.h>\n{text}")
    slow = compiled(tmp_path, source, description("2.0", stepSize="0.001"))
    cases = ["runs its default experiment", "memory growth"]
    default, growth = check_fmu(slow, 3.0, cases)[-2:]
    assert default.verdict == "pass"
    assert default.detail.endswith("of 1000")
    assert (growth.verdict, "too few to see it grow" in growth.detail) == ("remark", True)


def test_no_pair_seen_is_no_pass(tmp_path: Path) -> None:
    text = """<fmiModelDescription fmiVersion="2.0" modelName="Told" guid="told">
    <CoSimulation modelIdentifier="Told" canHandleVariableCommunicationStepSize="true"/><ModelVariables>
    <ScalarVariable name="k" valueReference="0" causality="input"><Real start="1"/></ScalarVariable>
    <ScalarVariable name="{name}" valueReference="{reference}" causality="output"><Real/></ScalarVariable>
    </ModelVariables><ModelStructure><Outputs><Unknown index="2" dependencies="1"/></Outputs></ModelStructure>
    </fmiModelDescription>"""
    verdicts = {}
    for name, reference in (("y", 1), ("time", 5)):  # y moves with k
        made = compiled(tmp_path, TOLD, text.format(name=name, reference=reference))
        verdicts[name] = check_fmu(made, cases=["dependencies proven by perturbation"])[-1].verdict
    assert verdicts == {"y": "pass", "time": "remark"}


def test_parameters_that_instances_share_without_a_word_are_found(tmp_path: Path) -> None:
    text = TOLD.read_text().replace("++steps_of_all", "++s->r[STEPS]")
    (tmp_path / "own.c").write_text(text)
    text = text.replace("steps_of_all;", "shared = 1;").replace("Y ? s->r[K]", "Y ? shared")
    (tmp_path / "shares.c").write_text(
        text.replace("s->r[v[i]] = x[i];", "s->r[v[i]] = x[i], shared = v[i] == K ? x[i] : shared;")
    )
    verdicts = {}
    for name in ("own.c", "shares.c"):
        made = compiled(tmp_path, tmp_path / name, description("2.0"))
        verdicts[name] = check_fmu(made, cases=["second instance"])[-1].verdict
    assert verdicts == {"own.c": "pass", "shares.c": "fail"}


def test_instances_that_a_process_may_hold_once_are_checked_one_in_a_process(tmp_path: Path) -> None:
    made = compiled(tmp_path, TOLD, description("2.0", canBeInstantiatedOnlyOncePerProcess="true"))
    cases = ["runs its default experiment", "second instance", "reproducible"]
    verdicts = {result.name: result.verdict for result in check_fmu(made, cases=cases)}
    assert verdicts["second instance"] == verdicts["reproducible"] == "skip"
    assert verdicts["runs its default experiment"] == "pass"


@pytest.mark.parametrize(("held", "verdict"), [("sources/told.c", "remark"), ("sources/", "fail")])
def test_an_fmu_of_source_code_alone_is_no_fault(tmp_path: Path, held: str, verdict: str) -> None:
    with zipfile.ZipFile(tmp_path / "Told.fmu", "w") as archive:
        archive.writestr("modelDescription.xml", description("2.0"))
        archive.writestr(held, b"")
    results = {each.name: each for each in check_fmu(tmp_path / "Told.fmu", cases=[])}
    assert results["platforms inside"].verdict == verdict
    with pytest.raises(InputError) as refusal:
        simulate(tmp_path / "Told.fmu", stop=1.0)
    assert ("compile its source code" in str(refusal.value)) == (verdict == "remark")


@pytest.mark.parametrize(
    ("files", "told"),
    [
        (["a/x.fmu", "y.ssp"], "is a folder, which holds a/x.fmu, y.ssp; check one of them: warmlink check "),
        ([], "is a folder without .fmu or .ssp files; give the path of one"),
        (["modelDescription.xml"], "is an unpacked FMU; pack it into a zip archive named .fmu"),
    ],
)
def test_of_a_folder_its_files_are_named(
    files: list[str],
    told: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    for name in files:
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).touch()
    monkeypatch.setattr("sys.argv", ["warmlink", "check", str(tmp_path)])
    with pytest.raises(SystemExit) as stop:
        main()
    assert stop.value.code == 2
    assert f"{tmp_path}: {told}" in " ".join(capsys.readouterr().err.split())
