from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from warmlink.controllers.own import Law, component_of
from warmlink.fmus.component import State
from warmlink.fmus.errors import InputError
from warmlink.orchestration.catalogue import controllers, load_own_law
from warmlink.orchestration.cli import main
from warmlink.orchestration.closed_loop.load import load_scenario
from warmlink.orchestration.fmu_store import FmuKind, FmuStore
from warmlink.orchestration.scenarios.scenario import Scenario
from warmlink.orchestration.studies.case import Outcome, case_of, run_case
from warmlink.orchestration.studies.compare import plan_on
from warmlink.orchestration.studies.workers import FmuSet

HERE = Path(__file__).parent
EXAMPLE = f"{HERE / 'my_law.py'}:MyLaw"

NONE_OF_IT = '"""Nothing."""\nfrom warmlink.controllers.own import Law\n'


def test_the_example_is_the_one_of_the_readme() -> None:
    readme = (HERE.parents[2] / "controllers" / "README.md").read_text("utf-8")
    assert (HERE / "my_law.py").read_text("utf-8").partition('"""\n\n')[2].strip() in readme


def outcome(kind: FmuKind, folder: Path, fmus: FmuSet, tmp_path: Path) -> Outcome:
    law = load_own_law(EXAMPLE)
    files = dict(fmus.files() if fmus.kind == kind else FmuStore(kind).files(set(fmus.contents)))
    files |= FmuStore(kind, tmp_path).of_controller(law)
    return run_case(case_of(brief(folder), ("MyLaw", "work", "nominal")), files)


def brief(folder: Path) -> Scenario:
    """Two minutes of work with the law."""
    scenario = load_scenario(str(folder / "work.toml"))
    return replace(scenario, duty=scenario.duty.until(120.0), controller=load_own_law(EXAMPLE))


def test_a_law_of_ones_own_runs_as_native_and_as_python_fmu(
    folder: Path, fmus: FmuSet, tmp_path: Path
) -> None:
    native, python = (outcome(kind, folder, fmus, tmp_path) for kind in ("native", "python"))
    assert native.stopped is None
    assert native.max_abs_um == pytest.approx(python.max_abs_um, rel=1e-9)
    none = run_case(
        case_of(brief(folder), ("", "", "")),
        {**fmus.files(), **FmuStore("native", tmp_path).of_controller(load_own_law(EXAMPLE))},
    )
    assert none.max_abs_um == native.max_abs_um


def test_it_has_the_connectors_of_every_controller() -> None:
    own, shipped = load_own_law(EXAMPLE).component, controllers()["lag"]
    assert (own.inputs, own.outputs, own.terminals) == (shipped.inputs, shipped.outputs, shipped.terminals)


