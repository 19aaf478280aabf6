"""Builds the trivial slave of plain C, on which masters are tested and timed."""

from __future__ import annotations

import shutil
import subprocess
import tempfile
import zipfile
from pathlib import Path

from warmlink.fmus.errors import InputError
from warmlink.fmus.packaging.native.fmu import FmiVersion

SOURCE = Path(__file__).with_suffix(".c")

# Name, type, causality, initial, start; the position is the value reference. FMI 2.0's words.
_VARIABLES = (
    ("u", "Real", "input", "", "1"),
    ("y", "Real", "output", "exact", "0"),
    ("z", "Real", "output", "calculated", ""),
    ("rate", "Real", "parameter", "", "1"),
    ("gain", "Real", "parameter", "", "1"),
    ("fail_at", "Real", "parameter", "", "1e300"),
    ("largest_step", "Real", "parameter", "", "1e300"),
    ("fail_status", "Integer", "parameter", "", "0"),
    ("steps", "Integer", "output", "exact", "0"),
    ("switched", "Integer", "input", "", "0"),
    ("on", "Boolean", "input", "", "false"),
    ("off", "Boolean", "output", "calculated", ""),
    ("label", "String", "parameter", "", "none"),
)
_DEPENDENCIES = {"y": (), "z": ("u",), "steps": (), "off": ("on",)}
_INITIAL_UNKNOWNS = {"z": ("u", "gain"), "off": ("on",)}
_REFERENCE = {row[0]: reference for reference, row in enumerate(_VARIABLES)}


def _description2() -> str:
    lines = []
    for reference, (name, kind, causality, initial, start) in enumerate(_VARIABLES):
        variability = {"parameter": "tunable"}.get(causality, "continuous" if kind == "Real" else "discrete")
        lines.append(
            f'<ScalarVariable name="{name}" valueReference="{reference}" causality="{causality}" '
            f'variability="{variability}"{_given("initial", initial)}><{kind}{_given("start", start)}/>'
            "</ScalarVariable>"
        )

    def unknowns(table: dict[str, tuple[str, ...]]) -> str:
        return "".join(
            f'<Unknown index="{_REFERENCE[name] + 1}" '
            f'dependencies="{" ".join(str(_REFERENCE[d] + 1) for d in on)}"/>'
            for name, on in table.items()
        )

    return (
        '<?xml version="1.0" encoding="UTF-8"?>'
        '<fmiModelDescription fmiVersion="2.0" modelName="Trivial" guid="{trivial-2}">'
        '<CoSimulation modelIdentifier="Trivial" canHandleVariableCommunicationStepSize="true" '
        'canInterpolateInputs="true" maxOutputDerivativeOrder="1" canGetAndSetFMUstate="true" '
        'canSerializeFMUstate="true"/>'
        f"<ModelVariables>{''.join(lines)}</ModelVariables>"
        f"<ModelStructure><Outputs>{unknowns(_DEPENDENCIES)}</Outputs>"
        f"<InitialUnknowns>{unknowns(_INITIAL_UNKNOWNS)}</InitialUnknowns></ModelStructure>"
        "</fmiModelDescription>"
    )


def _description3() -> str:
    lines = [f'<Float64 name="time" valueReference="{len(_VARIABLES)}" causality="independent"/>']
    for reference, (name, kind, causality, initial, start) in enumerate(_VARIABLES):
        element = {"Real": "Float64", "Integer": "Int32"}.get(kind, kind)
        head = f'<{element} name="{name}" valueReference="{reference}" causality="{causality}"'
        if causality == "parameter":
            head += ' variability="tunable"'
        if name == "u":
            head += ' intermediateUpdate="true"'
        head += _given("initial", initial)
        if kind == "String":
            lines.append(f'{head}><Start value="{start}"/></String>')
        else:
            lines.append(f"{head}{_given('start', start)}/>")

    def unknowns(element: str, table: dict[str, tuple[str, ...]]) -> str:
        return "".join(
            f'<{element} valueReference="{_REFERENCE[name]}" '
            f'dependencies="{" ".join(str(_REFERENCE[d]) for d in on)}"/>'
            for name, on in table.items()
        )

    return (
        '<?xml version="1.0" encoding="UTF-8"?>'
        '<fmiModelDescription fmiVersion="3.0" modelName="Trivial" instantiationToken="{trivial-3}">'
        '<CoSimulation modelIdentifier="Trivial" canHandleVariableCommunicationStepSize="true" '
        'providesIntermediateUpdate="true" maxOutputDerivativeOrder="1" canGetAndSetFMUState="true" '
        'canSerializeFMUState="true"/>'
        f"<ModelVariables>{''.join(lines)}</ModelVariables>"
        f"<ModelStructure>{unknowns('Output', _DEPENDENCIES)}"
        f"{unknowns('InitialUnknown', _INITIAL_UNKNOWNS)}</ModelStructure>"
        "</fmiModelDescription>"
    )


def _given(attribute: str, value: str) -> str:
    return f' {attribute}="{value}"' if value else ""


def build_trivial_fmu(folder: Path, version: FmiVersion = "2.0") -> Path:
    """Compile the trivial slave for this machine.

    Parameters
    ----------
    folder : Path
        Where `Trivial2.fmu` or `Trivial3.fmu` is written.

    Raises
    ------
    InputError
        Where no C compiler is found.
    """
    import fmpy

    compiler = shutil.which("gcc") or shutil.which("cc") or shutil.which("clang")
    if compiler is None:
        raise InputError("the trivial slave needs a C compiler: install gcc or clang")
    headers = Path(fmpy.__file__).parent / "c-code"
    place = fmpy.platform if version == "2.0" else fmpy.platform_tuple
    target = folder / f"Trivial{version[0]}.fmu"
    with tempfile.TemporaryDirectory() as scratch:
        library = Path(scratch) / f"Trivial{fmpy.sharedLibraryExtension}"
        flags = ["-O2", "-fPIC", "-shared", "-w", f"-I{headers}", *(["-DFMI3"] if version == "3.0" else [])]
        subprocess.run([compiler, *flags, str(SOURCE), "-o", str(library), "-lm"], check=True)
        with zipfile.ZipFile(target, "w") as archive:
            archive.writestr("modelDescription.xml", _description2() if version == "2.0" else _description3())
            archive.write(library, f"binaries/{place}/{library.name}")
    return target
