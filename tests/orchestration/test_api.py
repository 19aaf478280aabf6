"""What notebooks and scripts use: the README's scripts, and that every result shows itself."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
import tomllib
from importlib.metadata import version
from pathlib import Path

import numpy as np
import pandas
import pytest

import warmlink as wl
from tests.pages import plots
from warmlink.fmus.errors import InputError
from warmlink.orchestration.arm.chain import NAME as ARM
from warmlink.orchestration.cli import main
from warmlink.orchestration.closed_loop.load import load_scenario
from warmlink.orchestration.fmu_store import FmuStore
from warmlink.orchestration.system.write import write_ssp
from warmlink.orchestration.written.quantities import positive

README = (Path(__file__).parents[2] / "README.md").read_text("utf-8")
(SCRIPT,) = re.findall(r"```python\n(.*?)```", README, re.DOTALL)


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a system."""
    folder = tmp_path_factory.mktemp("notebook")
    (folder / "dist").mkdir()
    scenario = load_scenario("stop_and_go")
    write_ssp(scenario.system(scenario.files(FmuStore("native"))), folder / "dist" / "WarmupCell.ssp")
    return folder


def test_the_script_of_the_readme_is_short_and_works(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert len([line for line in SCRIPT.splitlines() if line]) <= 10
    exec(SCRIPT, {})
    printed = capsys.readouterr().out
    assert "removed" in printed
    assert "error [m]" in printed
    assert Path("error.html").stat().st_size > 1e5
    assert "named ('joint_resistance',)" in printed


def test_every_name_is_there_and_says_what_it_does() -> None:
    assert {"run", "simulate", "read_system", "compare", "tune", "design"} < set(wl.__all__)
    assert {"diagnose", "build", "join", "linearise", "plot"} < set(wl.__all__)
    for name in wl.__all__:
        assert getattr(wl, name).__doc__, name
    assert wl.__version__ == version("warmlink")
    with pytest.raises(AttributeError, match=r"has no rum; did you mean run\?"):
        wl.rum  # noqa: B018


def test_a_type_checker_knows_every_name() -> None:
    """What is missing there would be taken for `Any`."""
    (block,) = (each for each in ast.parse(Path(wl.__file__).read_text()).body if isinstance(each, ast.If))
    found = list(ast.walk(block))
    known = {each.id for each in found if isinstance(each, ast.Name)}
    known |= {str(each.asname) for each in found if isinstance(each, ast.alias)}
    assert {*wl.__all__} <= known


def test_a_law_is_exported_and_a_run_made_up(tmp_path: Path) -> None:
    exported = wl.export("lag", {"compensator.time_constant": 500.0})
    assert repr(exported).startswith("lag: lag.c, lag.h, lag_test.c, README.md; ")
    exported.write(tmp_path / "plc")
    assert (tmp_path / "plc" / "lag.c").read_text("utf-8") == exported.files["lag.c"]
    duty = tmp_path / "work.toml"
    duty.write_text("stop_time = '10 min'\n[[segment]]\nduration = '10 min'\nspeed = '3 rad/s'\n")
    frame = wl.hide(["joint_resistance"], str(duty), seed=3)
    assert frame["time [s]"].iloc[-1] == pytest.approx(600.0, abs=10.0)
    assert frame.equals(wl.hide({"joint_resistance": 0.3}, str(duty), seed=3))


def test_sentences_speak_of_arguments_where_no_command_runs() -> None:
    for call, sentence in (
        (lambda: wl.hide(seed=-1), "seed=-1: is negative"),
        (
            lambda: wl.export("observer", precision="half"),  # type: ignore[arg-type]
            "precision='half': no such arithmetic; choose",
        ),
        (lambda: positive(-1.0, "1", "share"), "share: -1.0 is not positive; give a value above 0$"),
        (lambda: wl.hide(solver="grit"), "solver='grit': no such solver; did you mean grid"),
        (lambda: wl.hide(solver="fea", axis=1), "axis=1: .* leave solver='fea' out"),
        (lambda: wl.reduce("absent.step", ["#1"], "0, 0, 0 mm", mesh_size="a"), "`mesh_size`: "),
    ):
        with pytest.raises(InputError, match=sentence):
            call()


def test_sentences_on_data_speak_of_arguments_that_a_diagnosis_takes() -> None:
    times = np.arange(0.0, 600.0, 10.0)
    run = pandas.DataFrame({"time [s]": times, "T1 [degC]": 20 + 0 * times, "torque": times})
    for given, sentence in (
        ({}, r"or give units={'torque': 'N.m'}"),
        ({"units": {"torgue": "N.m"}}, r"^units={'torgue': 'N.m'}: no such column; did you mean torque"),
        ({"units": {"torque": "N.m"}}, r"say which is which with names={'T1': 'shaft_temperature'}"),
        ({"names": {"T1": "base"}, "units": {"torque": "N.m"}}, r"^names={'T1': 'base'}: base is no column"),
        (
            {"names": {"T1": "base_temperature", "torque": ""}},
            r"stood still: assume={'speed': '0', 'torque': '0', 'pad_temperature': 'off'}",
        ),
        (
            {"names": {"T1": "base_temperature", "torque": ""}, "assume": {"wind": 0}},
            r"^assume={'wind': '0'}: wind is no input",
        ),
        ({"decimal": "dot"}, r"^decimal='dot': "),
    ):
        with pytest.raises(InputError, match=sentence):
            wl.diagnose(run, **given)


def test_the_former_place_has_the_same_names_and_warns() -> None:
    from warmlink.orchestration import api

    assert {*api.__all__} == {*wl.__all__} - {"__version__"}
    assert api.InputError is wl.InputError
    with (
        pytest.warns(DeprecationWarning, match=r"api\.run will be removed in 0\.2\.0; use warmlink\.run"),
        pytest.raises(InputError, match="wiper: no such scenario"),
    ):
        api.run("wiper")
    with pytest.raises(AttributeError, match="api has no rum; import warmlink as wl"):
        api.rum  # noqa: B018


def test_importing_it_loads_nothing_heavy() -> None:
    script = (
        "import sys\nimport warmlink\n"
        "print([name for name in sys.modules if name.partition('.')[0] in ('warmlink', 'numpy')])"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "['warmlink']"


def test_results_show_themselves_and_give_a_frame(place: Path) -> None:
    outcome = wl.run("stop_and_go", "lag", stop="2 min", step="2 s")
    assert repr(outcome).startswith("stop_and_go · 2 min")
    assert outcome._repr_html_().startswith("<pre>stop_and_go")
    frame = outcome.to_frame()
    np.testing.assert_array_equal(frame["error [m]"], outcome.error)
    figure = wl.plot(outcome, "link.elongation", against=frame)
    assert [line.name for line in figure.data] == ["link.elongation", "link.elongation, the other"]
    np.testing.assert_array_equal(figure.data[0].y, figure.data[1].y)
    assert figure.layout.yaxis.title.text == "link.elongation [µm]"
    system = wl.read_system(place / "dist" / "WarmupCell.ssp")
    assert repr(system).startswith("WarmupCell: duty, motor, link")


def test_a_comparison_is_plotted_and_a_mismatch_may_be_a_path(tmp_path: Path) -> None:
    loose = tmp_path / "loose.toml"
    loose.write_text('[scale]\n"motor.joint_conductance" = 0.5\n')
    work = tmp_path / "work.toml"
    work.write_text("stop_time = '5 min'\n[[segment]]\nduration = '5 min'\nspeed = '3 rad/s'\n")
    found = wl.compare(["lag"], work, ["nominal", loose], options=wl.RunOptions(jobs=1))
    (cells,) = wl.plot(found).data
    assert (cells.x, cells.y) == (("none", "lag"), ("work",))
    worst = max(row.outcome.max_abs_um for row in found.rows.values() if row.controller == "lag")
    assert cells.text[0][1].startswith(f"{worst:.1f}")


def test_a_plot_of_nothing_named_shows_the_errors_that_are_there() -> None:
    only = pandas.DataFrame({"time [s]": [0.0, 1.0], "error [m]": [0.0, 1e-6]})
    assert [line.name for line in wl.plot(only).data] == ["error"]
    both = only.assign(**{"uncompensated_error [m]": 2e-6})
    assert [line.name for line in wl.plot(both).data] == ["uncompensated_error", "error"]


def test_a_design_goes_into_a_run(place: Path) -> None:
    found = wl.design(sensors=["base"], parameters={"link.length": "400 mm"})
    assert "plant: link.length changed from nominal" in repr(found)
    found.write(place / "observer.ssv")
    runs = [
        wl.run("stop_and_go", "observer", parameters=given, stop="2 min")
        for given in (found.parameters, place / "observer.ssv")
    ]
    assert runs[0].metrics == runs[1].metrics


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda: wl.run("wiper"), "wiper: no such scenario"),
        (lambda: wl.run(controller="lagg"), "lagg: no such controller; did you mean lag"),
        (lambda: wl.run(parameters={"link.lenght": 1}), "did you mean length"),
        (lambda: wl.simulate("absent.ssp"), "absent.ssp"),
        (lambda: wl.read_system("absent.ssp"), "absent.ssp: no such file"),
        (lambda: wl.assemble("s", {}, values={"link": {}}), "link: there is no component of this name"),
        (lambda: wl.assemble("s", {"link": "absent.fmu"}), "absent.fmu"),
        (lambda: wl.compare(mismatches=[]), "`mismatches`: names none"),
        (lambda: wl.run(fmus="pyhton"), "fmus='pyhton': no such kind; did you mean python?"),
        (lambda: wl.run(stop="soon"), "`stop`: 'soon'"),
        (
            lambda: wl.run(mismatches="thermal_hihg"),
            "thermal_hihg: no such mismatch; did you mean thermal_high",
        ),
        (lambda: wl.compare(system=ARM, controllers=["regression"]), "has no design for SixAxisArm"),
        (lambda: wl.design(law="lag"), "law='lag': has no design"),
        (lambda: wl.design(law="observer", sensor_std=0), "`sensor_std`: 0 is not positive"),
        (lambda: wl.design(law="regression", data=[]), "`data`: there is no log"),
        (lambda: wl.compare("lag", data=[]), "`data`: there is no log"),
        (lambda: wl.compare("lag", data="l.csv", system=ARM), "`system`: measured logs are compared as they"),
        (lambda: wl.simulate(wl.assemble("s", {}), 60, variant="a"), "variant='a': the system has been read"),
        (lambda: wl.diagnose(pandas.DataFrame({"a": [1.0]})), "time"),
        (lambda: wl.tune("absent"), "absent: no such study"),
        (lambda: wl.build(fmus="nativ"), "did you mean native"),
        (lambda: wl.plot("absent"), "absent: no results there"),
        (lambda: wl.plot(pandas.DataFrame({"time [s]": [0.0], "a [K]": [0.0]}), "b"), "b: no such variable"),
        (lambda: wl.plot(pandas.DataFrame({"time [s]": [0.0], "a [K]": [0.0]})), "is named, and the results"),
        (
            lambda: wl.plot(pandas.DataFrame({"time [s]": [0.0], "a [K]": [0.0]}), ["b"]),
            "b: no such variable",
        ),
        (
            lambda: wl.plot(pandas.DataFrame({"time [s]": [0.0], "a [K]": [0.0], "b [m]": 0.0}), "a", "b"),
            "is of K, m; name variables of one unit",
        ),
    ],
)
def test_what_cannot_be_used_ends_in_the_sentence_of_the_command(call: object, sentence: str) -> None:
    assert callable(call)
    with pytest.raises(InputError) as refusal:
        call()
    assert sentence in str(refusal.value)


