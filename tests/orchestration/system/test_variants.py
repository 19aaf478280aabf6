"""Of several systems in one SSP one is chosen by its name, wherever an SSP is taken."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from tests.command import exit_code
from warmlink.fmus.errors import InputError
from warmlink.orchestration.check.checked import check
from warmlink.orchestration.describe import describe
from warmlink.orchestration.machine.heat_paths import rig_of
from warmlink.orchestration.system.assemble import read_system, variants
from warmlink.orchestration.system.ssp.ssd import DEFINITION_TYPE

from .ssp_text import Lab, component, connection, parameters, ssd, system, write_zip


@pytest.fixture
def two(lab: Lab) -> Path:
    """Give an SSP whose default couples motor and link, and whose variant `Long` does not."""
    coupled = lab.cell(connection("motor.heat_flow", "link.heat_flow"))
    return lab.ssp(coupled, {"Long.ssd": lab.cell(link=parameters("length:Real:3:m"))})


def test_a_variant_is_read_by_its_name_and_the_default_says_what_else_there_is(two: Path) -> None:
    assert read_system(two, variant="Long").components["link"].values == {"length": 3.0}
    assert read_system(two, variant="Long.ssd").remarks == ()
    found = read_system(two)
    assert len(found.connections) == 1
    assert found.remarks == (
        "cell1.ssp: SystemStructure is run, one of several variants; beside it Long; variant='Long' runs "
        "Long instead",
    )
    with pytest.raises(
        InputError, match=r"variant='Lung': no variant of the system in cell1.ssp; did you mean"
    ):
        read_system(two, variant="Lung")


def test_a_variant_of_an_fmu_is_refused_whatever_its_ending(lab: Lab) -> None:
    lab.entries()
    path = shutil.copyfile(lab.folder / "Motor.fmu", lab.folder / "a.zip")
    assert [*read_system(path).components] == ["a"]
    with pytest.raises(InputError, match=r"variant='VarB': no variant of the system in a\.zip"):
        read_system(path, variant="VarB")


def test_the_variant_that_is_run_by_default_is_first_and_parts_are_none(lab: Lab) -> None:
    whole = system(component("cell", "Part.ssd", attributes=f'type="{DEFINITION_TYPE}"'))
    more: dict[str, str | bytes] = {"Part.ssd": lab.cell(), "Other.ssd": lab.cell()}
    assert variants(lab.ssp(ssd(whole), more)) == ["SystemStructure", "Other"]


def test_without_a_default_no_variant_stands_for_one(lab: Lab) -> None:
    entries = {**lab.entries(), "B.ssd": lab.cell(), "A.ssd": lab.cell()}
    path = write_zip(lab.folder / "none.ssp", entries)
    assert variants(path) == ["A", "B"]
    with pytest.raises(InputError, match=r"none\.ssp: holds no SystemStructure\.ssd.*variant='A'"):
        read_system(path)


def test_a_variant_that_is_damaged_or_holds_itself_hinders_no_other(lab: Lab) -> None:
    def holding(name: str) -> str:
        return ssd(system(component("cell", f"{name}.ssd", attributes=f'type="{DEFINITION_TYPE}"')))

    path = lab.ssp(lab.cell(), {"Bad.ssd": "<", "A.ssd": lab.cell()})
    assert variants(path) == ["SystemStructure", "A", "Bad"]
    assert [*read_system(path).components] == ["motor", "link"]
    circle = write_zip(lab.folder / "circle.ssp", {"A.ssd": holding("B"), "B.ssd": holding("A")})
    with pytest.raises(InputError, match=r"holds no SystemStructure\.ssd.*but A and B; give"):
        read_system(circle)


def test_an_fmu_leaves_nothing_in_the_cache(lab: Lab, monkeypatch: pytest.MonkeyPatch) -> None:
    lab.entries()
    monkeypatch.setenv("WARMLINK_CACHE", str(lab.folder / "cache"))
    read_system(lab.folder / "Motor.fmu")
    assert not (lab.folder / "cache" / "systems").exists()


def test_list_and_check_name_the_variants_and_take_one(two: Path) -> None:
    assert describe(two).facts["variants"] == "SystemStructure, Long"
    assert describe(two).facts["connections"] == "1"
    assert describe(two, variant="Long").facts["connections"] == "0"
    found = [check(two, variant=each).results[0].detail for each in (None, "Long")]
    assert found == [f"2 components, {n} connections; variants: SystemStructure and Long" for n in (1, 0)]


def test_files_take_one_as_ssp_writes_it(two: Path) -> None:
    with pytest.raises(InputError, match=r"no variant of the system in cell1\.ssp; did you mean Long"):
        rig_of(f"{two.name}#Lung", two.parent)


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (
            ("check", "Motor.fmu"),
            "--variant Long: no variant of the system in Motor.fmu; leave the variant out",
        ),
        (
            ("list", "ThermalLink"),
            "--variant Long: ThermalLink has no variants, being no SSP; leave the variant out",
        ),
        (("list",), "--variant Long: is for one SSP; name it"),
        (("run", "warm_up"), "--variant Long: warm_up names no SSP; leave the variant out"),
        (("run", "mine.toml"), "--variant Long: the scenario's system is no SSP; leave the variant out"),
    ],
)
def test_what_has_no_variants_says_so(
    arguments: tuple[str, ...],
    sentence: str,
    lab: Lab,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    lab.entries()
    (lab.folder / "mine.toml").write_text('duty = "windshield_wiper"\n')
    monkeypatch.chdir(lab.folder)
    assert exit_code([*arguments, "--variant", "Long"], monkeypatch) == 2
    assert sentence in " ".join(capsys.readouterr().err.split())


def test_run_takes_a_variant_of_the_scenarios_system(
    two: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    roles = '[roles]\nscore = "link.elongation"\nspeed = "motor.ambient"\n'
    (two.parent / "mine.toml").write_text(f'system = "{two.name}"\nduty = "windshield_wiper"\n{roles}')
    monkeypatch.chdir(two.parent)
    assert exit_code(["run", "mine.toml", "--variant", "Lung"], monkeypatch) == 2
    assert "--variant Lung: no variant of the system in cell1.ssp" in " ".join(
        capsys.readouterr().err.split()
    )
