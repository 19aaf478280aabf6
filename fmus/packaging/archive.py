"""Archives whose bytes depend on their contents alone."""

import os
import tempfile
import zipfile
from collections.abc import Mapping
from pathlib import Path

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
    handle, name = tempfile.mkstemp(dir=target.parent, prefix=f".{target.name}.")
    temporary = Path(name)
    try:
        with os.fdopen(handle, "wb") as stream, zipfile.ZipFile(stream, "w") as archive:
            for path in sorted(files, key=lambda path: (path != "modelDescription.xml", path)):
                archive.writestr(_entry(path), files[path], zipfile.ZIP_DEFLATED, _COMPRESSION)
        # mkstemp makes files that their owner alone may read.
        temporary.chmod(0o644)
        temporary.replace(target)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise


def _entry(path: str) -> zipfile.ZipInfo:
    entry = zipfile.ZipInfo(path, _DATE)
    entry.create_system = _UNIX
    entry.external_attr = (_LIBRARY_MODE if path.endswith(_LIBRARIES) else _FILE_MODE) << 16
    return entry
