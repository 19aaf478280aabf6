"""Lines of a file that grows and may be rotated, as `tail -F` reads it, and of standard input."""

from __future__ import annotations

import os
import select
import sys
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import BinaryIO

from warmlink.fmus.errors import InputError
from warmlink.fmus.safe_text import of_cell
from warmlink.orchestration.scenarios.logged.layout import SEPARATORS, split
from warmlink.orchestration.text_files import demand_file
from warmlink.orchestration.watch.sources.protocol import FilePlace
from warmlink.orchestration.watch.sources.rows import Cells

_CHUNK, _POLL = 1 << 16, 0.2
"""Bytes that are read at once, and s between looks at what has not grown."""

_LONGEST = 1 << 20
"""Bytes without the end of a line from which on a file is no table."""


class LinesSource:
    """Lines of a file, followed while it grows, or of standard input.

    Parameters
    ----------
    path : None for standard input
    follow : whether to wait for more at the end of the file
    begin : where an earlier run ended; None to read from the beginning

    Raises
    ------
    InputError
        There is no such file, or it has no header line.
    """

    def __init__(self, path: Path | None, follow: bool, begin: FilePlace | None = None) -> None:
        if path is not None:
            demand_file(path, "give a file of measurements, - for standard input, or an address")
        self.name = "standard input" if path is None else path.name
        self.told: list[str] = []
        self._path, self._follow, self._number = path, follow, 0
        self._file = self._opened()
        self._rest, self._read = b"", 0
        line = next((each for each in self._lines() if each is None or _says(each)), None)
        if line is None:
            raise InputError(
                f"{self.name}: has no header line; head each column 'name [unit]', the first 'time [s]'"
            )
        self._head = line
        counts = {each: line.count(each) for each in SEPARATORS if each != " "}
        self._separator = max(counts, key=counts.__getitem__)
        self.comma = self._separator != ","
        self.headers: Sequence[str] = [of_cell(each).strip("\"' ") for each in split(line, self._separator)]
        if begin is not None and begin.read > self._read:
            self._seek(begin)

    def rows(self) -> Iterator[Cells | None]:
        """Rows as they come; None where there is nothing new for the moment."""
        for line in self._lines():
            if line is None:
                yield None
            elif _says(line) and line != self._head:
                yield split(line, self._separator)

    def place(self) -> FilePlace | None:
        """The end of the last whole line; None for standard input."""
        return None if self._path is None else FilePlace(self._read, self._number)

    def close(self) -> None:
        """Close the file."""
        if self._path is not None:
            self._file.close()

    def _opened(self) -> BinaryIO:
        if self._path is None:
            return sys.stdin.buffer
        try:
            opened = self._path.open("rb")
            self._number = os.fstat(opened.fileno()).st_ino
            return opened
        except OSError as fault:
            raise InputError(
                f"{self._path}: cannot be read ({fault.strerror}); check its permissions"
            ) from None

    def _seek(self, begin: FilePlace) -> None:
        """Go on where an earlier run was; a file that is another or shorter now was rotated meanwhile."""
        size = os.fstat(self._file.fileno()).st_size
        if self._number == begin.number and size >= begin.read:
            self._file.seek(begin.read)
            self._rest, self._read = b"", begin.read
        else:
            self.told.append(f"{self.name}: was rotated meanwhile, and is read from its beginning")

    def _lines(self) -> Iterator[str | None]:
        """Whole lines; None if there is nothing new. The last line of a file may lack its end."""
        while True:
            *lines, self._rest = self._rest.split(b"\n")
            for i, line in enumerate(lines):
                self._read += len(line) + 1
                text = line.decode("utf-8", "replace").strip("\r\ufeff")
                rest = b"\n".join([*lines[i + 1 :], self._rest])
                kept, self._rest = self._rest, rest  # so that whoever stops here can go on
                yield text
                self._rest = kept
            if len(self._rest) > _LONGEST:
                raise InputError(f"{self.name}: a line is longer than a megabyte; give a table of text")
            chunk = self._chunk()
            if chunk:
                self._rest += chunk
            elif chunk is None:
                yield None
            else:
                if self._rest:
                    self._read += len(self._rest)
                    text, self._rest = self._rest.decode("utf-8", "replace"), b""
                    yield text
                return

    def _chunk(self) -> bytes | None:
        """What is new; None if nothing is, and nothing at all at the end."""
        if self._path is None:
            ready, _, _ = select.select([self._file], [], [], _POLL)
            return os.read(self._file.fileno(), _CHUNK) if ready else None
        if chunk := self._file.read(_CHUNK):
            return chunk
        if not self._follow:
            return b""
        if not self._rotated():
            time.sleep(_POLL)
        return None

    def _rotated(self) -> bool:
        """Whether another file has the name, or this one was emptied; it is then read from its beginning."""
        assert self._path is not None
        try:
            now, here = self._path.stat(), os.fstat(self._file.fileno())
        except OSError:
            return False  # the name is free for a moment
        if os.path.samestat(now, here) and here.st_size >= self._file.tell():
            return False
        self._file.close()
        self._file = self._opened()
        self._rest, self._read = b"", 0
        self.told.append(f"{self.name}: was rotated, and is read from the beginning of the new file")
        return True


def _says(line: str) -> bool:
    return bool(line.strip()) and not line.startswith(("#", "%", "//"))
