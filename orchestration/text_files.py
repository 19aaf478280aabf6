"""Text files that people write: they are read, or refused in one sentence."""

from __future__ import annotations

import codecs
import tomllib
from numbers import Integral, Real
from pathlib import Path
from typing import Any

from warmlink.fmus.errors import InputError

MOST_SHOWN = 80
"""Characters of a name or a value that a sentence repeats at most."""


def is_file(path: Path) -> bool:
    """Whether a file is there; False for a name that no file can have."""
    try:
        return path.is_file()
    except (OSError, ValueError):  # too long, or with a zero byte
        return False


def is_folder(path: Path) -> bool:
    """Whether a folder is there; False for a name that no folder can have."""
    try:
        return path.is_dir()
    except (OSError, ValueError):
        return False


def absent(path: Path, remedy: str, sought: str = "file") -> InputError:
    """What to raise if a file is needed, but nothing is there, or a folder."""
    there = "is a folder" if is_folder(path) else f"no such {sought}"
    return InputError(f"{path}: {there}; {remedy}")


def demand_file(path: Path, remedy: str) -> None:
    """Raise InputError, with the remedy, unless there is such a file."""
    if not is_file(path):
        raise absent(path, remedy)


def read_text(path: Path, remedy: str) -> str:
    """Text of a file in UTF-8, with or without a byte order mark.

    InputError if there is no such file (the sentence ends with the remedy), it cannot be read, or it is in
    another encoding.
    """
    try:
        return _content(path, remedy).decode("utf-8-sig")
    except UnicodeDecodeError as fault:
        line = fault.object[: fault.start].count(b"\n") + 1
        raise InputError(f"{path.name}: line {line} is not text in UTF-8; save the file as UTF-8") from None


def _content(path: Path, remedy: str) -> bytes:
    """Bytes of a file; InputError if there is none, or it cannot be read."""
    demand_file(path, remedy)
    try:
        return path.read_bytes()
    except OSError as fault:
        raise InputError(f"{path}: cannot be read ({fault.strerror}); check its permissions") from None


_OTHER_FORMATS = {
    b"MATLAB ": 'a MATLAB file; export its table there, as with writetable(t, "run.csv")',
    b"\x89HDF": "an HDF5 file, as MATLAB 7.3 and LabVIEW write; export the signals as columns of a CSV file",
    b"TDSm": "a TDMS file of LabVIEW; export it as CSV",
    b"PK\x03\x04": "a zip archive or a workbook; unpack it, or give the workbook its ending .xlsx",
    b"\xd0\xcf\x11\xe0": "an old Office file; give the workbook its ending .xls",
    b"PAR1": "a Parquet file; give it its ending .parquet",
    b"\x1f\x8b": "compressed with gzip; unpack it",
    b"SQLite format 3": "an SQLite database; export its table as CSV",
    b"\x93NUMPY": 'an array of NumPy; write it as CSV with numpy.savetxt(..., delimiter=",")',
    b"MDF ": "an MDF file; export the signals as columns of a CSV file",
}
"""Formats that are no text, by the first bytes of a file, and how their content becomes text."""


def measured_text(path: Path) -> str:
    """Text of a file of measurements in UTF-8, UTF-16 with its mark, or a spreadsheet's encoding on Windows.

    That is cp1252, or Latin-1 for bytes that cp1252 does not define. InputError if there is no such file, it
    cannot be read, or it holds no text.
    """
    content = _content(path, "give the path of a file")
    for mark, told in _OTHER_FORMATS.items():
        if content.startswith(mark) and b"\0" in content:
            raise InputError(f"{path.name}: is {told}")
    marked = content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
    for encoding in ("utf-16" if marked else "utf-8-sig", "cp1252", "latin-1"):
        try:
            text = content.decode(encoding)
        except UnicodeDecodeError:
            continue
        break
    if "\0" in text:
        raise InputError(f"{path.name}: is no text in UTF-8, UTF-16 or cp1252 (Windows); save it as UTF-8")
    return text


def read_toml(path: Path, remedy: str = "give an existing TOML file") -> dict[str, Any]:
    """Tables of a TOML file. Raises as `read_text` and `tables_of`."""
    return tables_of(read_text(path, remedy), path.name)


def tables_of(text: str, name: str) -> dict[str, Any]:
    """Tables of a TOML text; InputError if it is not TOML."""
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as fault:
        raise InputError(f"{name}: not readable as TOML ({fault}); mend that place") from None
    except ValueError:
        told = "a whole number has more digits than can be read; shorten it"
        raise InputError(f"{name}: not readable as TOML: {told}") from None
    except RecursionError:
        told = "lists or tables are nested too deep; nest them less"
        raise InputError(f"{name}: not readable as TOML: {told}") from None


def pair(text: str, option: str, example: str) -> tuple[str, str]:
    """Name and value of an option `NAME=VALUE`; InputError if one of them is missing."""
    name, equals, value = (part.strip() for part in text.partition("="))
    if not (name and value):
        missing = "no value" if name or not equals else "no name"
        raise InputError(f"{option} {text}: {missing}; write {option} {example}")
    return name, value


def shown(value: object) -> str:
    """A value from a file, in a few words for a sentence."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return repr(shortened(value))
    if isinstance(value, Real) and not isinstance(value, int):  # of NumPy too, whose repr names its type
        value = int(value) if isinstance(value, Integral) else float(value)
    if isinstance(value, float) or (isinstance(value, int) and abs(value) < 2**63):
        return repr(value)
    names = {int: "a number beyond 64 bits", list: "a list", dict: "a table", type(None): "nothing"}
    return names.get(type(value), f"a {type(value).__name__}")


def shortened(text: str) -> str:
    """The beginning of a text, as long as fits into a sentence."""
    return text if len(text) <= MOST_SHOWN else f"{text[:MOST_SHOWN]}..."
