"""Build the FMUs of many components, each under a temporary name until it is whole."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path

from warmlink.fmus.packaging.catalogue import Entry
from warmlink.fmus.packaging.python_fmu import build_python_fmu

PYTHON_FOLDER = "python"


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


def fmu_problems(path: Path) -> list[str]:
    """What FMPy's validation finds in an FMU: sentences, none where all is well."""
    from fmpy.validation import validate_fmu

    return list(validate_fmu(str(path)))
