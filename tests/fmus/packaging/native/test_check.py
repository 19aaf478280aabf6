"""`check_fmu` finds nothing in ours, and finds each of the faults put into a damaged one."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree
from zipfile import ZipFile

import pytest

from warmlink.fmus.catalogue import catalogue
from warmlink.fmus.errors import InputError
from warmlink.fmus.files import write_archive
from warmlink.fmus.packaging.native import fmu as native_fmu
from warmlink.fmus.packaging.native.compile import Compiler
from warmlink.fmus.packaging.native.fmu import FmiVersion
from warmlink.fmus.packaging.python.fmu import build_python_fmus
from warmlink.orchestration.check import fmu
from warmlink.orchestration.check.cases import CASES
from warmlink.orchestration.check.fmu import TIME_LIMIT, CheckResult, check_fmu
from warmlink.orchestration.check.subject import Subject
from warmlink.orchestration.system.archive import unpack
from warmlink.orchestration.system.description import read_description

from .conftest import BuildNative

pytestmark = pytest.mark.skipif(
    not sys.platform.startswith("linux"), reason="libraries are loaded as on Linux"
)

NAME = "MotorHeatSource"
QUICK = [
    "state restore is bit-identical",
    "dependencies proven by perturbation",
    "directional derivatives",
    "second instance",
    "reproducible",
]

Damage = Callable[[dict[str, str]], None]
Build = Callable[[Damage, str], Path]


def insert(file: str, before: str, code: str) -> Damage:
    def damage(sources: dict[str, str]) -> None:
        assert before in sources[file]
        sources[file] = sources[file].replace(before, code + before, 1)

    return damage


def replace(file: str, old: str, new: str) -> Damage:
    def damage(sources: dict[str, str]) -> None:
        assert old in sources[file]
        sources[file] = sources[file].replace(old, new, 1)

    return damage


AT_END_OF_STEP = "    model->fresh = 0;\n    return well ? DONE : DISCARDED;"


@pytest.fixture
def damaged(c_compiler: Compiler, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Build:
    """Function of what to do to the sources, and of an FMI version, that gives the FMU's path."""
    (entry,) = (each for each in catalogue() if each.component.name == NAME)
    original = native_fmu.native_sources

    def build(damage: Damage, version: FmiVersion = "2.0") -> Path:
        def sources(*arguments: object) -> tuple[dict[str, str], str]:
            texts, digest = original(*arguments)
            damage(texts)
            return texts, digest

        monkeypatch.setattr(native_fmu, "native_sources", sources)
        path = tmp_path / f"{NAME}.fmu"
        write_archive(path, native_fmu.native_fmu_files(entry, version, [c_compiler]))
        return path

    return build


def by_name(results: list[CheckResult]) -> dict[str, CheckResult]:
    return {result.name: result for result in results}


@pytest.mark.slow
@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_nothing_is_found_in_a_sound_fmu(version: FmiVersion, native_fmu: BuildNative) -> None:
    results = check_fmu(native_fmu(NAME, version))
    assert [result for result in results if result.verdict != "pass"] == []
    steps = re.fullmatch(r"0 KiB over (\d+) steps.*", by_name(results)["memory growth"].detail)
    assert steps is not None
    assert int(steps[1]) >= 100_000  # twice as many where the time allows it
    assert len(results) == 10


@pytest.mark.slow
def test_every_fmu_of_ours_is_sound(native_fmu: BuildNative, tmp_path: Path) -> None:
    """In this process, which ends with one that crashes: two for each FMU take longer than the checks."""
    for entry in catalogue():
        path = native_fmu(entry.component.name, "2.0")
        subject = Subject(read_description(path), unpack(path, tmp_path), TIME_LIMIT)
        (library,) = subject.folder.glob("binaries/*/*")
        assert fmu._loading(library, TIME_LIMIT)[0] == "pass", entry.component.name
        found = {name: CASES[name](subject) for name in QUICK}
        assert [each for each in found.items() if each[1][0] == "fail"] == [], entry.component.name


def test_a_crash_is_reported_and_the_next_checks_are_made(damaged: Build) -> None:
    crash = insert("model_step.h", AT_END_OF_STEP, "    if (time >= 60) *(volatile int *)0 = 1;\n")
    found = by_name(check_fmu(damaged(crash), cases=["runs its default experiment", *QUICK]))
    assert found["runs its default experiment"] == CheckResult(
        "runs its default experiment", "fail", "the process died of SIGSEGV"
    )
    assert found["reproducible"].verdict == "pass"


