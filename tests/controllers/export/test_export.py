"""A law as plain C: the numbers of its other forms, and C that strict compilers take."""

import re
import subprocess
from pathlib import Path

import pytest

from tests.built import built
from warmlink.controllers.export.core import Core, Precision, designed, export_files
from warmlink.fmus.packaging.native.compile import compilers, platforms_named
from warmlink.orchestration.catalogue import controllers

LAWS = sorted(name for name, component in controllers().items() if component.states)

STRICT = ("-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-Wdouble-promotion")


def written(core: Core, folder: Path) -> Path:
    for name, text in export_files(core).items():
        (folder / name).write_text(text, encoding="utf-8")
    return folder


def run(folder: Path, law: str, *flags: str) -> str:
    """What the test program prints; it fails unless the test vectors are met."""
    (compiler,) = compilers(platforms_named(None))
    command = [*compiler.command, *STRICT, "-ffp-contract=off", *flags, f"{law}_test.c", f"{law}.c", "-lm"]
    texts = [(path.name, path.read_bytes()) for path in sorted(folder.glob("*.[ch]"))]
    program = built(command, texts, folder / "test")
    return subprocess.run([program], cwd=folder, check=True, capture_output=True, text=True).stdout


@pytest.mark.parametrize("precision", ["double", "single"])
@pytest.mark.parametrize(
    "law", [pytest.param(n, marks=pytest.mark.slow) if n.startswith("observer") else n for n in LAWS]
)
def test_it_meets_its_test_vectors(law: str, precision: Precision, tmp_path: Path) -> None:
    core = Core(controllers()[law], law, precision)
    assert "largest difference" in run(
        written(core, tmp_path), law, "-O0", "-fsanitize=undefined", "-fno-sanitize-recover"
    )


def test_another_design_fails_the_test_vectors(tmp_path: Path) -> None:
    folder = written(Core(controllers()["lag"], "lag", "double"), tmp_path)
    other = designed(controllers()["lag"], {"time_constant": 500.0})
    (folder / "lag.c").write_text(Core(other, "lag", "double").source(), encoding="utf-8")
    with pytest.raises(subprocess.CalledProcessError):
        run(folder, "lag", "-O0")


def test_it_has_no_variables_of_its_own_and_needs_the_mathematics_alone() -> None:
    source = Core(controllers()["observer"], "observer", "single").source()
    assert set(re.findall(r"#include\W+(\S+)[\">]", source)) == {"observer.h", "math.h"}
    assert not re.search(r"^static (?!const)[^()]*;", source, re.MULTILINE)
    assert not re.search(r"\b(malloc|calloc|free|printf|double)\b", source)


@pytest.mark.parametrize("law", ["lag", "observer", "observer_drift"])
def test_the_readme_calls_the_functions_as_they_are_declared(law: str) -> None:
    files = export_files(Core(controllers()[law], law, "double"))
    declared = dict(re.findall(r"^void (\w+)\(([^)]*)\);", files[f"{law}.h"], re.MULTILINE))
    for name in (f"{law}_init", f"{law}_step"):
        (called,) = re.findall(rf"^    {name}\(([^)]*)\)", files["README.md"], re.MULTILINE)
        assert called.count(",") == declared[name].count(","), name


@pytest.mark.parametrize("precision", ["double", "single"])
@pytest.mark.parametrize("law", ["lag", "observer"])
def test_the_readme_states_the_memory_that_the_struct_takes(
    law: str, precision: Precision, tmp_path: Path
) -> None:
    """The bytes that keep `samples` in its place were not counted: 1596 for 1600."""
    folder = written(Core(controllers()[law], law, precision), tmp_path)
    (stated,) = re.findall(r"memory of the struct \| (\d+) bytes", (folder / "README.md").read_text("utf-8"))
    check = f'#include "{law}.h"\ntypedef char stated[sizeof({law}) == {stated} ? 1 : -1];\n'
    (folder / "size.c").write_text(check, encoding="utf-8")
    subprocess.run([*compilers(platforms_named(None))[0].command, "-c", "size.c"], cwd=folder, check=True)


@pytest.mark.parametrize("precision", ["double", "single"])
@pytest.mark.parametrize(
    "law",
    ["analytic", "lag", "regression", "observer", pytest.param("observer_drift", marks=pytest.mark.slow)],
)
def test_readings_that_no_number_should_hold_leave_it_sound(
    law: str, precision: Precision, tmp_path: Path
) -> None:
    """Once a thermometer told 1e20 K, an observer in single precision was never ready again."""
    component = controllers()[law]
    core = Core(component, law, precision)
    folder = written(core, tmp_path)
    upper = law.upper()
    wrong = [f"{upper}_{name.upper()}" for name in ("base_temperature", "tip_temperature", "speed", "torque")]
    starts = ", ".join(repr(float(each.start)) for each in component.inputs)
    (folder / "wild.c").write_text(
        f"""#include <math.h>
#include <stdio.h>
#include "{law}.h"
int main(void)
{{
    {law}_real u[] = {{{starts}}};
    const int wrong[] = {{{", ".join(wrong)}, {upper}_AMBIENT_TEMPERATURE}};
    const {law}_real wild[] = {{({law}_real)1e20, ({law}_real)-1e20, ({law}_real)NAN, ({law}_real)INFINITY}};
    {law} it;
    int i, j, k;
    {law}_init(&it, u{", 0, -1" if core.goes_on else ""});
    for (k = 0; k < 3000; k++) {{
        {law}_real now[{upper}_INPUTS];
        for (i = 0; i < {upper}_INPUTS; i++)
            now[i] = u[i];
        for (i = 0; i < 5; i++)
            now[i] += ({law}_real)(0.1 * ((k * 7 + i * 3) % 11 - 5) / 5.0);
        j = (k - 100) / 40;
        if (k >= 100 && k < 900 && k % 40 == 20)
            now[wrong[j / 4]] = wild[j % 4];
        {law}_step(&it, now);
    }}
    printf("%g %g", (double)it.outputs[{upper}_READY], (double)it.outputs[{upper}_CORRECTION]);
    return 0;
}}
""",
        encoding="utf-8",
    )
    (compiler,) = compilers(platforms_named(None))
    command = [*compiler.command, "-std=c99", "-O1", "wild.c", f"{law}.c", "-lm"]
    texts = [(path.name, path.read_bytes()) for path in sorted(folder.glob("*.[ch]"))]
    program = built(command, texts, folder / "wild")
    printed = subprocess.run([program], cwd=folder, check=True, capture_output=True, text=True).stdout
    ready, correction = map(float, printed.split())
    assert ready == 1.0
    assert abs(correction) < 2e-6