def test_a_script_that_compares_needs_no_guard(tmp_path: Path) -> None:
    script = tmp_path / "script.py"
    (tmp_path / "work.toml").write_text(
        "stop_time = '60 s'\nrepeat = true\n[[segment]]\nduration = '60 s'\nspeed = '3 rad/s'\n"
    )
    script.write_text(
        "import warmlink as wl\nprint('begun')\n"
        "print(wl.compare(['none'], ['work.toml'], ['nominal'], options=wl.RunOptions(jobs=1)))\n"
    )
    done = subprocess.run(
        [sys.executable, script.name], capture_output=True, text=True, check=False, cwd=tmp_path
    )
    assert done.stdout.startswith("begun\nlargest error in um"), done.stderr
    assert "nan" not in done.stdout.lower()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["script.py", "work.toml"]


def test_results_are_plotted_as_page_and_picture(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    time = np.arange(5.0)
    frame = pandas.DataFrame({"time [s]": time, "link.elongation [m]": 1e-6 * time, "link.a [K]": time})
    frame["link.part[2] [K]"] = time
    for name in ("a", "b"):
        Path(name).mkdir()
        frame.to_csv(f"{name}/results.csv", index=False)

    def plotted(*arguments: str) -> tuple[int, str]:
        monkeypatch.setattr("sys.argv", ["warmlink", "plot", *arguments])
        with pytest.raises(SystemExit) as stop:
            main()
        return int(stop.value.code or 0), capsys.readouterr().err

    assert plotted("a", "link.elongation", "--against", "b", "--out", "plot.svg") == (0, "")
    assert "<svg" in Path("plot.svg").read_text("utf-8")
    assert plotted("a/results.csv", "link.a") == (0, "")
    assert "link.a [K]" in plots(Path("plot.html"))
    assert plotted("a", "link.part[2]") == (0, "")
    assert "link.part[2] [K]" in plots(Path("plot.html"))
    for arguments, sentence in (
        (("a", "link.b"), "link.b: no such variable in the results; did you mean link.a?"),
        (("a", "link.a", "--out", "plot.txt"), "is no page or picture"),
        (("c", "link.a"), "c: no results there"),
    ):
        code, told = plotted(*arguments)
        assert code == 2
        assert sentence in told
    # A plain `pip install` brings what draws it.
    project = tomllib.loads((Path(__file__).parents[2] / "pyproject.toml").read_text("utf-8"))["project"]
    assert any(each.startswith("matplotlib") for each in project["dependencies"])
    assert sorted(path.name for path in Path().iterdir()) == ["a", "b", "plot.html", "plot.svg"]


def test_a_notebook_shows_progress_and_nothing_else_does(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    wl.run("stop_and_go", "none", stop="1 min")
    assert "\r" not in capsys.readouterr().err
    monkeypatch.setitem(sys.modules, "ipykernel", None)
    wl.run("stop_and_go", "none", stop="1 min")
    shown = capsys.readouterr().err.split("\r")
    assert any(" %" in each for each in shown)
    assert shown[-2:] == [" " * 79, ""]


def test_a_file_is_checked(place: Path) -> None:
    found = wl.check(place / "dist" / "WarmupCell.ssp")
    assert not found.failed
    assert "reads and fits together" in repr(found)
    assert list(found.to_frame().columns) == ["name", "verdict", "detail"]
    with pytest.raises(InputError, match=r"dist: is a folder, which holds WarmupCell\.ssp"):
        wl.check(place / "dist")
