"""A law as plain C: the numbers of its other forms, and C that strict compilers take."""

import re
import shutil
import subprocess
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.built import built
from tests.controllers.export.iec import hours, of_c, written
from tests.controllers.export.iec import run as run_library
from warmlink.controllers.export.c_files import header, readme, source
from warmlink.controllers.export.core import Core, Precision, designed
from warmlink.controllers.export.vectors import said
from warmlink.controllers.own import Law, component_of
from warmlink.controllers.replay import replay
from warmlink.fmus.component import State
from warmlink.fmus.packaging.native.compile import compilers, platforms_named
from warmlink.orchestration.catalogue import controllers

LAWS = sorted(name for name, component in controllers().items() if component.states)

FORESEEN = {"lag": {"other_heat_std": 0.0}}
"""Start values with which a law is ready as long as nothing odd is told: all heat comes from the duty."""

STRICT = (
    *("-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-Wconversion", "-Wfloat-equal", "-Wshadow"),
    "-Wdouble-promotion",
)


@cache
def core_of(law: str, precision: Precision) -> Core:
    """A law that ships; its program is made once, and its test vectors for both precisions."""
    core = Core(controllers()[law], law, precision)
    if precision == "single":
        vars(core)["vectors"] = core_of(law, "double").vectors
    return core


def run(folder: Path, law: str, *flags: str) -> str:
    """What the test program prints; it fails unless the test vectors are met."""
    (compiler,) = compilers(platforms_named(None))
    command = [*compiler.command, *STRICT, "-ffp-contract=off", *flags, f"{law}_test.c", f"{law}.c", "-lm"]
    texts = [(path.name, path.read_bytes()) for path in sorted(folder.glob("*.[ch]"))]
    program = built(command, texts, folder / "test")
    return subprocess.run([program], cwd=folder, check=True, capture_output=True, text=True).stdout


EACH = [
    pytest.param(n, marks=pytest.mark.slow) if n == "observer_drift" else n for n in LAWS if n != "observer"
]
"""The observer's C has no construct that observer_drift's has not."""


@pytest.mark.parametrize("precision", ["double", "single"])
@pytest.mark.parametrize("law", EACH)
def test_it_meets_its_test_vectors(law: str, precision: Precision, tmp_path: Path) -> None:
    """Sanitizers end a program that does what is undefined, or reads or writes beyond its own memory."""
    watched = "-fsanitize=address,undefined" if precision == "double" else "-fsanitize=undefined"
    folder = written(core_of(law, precision), tmp_path)
    assert "largest difference" in run(folder, law, "-O0", watched, "-fno-sanitize-recover")


ADVISORY = {"misra-c2012-8.9", "misra-c2012-12.1", "misra-c2012-12.3"}
"""Rules that an export's README says it departs from, and why."""

OF_THE_DESIGN = {"knownConditionTrueFalse", "duplicateCondition", "constParameter"}
"""Remarks of style: conditions that a design settles."""


@pytest.mark.platform
@pytest.mark.skipif(shutil.which("cppcheck") is None, reason="cppcheck is not installed")
@pytest.mark.parametrize("law", EACH)
def test_cppcheck_names_no_rule_of_misra_but_those_that_the_readme_lists(law: str, tmp_path: Path) -> None:
    folder = written(core_of(law, "single"), tmp_path)
    asked = ("--std=c99", "--enable=warning,style,performance,portability", "--addon=misra", f"{law}.c")
    done = subprocess.run(["cppcheck", *asked], cwd=folder, check=True, capture_output=True, text=True)
    found = set(re.findall(r"\[([\w.-]+)\]$", done.stderr, re.MULTILINE))
    assert found <= ADVISORY | OF_THE_DESIGN
    listed = re.findall(r"^- (\d+\.\d+):", (folder / "README.md").read_text("utf-8"), re.MULTILINE)
    assert {f"misra-c2012-{each}" for each in listed} == ADVISORY