def test_a_step_that_never_returns_is_left(damaged: Build) -> None:
    hang = insert(
        "model_step.h",
        AT_END_OF_STEP,
        "    extern unsigned sleep(unsigned seconds);\n    while (time >= 60) sleep(9);\n",
    )
    found = by_name(check_fmu(damaged(hang), 2.0, ["runs its default experiment", "reproducible"]))
    assert found["runs its default experiment"].verdict == "fail"
    assert found["runs its default experiment"].detail == "no answer within 2 s"
    assert found["reproducible"].verdict == "pass"


def test_a_number_that_is_none_is_named(damaged: Build) -> None:
    poison = insert("model_step.h", AT_END_OF_STEP, "    if (time >= 60) memory->states[1] = NAN;\n")
    found = by_name(check_fmu(damaged(poison), cases=["runs its default experiment"]))
    assert found["runs its default experiment"].detail == "heat_flow is nan at 61 s"


def test_a_leak_is_measured(damaged: Build) -> None:
    leak = insert("model_step.h", AT_END_OF_STEP, "    *(volatile char *)malloc(200) = 1;\n")
    found = by_name(check_fmu(damaged(leak), 2.4, ["memory growth"]))
    assert found["memory growth"].verdict == "fail"
    kibibytes = float(found["memory growth"].detail.split()[0])
    assert kibibytes > 100


def test_a_state_that_lacks_a_part_is_found(damaged: Build) -> None:
    forget = replace(
        "model_state.h",
        "    model->memory = *memory;\n",
        (
            "    double kept = model->memory.states[0];\n"
            "    model->memory = *memory;\n    model->memory.states[0] = kept;\n"
        ),
    )
    assert by_name(check_fmu(damaged(forget), cases=QUICK))[QUICK[0]].verdict == "fail"


@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_what_instances_share_is_found(damaged: Build, version: FmiVersion) -> None:
    share = insert(
        "model_step.h",
        AT_END_OF_STEP,
        "    static double shared;\n    memory->states[0] += shared += 1e-9;\n",
    )
    found = by_name(check_fmu(damaged(share, version), cases=QUICK))
    assert found["second instance"].verdict == "fail"
    assert found["reproducible"].verdict == "fail"


@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_a_wrong_derivative_is_found(damaged: Build, version: FmiVersion) -> None:
    wrong = replace("model_derivatives.h", ": direction->outputs[", ": 1.01 * direction->outputs[")
    found = by_name(check_fmu(damaged(wrong, version), cases=["directional derivatives"]))
    assert found["directional derivatives"].verdict == "fail"
    assert (
        "d heat_flow / d link_base_temperature: -1.01, by differences -1"
        in found["directional derivatives"].detail
    )


def test_a_missing_symbol_is_named(damaged: Build) -> None:
    missing = insert(
        "model_step.h",
        AT_END_OF_STEP,
        "    extern void _Py_Missing(void);\n    if (time < -1) _Py_Missing();\n",
    )
    found = by_name(check_fmu(damaged(missing), cases=[]))
    assert found["loads in a bare process"].verdict == "fail"
    assert "_Py_Missing" in found["loads in a bare process"].detail


def rewritten(source: Path, target: Path, change: Callable[[dict[str, bytes]], None]) -> Path:
    with ZipFile(source) as archive:
        files = {name: archive.read(name) for name in archive.namelist()}
    change(files)
    write_archive(target, files)
    return target


def test_an_undeclared_dependency_is_found(native_fmu: BuildNative, tmp_path: Path) -> None:
    def hide(files: dict[str, bytes]) -> None:
        text = files["modelDescription.xml"].decode()
        head, outputs, rest = text.partition("<Outputs>")
        rest = re.sub(
            r'dependencies="[^"]+" dependenciesKind="[^"]+"',
            'dependencies="" dependenciesKind=""',
            rest,
            count=1,
        )
        files["modelDescription.xml"] = (head + outputs + rest).encode()

    path = rewritten(native_fmu(NAME, "2.0"), tmp_path / "hidden.fmu", hide)
    (result,) = check_fmu(path, cases=["dependencies proven by perturbation"])[3:]
    assert result.verdict == "fail"
    assert result.detail == "heat_flow moves with link_base_temperature, which it does not declare"


