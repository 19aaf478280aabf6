"""The FMU of a reduced part."""

from __future__ import annotations

from pathlib import Path

from warmlink.fmus.catalogue import Entry
from warmlink.fmus.packaging.archive import write_archive
from warmlink.fmus.packaging.native.compile import compilers, platforms_named
from warmlink.fmus.packaging.native.fmu import native_fmu_files
from warmlink.fmus.reduced_link.component import reduced_link
from warmlink.fmus.reduced_link.model import STORED, stored
from warmlink.orchestration.check.fmu import check_fmu
from warmlink.orchestration.files import fresh_file
from warmlink.orchestration.reduction.part import Part
from warmlink.orchestration.reduction.remarks import remarks


def write_fmu(part: Part, name: str, target: Path) -> list[str]:
    """Write the FMU of a reduced part, whose file is called `name`, and return what its checks found wrong.

    Beside the compiled link it holds the model, so that whatever needs its equations finds them.
    """
    component = reduced_link(target.stem, part.model)
    entry = Entry(component, "warmlink.fmus.reduced_link.component", remarks=remarks(part, name))
    files = native_fmu_files(entry, "2.0", compilers(platforms_named(None)))
    with fresh_file(target) as scratch:
        write_archive(scratch, {**files, STORED: stored(part.model)})
    return [f"{each.name}: {each.detail}" for each in check_fmu(target) if each.verdict == "fail"]
