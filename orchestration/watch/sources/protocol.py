"""What every source is."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple, Protocol

from warmlink.orchestration.watch.sources.rows import Cells


class FilePlace(NamedTuple):
    """Bytes of whole rows that were read from a file, and the file's number, which a rotated one has not."""

    read: int
    number: int


class Source(Protocol):
    """Rows of cells under headers, which are known once the source is open.

    Attributes
    ----------
    name : for sentences
    headers : as in a CSV file, `tip_temperature [degC]`
    comma : whether a comma is the decimal mark
    told : what is to be said of the source, as that it was rotated or is connected again; whoever says it
        empties it
    """

    name: str
    headers: Sequence[str]
    comma: bool
    told: list[str]

    def rows(self) -> Iterator[Cells | None]:
        """Rows as they come; None if there is nothing new for the moment. It ends with the source."""

    def place(self) -> FilePlace | None:
        """Where a restart may go on; None if the source cannot go back."""

    def close(self) -> None:
        """Let go of files and connections."""