def test_an_input_that_may_have_one_value_only_is_no_fault(native_fmu: BuildNative, tmp_path: Path) -> None:
    def hold(files: dict[str, bytes]) -> None:
        root = ElementTree.fromstring(files["modelDescription.xml"])
        (held,) = root.findall(".//ScalarVariable[@name='link_base_temperature']/Real")
        held.attrib |= {"min": held.attrib["start"], "max": held.attrib["start"]}
        files["modelDescription.xml"] = ElementTree.tostring(root)

    path = rewritten(native_fmu(NAME, "2.0"), tmp_path / "held.fmu", hold)
    found = by_name(check_fmu(path, cases=["directional derivatives"]))
    assert found["directional derivatives"].verdict == "pass", found


def test_a_choice_is_moved_to_its_own_items_alone(damaged: Build, tmp_path: Path) -> None:
    refuse = replace(
        "fmi_values.h",
        "well = set(handle, reference, kind, value);",
        "well = !(kind == ENUMERATION && value != 0 && value != 2) && set(handle, reference, kind, value);",
    )

    def leave_out(files: dict[str, bytes]) -> None:
        text = files["modelDescription.xml"].decode()
        files["modelDescription.xml"] = re.sub(r'<Item name="[a-z_]+" value="1"\s*/>', "", text).encode()

    path = rewritten(damaged(refuse, "3.0"), tmp_path / "choice.fmu", leave_out)
    found = by_name(check_fmu(path, cases=["dependencies proven by perturbation"]))
    assert found["dependencies proven by perturbation"].verdict == "pass", found


def test_an_fmu_that_asks_to_end_is_at_no_fault(damaged: Build) -> None:
    ask = replace(
        "fmi3_cs.c",
        "        *terminate = fmi3False;",
        "        *terminate = time >= 60 ? fmi3True : fmi3False;",
    )
    cases = ["runs its default experiment", "memory growth", "reproducible"]
    found = by_name(check_fmu(damaged(ask, "3.0"), cases=cases))
    assert found["runs its default experiment"].verdict == "pass"
    assert found["runs its default experiment"].detail == "60 s in steps of 1 s, where the FMU asks to end"
    assert found["memory growth"].verdict == "skip"
    assert found["memory growth"].detail == "the FMU asks to end at 60 s, before the check has"
    assert found["reproducible"].verdict == "pass"


def test_an_fmu_that_asks_to_end_before_its_first_step_fails(damaged: Build) -> None:
    ask = replace("fmi3_cs.c", "        *terminate = fmi3False;", "        *terminate = fmi3True;")
    found = by_name(check_fmu(damaged(ask, "3.0"), cases=["runs its default experiment"]))
    assert found["runs its default experiment"].verdict == "fail"


def test_an_fmu_for_other_platforms_is_not_run(native_fmu: BuildNative, tmp_path: Path) -> None:
    def move(files: dict[str, bytes]) -> None:
        for name in [name for name in files if name.startswith("binaries/")]:
            files[f"binaries/win64/{NAME}.dll"] = files.pop(name)

    found = by_name(check_fmu(rewritten(native_fmu(NAME, "2.0"), tmp_path / "other.fmu", move)))
    assert found["platforms inside"].detail == "win64"
    assert {result.verdict for result in found.values()} == {"pass", "skip"}


@pytest.mark.parametrize("content", [b"no archive", None])
def test_what_is_no_fmu_is_refused_in_a_sentence(content: bytes | None, tmp_path: Path) -> None:
    path = tmp_path / "x.fmu"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(InputError, match=r"x\.fmu: (not a readable zip archive|no such file)"):
        check_fmu(path)


def test_an_archive_without_a_description_is_refused_in_a_sentence(tmp_path: Path) -> None:
    write_archive(tmp_path / "x.fmu", {"a.txt": b"a"})
    with pytest.raises(InputError, match=r"x\.fmu: holds no modelDescription\.xml"):
        check_fmu(tmp_path / "x.fmu")


@pytest.mark.slow
def test_a_python_fmu_needs_python_and_is_otherwise_sound(tmp_path: Path) -> None:
    (entry,) = (each for each in catalogue() if each.component.name == "Heater")
    found = by_name(check_fmu(*build_python_fmus([entry], tmp_path), cases=QUICK))
    assert found["loads in a bare process"].verdict == "remark"
    assert "any other must load Python's library first" in found["loads in a bare process"].detail
    assert [r.name for r in found.values() if r.verdict == "fail"] == []
    assert found["directional derivatives"].verdict == "skip"
