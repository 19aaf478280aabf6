"""FMUs of hand-written C, for tests of what a master tells them and hears from them."""

from __future__ import annotations

import re
import shutil
import zipfile
from pathlib import Path

import pytest

from tests.built import built


def compiled(folder: Path, source: Path, description: str) -> Path:
    """Compile a file of C into an FMU of this machine, whose version is that of its description.

    Functions of the standard that the file lacks answer with an error.
    """
    import fmpy

    compiler = shutil.which("gcc") or shutil.which("clang")
    if compiler is None:
        pytest.skip("the slave of this test needs a C compiler: install gcc or clang")
    version = int(re.findall(r'fmiVersion="(\d)', description)[0])
    identifier = re.findall(r'modelIdentifier="(\w+)"', description)[0]
    library = folder / f"{identifier}{fmpy.sharedLibraryExtension}"
    headers = Path(fmpy.__file__).parent / "c-code"
    # FMPy asks for every function of the standard; those of FMI 1.0 are all in the file.
    types = (headers / f"fmi{version}Functions.h").read_text()
    every = set(re.findall(rf"FMI{version}_Export \w+ +(fmi{version}\w+);", types))
    text = source.read_text()
    own = re.findall(rf"^\w[\w *]*?(fmi{version}\w+)\(", text, re.MULTILINE)
    own += [f"fmi{version}{name}" for name in re.findall(r"NAMED\((\w+)\)\(", text)]
    absent = "".join(f"int {name}(void) {{ return 3; }}\n" for name in sorted(every - set(own)))
    (folder / "present.c").write_text(text)
    (folder / "absent.c").write_text(absent)
    flags = ["-O1", "-fPIC", "-shared", "-w", f"-I{headers}", f"-DFMI={version}"]
    built([compiler, *flags, "present.c", "absent.c", "-lm"], (text, absent), library)
    place = fmpy.platform_tuple if version == 3 else fmpy.platform
    with zipfile.ZipFile(folder / f"{identifier}.fmu", "w") as archive:
        archive.writestr("modelDescription.xml", description)
        archive.write(library, f"binaries/{place}/{library.name}")
    return folder / f"{identifier}.fmu"
