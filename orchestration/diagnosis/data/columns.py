"""Which column of a file is which variable, and in which unit: by its header, or as the user says."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from difflib import SequenceMatcher

from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.orchestration.diagnosis.data.headings import (
    TIME,
    TIMES,
    converts,
    name_and_unit,
    plain,
    with_suffix,
)
from warmlink.orchestration.diagnosis.data.rig import Rig
from warmlink.orchestration.diagnosis.data.sheet import Sheet
from warmlink.orchestration.system.replacement import Replacements

_DATE = "date"
_ALIKE = 0.8
"""Likeness of two names from which one is taken for the other, mistyped."""


@dataclass(frozen=True)
class Said:
    """What the user says of files beside what stands in them.

    Attributes
    ----------
    units : unit by header or name of a column
    common : units, each for every column of its quantity that has none
    names : name of a column or variable by header; "" leaves the column out
    decimal : "point", "comma", or "" for what the file shows
    replaced : FMUs in place of parts of the system
    """

    units: Mapping[str, str] = field(default_factory=dict)
    common: Sequence[str] = ()
    names: Mapping[str, str] = field(default_factory=dict)
    decimal: str = ""
    replaced: Replacements | None = None


def said(
    units: Sequence[str] = (),
    names: Sequence[str] = (),
    decimal: str = "",
    replaced: Replacements | None = None,
) -> Said:
    """What `--unit`, `--map` and `--decimal` say; raises InputError where one does not have its form."""
    for text in names:
        if "=" not in text:
            raise InputError(f'--map {text}: no name; write --map "{text}=base_temperature"')
    pairs = [text.rpartition("=") for text in names]
    return Said(
        {name.strip(): unit.strip() for name, equals, unit in (u.partition("=") for u in units) if equals},
        [text.strip() for text in units if "=" not in text],
        {name.strip(): meant.strip() for name, _, meant in pairs},
        decimal,
        replaced,
    )


@dataclass(frozen=True)
class Place:
    """A column that is used.

    Attributes
    ----------
    column : its place in the file
    name, unit : of the header, or as said; None where nothing says the unit
    variable : that it is; "time", or "date" beside a time of the day
    source : where the unit stands: "header", "row of units", "name" or "--unit"
    chosen : whether the user named it
    """

    column: int
    name: str
    unit: str | None
    variable: str
    source: str
    chosen: bool


class Assignment:
    """Finds for each column of a sheet what it is."""

    def __init__(self, sheet: Sheet, rig: Rig, told: Said, named: Mapping[str, str]) -> None:
        self.sheet, self.rig, self.told = sheet, rig, told
        self.named = {**{h: self._variable(h, name) for h, name in told.names.items()}, **named}
        self._refuse_absent()
        # A file may spell the unit of `T1 [degC]` otherwise, or leave it out.
        parts = [(name_and_unit(header), variable) for header, variable in named.items()]
        self._units = {name: unit for (name, unit), _ in parts}
        self.named = {**{name: variable for (name, _), variable in parts}, **self.named}
        found = [place for place in map(self._place, range(len(sheet.headers))) if place is not None]
        taken = {place.variable for place in found if place.chosen}
        self.places = [p for p in found if p.variable and (p.chosen or p.variable not in taken)]
        self.places = self._one_time(self.places)
        self._refuse_two()
        used = {place.column for place in self.places}
        self.unused = tuple(h for i, h in enumerate(sheet.headers) if i not in used and h.strip())
        self._refuse_unknown([i for i in range(len(sheet.headers)) if i not in used])

    def time(self) -> tuple[Place, Place | None]:
        """Column of times, and that of dates where it has the time of the day alone."""
        times = [place for place in self.places if place.variable == TIME]
        dates = [place for place in self.places if place.variable == _DATE]
        if not times and not dates:
            raise InputError(
                f"{self.sheet.name}: there is no time column; head it as 'time [s]', or say which it is with "
                f'--map "{next(iter(self.sheet.headers), "clock")}=time"'
            )
        return (times[0], dates[0] if dates else None) if times else (dates[0], None)

    def signals(self) -> Iterator[Place]:
        """Columns of variables."""
        return (place for place in self.places if place.variable not in (TIME, _DATE))

    def _variable(self, header: str, name: str) -> str:
        """Variable that `--map` names; empty where the column is to be left out."""
        variable = self.rig.columns.get(name, name)
        if name and variable not in self.rig.variables and name not in (TIME, _DATE):
            raise InputError(
                f"--map {header}={name}: {name} is no column of {self.rig.name}; "
                f"{instead(name, (TIME, *self.rig.columns))}"
            )
        return variable

    def _refuse_absent(self) -> None:
        headers = [*self.sheet.headers, *(name_and_unit(h)[0] for h in self.sheet.headers)]
        known = {*headers, *(self.rig.column_of(v) for v in self.named.values()), *self.rig.columns, TIME}
        for header, variable in self.named.items():
            # A file of other origin may have the column under its own name.
            if not {header, name_and_unit(header)[0], self.rig.column_of(variable)} & set(headers):
                raise InputError(
                    f"{self.sheet.name}: there is no column {header!r}; {instead(header, self.sheet.headers)}"
                )
        for name in self.told.units:
            if name not in known:
                raise InputError(
                    f"--unit {name}={self.told.units[name]}: no such column; {instead(name, headers)}"
                )

    def _place(self, column: int) -> Place | None:
        """What a column is; the variable is empty where the user leaves it out."""
        header = self.sheet.headers[column]
        name, unit = (header, None) if header in self.rig.variables else name_and_unit(header)
        source = "header"
        if unit is None and self.sheet.units[column] is not None:
            unit, source = self.sheet.units[column], "row of units"
        variable = self.named.get(header, self.named.get(name))
        chosen = variable is not None
        if variable is None:
            variable = self._known(name)
        if variable == TIME and name == "T" and not chosen:
            variable = None  # a temperature
        if unit == "-" and variable and self._si(variable) != "1":
            unit = None  # a dash in a row of units says nothing
        for stem, suffix in with_suffix(name) if unit is None else ():
            meant = variable or self._known(stem)
            if meant and converts(suffix, self._si(meant)):
                name, unit, variable, source = name if chosen else stem, suffix, meant, "name"
                break
        if variable is None:
            return None
        for key in (header, name, self.rig.column_of(variable)):
            if key in self.told.units:
                given = self.told.units[key]
                if unit not in (None, given) and "%" not in given:
                    raise InputError(
                        f"--unit {key}={given}: column {header!r} is in {unit} already; correct the header, "
                        "or leave --unit out"
                    )
                unit, source = given, "--unit"
        if unit is None:
            unit, source = self._units.get(name), "channels"
        if unit is None:
            unit = next((u for u in self.told.common if variable and converts(u, self._si(variable))), None)
            source = "--unit"
        return Place(column, name, unit, variable, source, chosen)

    def _si(self, variable: str) -> str:
        """SI unit of a variable, of a time, or of a covariate."""
        if variable in (TIME, _DATE):
            return "s"
        return self.rig.unit(variable) if variable in self.rig.variables else "K"

    def _known(self, name: str) -> str | None:
        """Variable that a name says by itself."""
        short = plain(name)
        if short in TIMES:
            return _DATE if short == _DATE else TIME
        if short in self.rig.columns:
            return self.rig.columns[short]
        if name in self.rig.shared:
            return self.rig.shared[name][0]
        return name if name in (*self.rig.externals, *self.rig.columns.values()) else None

    def _one_time(self, places: Sequence[Place]) -> list[Place]:
        """Columns with the best one of several times: that which the user chose, else the one called time."""
        times = [place for place in places if place.variable == TIME]
        exact = [place for place in times if place.chosen] or [p for p in times if plain(p.name) == TIME]
        left_out = [place for place in times if exact and place not in exact]
        return [place for place in places if place not in left_out]

    def _refuse_two(self) -> None:
        for i, place in enumerate(self.places):
            other = next((p for p in self.places[:i] if p.variable == place.variable), None)
            if other is not None:
                one, two = self.sheet.headers[other.column], self.sheet.headers[place.column]
                what = "times" if place.variable == TIME else place.variable
                raise InputError(
                    f"{self.sheet.name}: columns {one!r} and {two!r} are both {what}; keep one, or leave one "
                    f'out with --map "{two}="'
                )

    def _refuse_unknown(self, columns: Sequence[int]) -> None:
        """Refuse to pass over a column that may be what the run lacks: a name mistyped, a speed."""
        if self.named.keys() - self.told.names.keys():
            return
        have = {place.variable for place in self.places}
        absent = {name: v for name, v in self.rig.columns.items() if v not in have}
        meant: dict[int, str] = {}
        for column in columns:
            guess = self._guess(column, absent)
            if guess is not None:
                meant[column] = guess
                del absent[guess]
        if not meant:
            return
        headers, several = self.sheet.headers, len(meant) > 1
        guesses = [f"{headers[column]!r} (perhaps {guess})" for column, guess in meant.items()]
        names = [name_and_unit(headers[column])[0] for column in meant]
        maps = [f'--map "{name}={guess}"' for name, guess in zip(names, meant.values(), strict=True)]
        raise InputError(
            f"{self.sheet.name}: {'columns' if several else 'column'} {', '.join(guesses)} "
            f"{'are' if several else 'is'} not known; say {' '.join(maps)}, or leave "
            f'{"one" if several else "it"} out with --map "{names[0]}="'
        )

    def _guess(self, column: int, absent: Mapping[str, str]) -> str | None:
        """Name of those that are absent, with their variables, that an unknown column may have."""
        header = self.sheet.headers[column]
        name, unit = name_and_unit(header)
        unit = unit or self.sheet.units[column]
        if self.named.get(header, self.named.get(name)) == "":
            return None
        likeness = {n: SequenceMatcher(None, plain(name), n).ratio() for n in self.rig.columns}
        best = max(likeness, key=lambda n: likeness[n], default="")
        if best in absent and likeness[best] >= _ALIKE:
            return best
        drives = (
            n
            for n, variable in absent.items()
            if unit
            and variable in self.rig.externals
            and self._si(variable) != "K"
            and converts(unit, self._si(variable))
        )
        return next(drives, None)