@pytest.mark.parametrize("law", ["regression", pytest.param("observer", marks=pytest.mark.slow)])
def test_functions_fit_on_a_screen_and_none_calls_itself(law: str) -> None:
    text = source(core_of(law, "double"))
    functions = re.findall(r"^(?:static )?\w+ (\w+)\([^;{]*?\)\n\{\n(.*?)^\}", text, re.MULTILINE | re.DOTALL)
    assert len(functions) > 10
    for name, body in functions:
        copies = "begun_again" in name
        assert body.count("\n") <= (110 if copies else 75), name
        assert f"{name}(" not in body, name


def test_another_design_fails_the_test_vectors(tmp_path: Path) -> None:
    folder = written(core_of("lag", "double"), tmp_path)
    other = designed(controllers()["lag"], {"time_constant": 500.0})
    (folder / "lag.c").write_text(source(Core(other, "lag", "double")), encoding="utf-8")
    with pytest.raises(subprocess.CalledProcessError):
        run(folder, "lag", "-O0")


def test_it_has_no_variables_of_its_own_and_needs_the_mathematics_alone() -> None:
    text = source(core_of("observer", "single"))
    headers = {"observer.h", "math.h", "stdbool.h", "stddef.h"}
    assert set(re.findall(r"#include\W+(\S+)[\">]", text)) == headers
    assert not re.search(r"^static (?!const)[^()]*;", text, re.MULTILINE)
    assert not re.search(
        r"\b(malloc|calloc|free|printf|double)\b", re.sub(r"/\*.*?\*/", "", text, flags=re.S)
    )


@pytest.mark.parametrize("law", ["lag", "observer", "observer_drift"])
def test_the_readme_calls_the_functions_as_they_are_declared(law: str) -> None:
    core = core_of(law, "double")
    declared = dict(re.findall(r"^void (\w+)\(([^)]*)\);", header(core), re.MULTILINE))
    for name in (f"{law}_init", f"{law}_step"):
        (called,) = re.findall(rf"^    {name}\(([^)]*)\)", readme(core), re.MULTILINE)
        assert called.count(",") == declared[name].count(","), name


@pytest.mark.parametrize("precision", ["double", "single"])
@pytest.mark.parametrize("law", ["lag", "observer"])
def test_the_readme_states_the_memory_that_the_struct_takes(
    law: str, precision: Precision, tmp_path: Path
) -> None:
    """The bytes that keep `samples` in its place were not counted: 1596 for 1600."""
    folder = written(core_of(law, precision), tmp_path)
    (stated,) = re.findall(r"the struct `\w+` \| (\d+) bytes", (folder / "README.md").read_text("utf-8"))
    check = f'#include "{law}.h"\ntypedef char stated[sizeof({law}) == {stated} ? 1 : -1];\n'
    (folder / "size.c").write_text(check, encoding="utf-8")
    subprocess.run([*compilers(platforms_named(None))[0].command, "-c", "size.c"], cwd=folder, check=True)


@pytest.mark.parametrize("precision", ["double", "single"])
@pytest.mark.parametrize(
    "law",
    ["analytic", "lag", "regression", "observer"],
)
def test_readings_that_no_number_should_hold_leave_it_sound(
    law: str, precision: Precision, tmp_path: Path
) -> None:
    """Once a thermometer told 1e20 K, an observer in single precision was never ready again."""
    core = core_of(law, precision)
    if law in FORESEEN:
        core = Core(designed(core.component, FORESEEN[law]), law, precision)
    component, folder = core.component, written(core, tmp_path)
    names = component.u.names
    wrong = ("base_temperature", "tip_temperature", "speed", "torque", "ambient_temperature")
    places = ", ".join(str(names.index(each)) for each in wrong)
    starts = ", ".join(repr(float(each.start)) for each in component.inputs)
    (folder / "wild.c").write_text(
        f"""#include <math.h>
#include <stdio.h>
#include <string.h>
#include "{law}.h"
int main(void)
{{
    {law}_real u[] = {{{starts}}};
    const int wrong[] = {{{places}}};
    const {law}_real wild[] = {{({law}_real)1e20, ({law}_real)-1e20, ({law}_real)NAN, ({law}_real)INFINITY}};
    {law} it;
    int i, j, k;
    {law}_inputs given;
    memcpy(&given, u, sizeof given);
    {law}_init(&it, &given{", NULL, 0" if core.goes_on else ""});
    for (k = 0; k < 3000; k++) {{
        {law}_real now[{len(names)}];
        for (i = 0; i < {len(names)}; i++)
            now[i] = u[i];
        for (i = 0; i < 5; i++)
            now[i] += ({law}_real)(0.1 * ((k * 7 + i * 3) % 11 - 5) / 5.0);
        j = (k - 100) / 40;
        if (k >= 100 && k < 900 && k % 40 == 20)
            now[wrong[j / 4]] = wild[j % 4];
        memcpy(&given, now, sizeof given);
        {law}_step(&it, &given);
    }}
    printf("%g %g", (double)it.outputs.ready, (double)it.outputs.correction);
    return 0;
}}
""",
        encoding="utf-8",
    )
    (compiler,) = compilers(platforms_named(None))
    command = [*compiler.command, "-std=c99", "-O0", "wild.c", f"{law}.c", "-lm"]
    texts = [(path.name, path.read_bytes()) for path in sorted(folder.glob("*.[ch]"))]
    program = built(command, texts, folder / "wild")
    printed = subprocess.run([program], cwd=folder, check=True, capture_output=True, text=True).stdout
    ready, correction = map(float, printed.split())
    assert ready == 1.0
    assert abs(correction) < 2e-6