def test_it_becomes_a_row_of_compare(
    folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(folder)
    arguments = ["compare", "--controllers", "none", "--with", EXAMPLE, "--duty-cycles", "work.toml"]
    arguments += ["--mismatch", "nominal", "--no-report", "--out", "here", "--jobs", "1"]
    monkeypatch.setattr("sys.argv", ["warmlink", *arguments])
    with pytest.raises(SystemExit) as stop:
        main()
    assert stop.value.code == 0, capsys.readouterr().err
    names = [line.partition(",")[0] for line in (folder / "here" / "compare.csv").read_text().splitlines()]
    assert names == ["controller", "none", "MyLaw"]


def test_a_component_serves_as_well_as_a_class(tmp_path: Path) -> None:
    path = tmp_path / "mine.py"
    path.write_text(
        (HERE / "my_law.py").read_text()
        + "\n\nfrom warmlink.controllers.own import component_of\n\nLAW = component_of(MyLaw)\n"
    )
    law = load_own_law(f"{path}:LAW")
    assert law.name == "LAW"
    assert law.component.name == "MyLaw"


@pytest.mark.parametrize(
    ("source", "name", "sentence"),
    [
        (None, "MyLaw", "there is no file"),
        ("def (", "MyLaw", "does not work (SyntaxError"),
        ("raise SystemExit(0)", "MyLaw", "does not work (SystemExit"),
        ("import nowhere_at_all", "MyLaw", "does not work (ModuleNotFoundError"),
        (NONE_OF_IT, "MyLaw", "MyLaw is no law"),
        (NONE_OF_IT + "MyLaw = 3", "MyLaw", "MyLaw is no law"),
        (NONE_OF_IT + "class MyLaw(Law):\n    pass", "MyLaw", "gives no correction"),
        (
            NONE_OF_IT
            + "class MyLaw(Law):\n    def correction(self, x, u, p, time):\n        return u.warmth",
            "MyLaw",
            "does not work (AttributeError",
        ),
        (
            NONE_OF_IT
            + "class MyLaw(Law):\n    def correction(self, x, u, p, time):\n        self.last = 3\n",
            "MyLaw",
            "MyLaw.last: a law cannot remember attributes",
        ),
        ("", "", "names no law"),
    ],
)
def test_what_is_no_law_is_refused_in_one_sentence(
    source: str | None, name: str, sentence: str, tmp_path: Path
) -> None:
    path = tmp_path / "mine.py"
    if source is not None:
        path.write_text(source)
    with pytest.raises(InputError) as refusal:
        load_own_law(f"{path}:{name}")
    assert sentence in str(refusal.value)
    assert "\n" not in str(refusal.value)


def test_a_law_that_is_no_plain_arithmetic_does_not_become_c(tmp_path: Path) -> None:
    path = tmp_path / "mine.py"
    path.write_text(
        NONE_OF_IT
        + "import math\n\nclass MyLaw(Law):\n    def correction(self, x, u, p, time):\n"
        + "        return math.exp(-u.speed) * 1e-6\n"
    )
    law = load_own_law(f"{path}:MyLaw")
    with pytest.raises(
        InputError, match=r"does not become a native FMU .*warmlink.fmus.component.arithmetic"
    ):
        FmuStore("native", tmp_path).of_controller(law)


def test_states_need_an_update() -> None:
    class Forgetful(Law):
        states = (State("x", "1"),)

        def correction(self, x: Any, u: Any, p: Any, time: Any) -> Any:
            return x.x

    with pytest.raises(InputError, match="has states, but no update"):
        component_of(Forgetful)


def test_a_system_with_a_law_of_one_s_own_joins_into_one_component(folder: Path) -> None:
    scenario = replace(load_scenario(str(folder / "work.toml")), controller=load_own_law(EXAMPLE))
    assert "compensator.correction" in scenario.joined().y.names


@pytest.mark.parametrize("name", ["LagCompensator", "NoCompensator", "ThermalLink"])
def test_a_law_with_the_name_of_a_component_is_refused(tmp_path: Path, name: str) -> None:
    """One file would stand for both: `none` and `lag` had the figures of the law."""
    text = (HERE / "my_law.py").read_text("utf-8")
    (tmp_path / "law.py").write_text(text.replace("class MyLaw", f"class {name}"), "utf-8")
    with pytest.raises(InputError, match=f"law.py:{name}: warmlink has a {name} of its own; rename yours"):
        load_own_law(f"{tmp_path / 'law.py'}:{name}")


def test_two_laws_of_one_component_are_refused(tmp_path: Path) -> None:
    text = (HERE / "my_law.py").read_text("utf-8")
    for name in ("one", "two"):
        made = f"{text}\n\n{name} = component_of(MyLaw)\n"
        made = f"from warmlink.controllers.own import component_of\n{made}"
        (tmp_path / f"{name}.py").write_text(made, "utf-8")
    places = [f"{tmp_path / name}.py:{name}" for name in ("one", "two")]
    with pytest.raises(InputError, match="MyLaw: two components of that name; rename one"):
        plan_on(controllers=places, duty_cycles=["stop_and_go"], mismatches=["nominal"])
