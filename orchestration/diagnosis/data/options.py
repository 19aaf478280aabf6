"""What the user says of the files to read, beside what stands in them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from warmlink.fmus.arguments import argument
from warmlink.fmus.errors import InputError
from warmlink.orchestration.machine import DEFAULT
from warmlink.orchestration.system.replacement import Replacements


@dataclass(frozen=True)
class ReadOptions:
    """How files are read: what the user gives beside what stands in them.

    Attributes
    ----------
    units : unit by header or name of a column
    common : units, each for every column of its quantity that has none
    names : name of a column or variable by header; "" leaves the column out
    decimal : "point", "comma", or "" for what the file shows
    replaced : FMUs in place of parts of the system
    machine : what bare measurements were made on: a shipped machine, or a file with an SSP and its roles
    """

    units: Mapping[str, str] = field(default_factory=dict)
    common: Sequence[str] = ()
    names: Mapping[str, str] = field(default_factory=dict)
    decimal: str = ""
    replaced: Replacements | None = None
    machine: str = DEFAULT


DEFAULT_OPTIONS = ReadOptions()


def read_options(
    units: Sequence[str] = (),
    names: Sequence[str] = (),
    decimal: str = "",
    replaced: Replacements | None = None,
    machine: str = DEFAULT,
) -> ReadOptions:
    """How columns are read, by the options of a command; InputError if an entry does not have its form."""
    for text in names:
        if "=" not in text:
            raise InputError(
                f"{argument('names', text)}: no name; write {argument('names', {text: 'VARIABLE'})}"
            )
    common = [text.strip() for text in units if "=" not in text]
    of_columns = _stripped(text.rpartition("=") for text in units if "=" in text)
    meant = _stripped(text.rpartition("=") for text in names)
    return ReadOptions(of_columns, common, meant, decimal, replaced, machine)


def _stripped(pairs: Iterable[tuple[str, str, str]]) -> dict[str, str]:
    return {name.strip(): value.strip() for name, _, value in pairs}