def test_after_a_restart_the_c_goes_on_as_the_fmu_does(tmp_path: Path) -> None:
    """What was recalled is forgotten by neither while the first readings may still be wrong."""
    core = core_of("observer", "double")
    rows, size = core.vectors.inputs, core.component.y.size
    c = run_library(of_c(core, tmp_path), rows, size, {100: 30.0})
    place = core.component.y.index
    kept = [c[99, place[name]] for name in core.component.y.names if name.startswith("retained[")]
    given = {f"recalled[{i}]": value for i, value in enumerate(kept, 1)} | {"recalled_for": 30.0}
    python = said(designed(core.component, given), rows[100:], core.period)
    correction = place["correction"]
    assert c[100, correction] == pytest.approx(c[99, correction], abs=1e-12)
    np.testing.assert_allclose(c[100:, correction], python[:, correction], rtol=0, atol=1e-12)
    np.testing.assert_array_equal(c[100:, place["ready"]], python[:, place["ready"]])


@pytest.mark.platform
@pytest.mark.parametrize("law", EACH)
def test_it_gives_the_numbers_of_the_fmu_where_duty_and_readings_are_missing(
    law: str, tmp_path: Path
) -> None:
    """A speed of NaN was told apart by the FMU and not by the C."""
    core = core_of(law, "double")
    names = core.component.u.index
    rows = hours(tuple(core.component.u.names), 3600).copy()
    rows[:, [names["measured_drift"], names["drift_valid"]]] = 0.0
    rows[1000:1060, names["speed"]] = np.nan
    rows[2000:2060, names["torque"]] = np.nan
    c = run_library(of_c(core, tmp_path), rows, core.component.y.size, {})
    fmu = replay(core.component, rows)
    place = core.component.y.index
    np.testing.assert_allclose(c[:, place["correction"]], fmu.correction, rtol=0, atol=1e-12)
    for flag in ("ready", "distrusted"):
        np.testing.assert_array_equal(c[:, place[flag]], getattr(fmu, flag))


def test_a_law_that_takes_no_missing_reading_is_exported_and_its_readme_says_so(tmp_path: Path) -> None:
    class Plain(Law):
        """Growth by one thermometer, whatever it reads."""

        states = (State("rise", "K"),)

        def update(self, x: Any, u: Any, p: Any, time: Any, step: Any) -> dict[str, Any]:
            return {"rise": u.base_temperature - 295.15}

        def correction(self, x: Any, u: Any, p: Any, time: Any) -> Any:
            return 5e-6 * x.rise

    core = Core(component_of(Plain), "plain", "double")
    folder = written(core, tmp_path)
    assert "largest difference" in run(folder, "plain", "-O0")
    assert "gives no number where a reading is missing" in (folder / "README.md").read_text("utf-8")
    assert "gives no number" not in readme(core_of("lag", "double"))
