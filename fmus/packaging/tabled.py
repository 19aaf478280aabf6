"""FMUs that play another table than the one that they were built with: nothing is compiled anew."""

from __future__ import annotations

import hashlib
import re
import zipfile
from pathlib import Path

from warmlink.fmus.component.table import RecordedTable
from warmlink.fmus.errors import InputError
from warmlink.fmus.files import file_digest, write_archive
from warmlink.fmus.packaging.beside import FOLDER, STEPS, reference_files, table_files
from warmlink.fmus.packaging.cache import cache_folder, undamaged, used, vouch
from warmlink.fmus.packaging.model_description import tables_mark
from warmlink.fmus.recorded_duty.component import COMPONENT, playing

_TOKEN = re.compile(rb'( (?:guid|instantiationToken)="\{[^}"]*\})[^"]*')
"""The token of an FMU, and after it the mark of its tables."""


def with_table(fmu: Path, table: RecordedTable) -> Path:
    """FMU of RecordedDuty that plays a table, in the cache; the FMU itself where it plays that table.

    InputError if the table does not fit.
    """
    component = playing(COMPONENT, table)
    files = table_files(component)
    place = hashlib.sha256(f"{file_digest(fmu)} {table.digest}".encode()).hexdigest()[:32]
    path = cache_folder() / "tables" / place / fmu.name
    if undamaged(path):
        used(path.parent)
        return path
    with zipfile.ZipFile(fmu) as archive:
        held = {name: archive.read(name) for name in archive.namelist()}
    if all(held.get(name) == content for name, content in files.items()):
        return fmu
    about = held["modelDescription.xml"]
    version = "3.0" if b'fmiVersion="3.0"' in about else "2.0"
    marked = _TOKEN.sub(rb"\g<1>" + tables_mark(component).encode(), about, count=1)
    begins = playing(COMPONENT, table.until(STEPS * COMPONENT.default_step_size))
    tried = reference_files(begins, version) if any(name.startswith(FOLDER) for name in held) else {}
    write_archive(path, {**held, "modelDescription.xml": marked, **tried, **files})
    vouch(path)
    return path


def table_in(fmu: Path) -> RecordedTable:
    """Table that an FMU of RecordedDuty plays; InputError if it has none, or a damaged one."""
    (played,) = COMPONENT.tables
    try:
        with zipfile.ZipFile(fmu) as archive:
            content = archive.read(f"resources/{played.file}")
    except (OSError, KeyError, zipfile.BadZipFile):
        raise InputError(f"{fmu.name}: holds no table; build it anew with warmlink") from None
    return played.read(content, f"{fmu.name}: {played.file}").table
