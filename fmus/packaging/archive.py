"""Archives whose bytes depend on their contents alone."""

import zipfile
from collections.abc import Mapping
from pathlib import Path

from warmlink.fmus.files import whole_file

_DATE = (1980, 1, 1, 0, 0, 0)
_COMPRESSION = 6  # 9 takes over twice as long and saves half a percent
_UNIX = 3
_FILE_MODE, _LIBRARY_MODE = 0o100644, 0o100755
_LIBRARIES = (".so", ".dll", ".dylib")


def write_archive(target: Path, files: Mapping[str, bytes]) -> None:
    """Write a zip archive (an FMU, say) under a temporary name, then rename it.

    Parameters
    ----------
    target : the archive; its folder is made where it is missing
    files : contents by path inside the archive, with forward slashes; written in the order of the paths,
        modelDescription.xml first
    """
    target.parent.mkdir(parents=True, exist_ok=True)
    with whole_file(target) as scratch, zipfile.ZipFile(scratch, "w") as archive:
        for path in sorted(files, key=lambda path: (path != "modelDescription.xml", path)):
            entry = zipfile.ZipInfo(path, _DATE)
            entry.create_system = _UNIX
            entry.external_attr = (_LIBRARY_MODE if path.endswith(_LIBRARIES) else _FILE_MODE) << 16
            archive.writestr(entry, files[path], zipfile.ZIP_DEFLATED, _COMPRESSION)
