"""A component as a Python FMU: pythonfmu's library, a slave, and the modules that it needs."""

from __future__ import annotations

import importlib.resources
from collections.abc import Callable, Iterable
from importlib import metadata
from pathlib import Path

from warmlink.fmus.catalogue import Entry
from warmlink.fmus.packaging import release
from warmlink.fmus.packaging.archive import write_archive
from warmlink.fmus.packaging.documentation import documentation_files
from warmlink.fmus.packaging.model_description import fmi2_model_description
from warmlink.fmus.packaging.python.bundle import bundle
from warmlink.fmus.packaging.references import reference_files
from warmlink.fmus.packaging.terminals import terminals_files

PYTHON_FOLDER = "python"

_SCRIPT = '''"""Entry of the FMU: pythonfmu's library looks for the class at the end."""

import ctypes

{imports}
from {slave} import ComponentSlave as Fmi2Slave
from {module} import {attribute} as declared

# pythonfmu 0.7.0 runs this file once more for every instance and then gives up a reference to the module's
# globals that is not its own; without this they would be freed under the running slave.
ctypes.pythonapi.Py_IncRef(ctypes.py_object(globals()))


class {name}(Fmi2Slave):
    component = declared
    form = "{form}"
'''


def python_fmu_files(entry: Entry) -> dict[str, bytes]:
    """Contents of the Python FMU of a component by path inside the archive.

    Parameters
    ----------
    entry : the component and where it is declared
    """
    component = entry.component
    slave = "warmlink.fmus.packaging.python.slave"
    carried = bundle((slave, entry.module), f"warmlink_{component.snake_name}")
    script = _SCRIPT.format(
        imports="\n".join(f"import {name}" for name in carried.modules.values()),
        slave=carried.modules[slave],
        module=carried.modules[entry.module],
        attribute=entry.attribute,
        name=component.name,
        form=carried.package,
    )
    stem = f"{carried.package}_slave"
    return {
        "modelDescription.xml": fmi2_model_description(
            component, native=False, implementation=carried.package
        ),
        **documentation_files(entry),
        **terminals_files(component),
        **reference_files(component),
        **_libraries(component.name),
        "documentation/licenses/pythonfmu.txt": _pythonfmu_license(),
        "resources/slavemodule.txt": stem.encode(),
        f"resources/{stem}.py": script.encode(),
        **{f"resources/{path}": content for path, content in carried.files.items()},
    }


def build_python_fmu(entry: Entry, folder: Path) -> Path:
    """Write `<Name>.fmu` of a component into a folder and return its path."""
    target = folder / f"{entry.component.name}.fmu"
    write_archive(target, python_fmu_files(entry))
    return target


def _libraries(identifier: str) -> dict[str, bytes]:
    """Libraries of pythonfmu for the platforms that it has, by path inside the archive."""
    found = {}
    platforms = importlib.resources.files("pythonfmu") / "resources" / "binaries"
    for platform in platforms.iterdir():
        for library in platform.iterdir():
            suffix = Path(library.name).suffix
            if suffix in (".so", ".dll", ".dylib"):
                found[f"binaries/{platform.name}/{identifier}{suffix}"] = library.read_bytes()
    return found


def _pythonfmu_license() -> bytes:
    for file in metadata.files("pythonfmu") or []:
        if file.name.startswith("LICENSE"):
            return file.read_binary()
    return release.LICENSE.encode()


def build_python_fmus(
    entries: Iterable[Entry], out: Path, progress: Callable[[str], None] = lambda name: None
) -> list[Path]:
    """Write the Python FMUs of components and return their paths, in the order of the components.

    Parameters
    ----------
    entries : from `catalogue()`, or of one's own
    out : `dist`, say; the FMUs are put into its folder `python`, as `<Name>.fmu`
    progress : called with the name of each FMU that is done
    """
    built = []
    for entry in entries:
        built.append(build_python_fmu(entry, out / PYTHON_FOLDER))
        progress(entry.component.name)
    return built
