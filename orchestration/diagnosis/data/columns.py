"""Which column of a file is which variable, and in which unit: by its header, or as the user says."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from typing import Any

from warmlink.fmus.arguments import argument
from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.orchestration.diagnosis.data.options import ReadOptions
from warmlink.orchestration.machine.rig import Rig
from warmlink.orchestration.scenarios.logged import layout
from warmlink.orchestration.scenarios.logged.layout import TIME, converts, name_and_unit, plain
from warmlink.orchestration.scenarios.logged.sheet import Place, Sheet
from warmlink.orchestration.system.units import IDENTITY, conversion, parse_unit, spelled

_DATE = "date"
_ALIKE = 0.8
"""Likeness of two names from which one is taken for the other, mistyped."""


class Assignment:
    """Finds what each column of a sheet is, and the headers that are `unused`.

    Without channels, which say what every column is, one that may be what the run lacks is refused.

    Parameters
    ----------
    channels, covariates : variable by header, and input that only causes may use
    options : units and names that the user gave

    Attributes
    ----------
    unused : headers of columns that nothing is made of
    absent : by name that the user gives to a column that the file lacks, a sentence that says so; another
        file of the experiment may have it
    """

    def __init__(
        self,
        sheet: Sheet,
        rig: Rig,
        options: ReadOptions,
        channels: Mapping[str, str],
        covariates: Mapping[str, str],
    ) -> None:
        self._sheet, self._rig, self._options = sheet, rig, options
        of_names = {header: self._variable(header, name) for header, name in options.names.items()}
        mapped = {**of_names, **channels, **covariates}
        self.absent = self._absent(mapped)
        # A file may spell the unit of `T1 [degC]` otherwise, or leave it out.
        otherwise = {header: name_and_unit(header) for header in mapped if header not in sheet.headers}
        self._units = dict(otherwise.values())
        self._named = {**{name: mapped[header] for header, (name, _) in otherwise.items()}, **mapped}
        self._used = self._found()
        unused = sorted(set(range(len(sheet.headers))) - {place.column for place in self._used.values()})
        self.unused = tuple(sheet.headers[i] for i in unused if sheet.headers[i].strip())
        if not channels:
            self._refuse_unknown(unused)

    def _found(self) -> dict[str, Place]:
        """Column of each variable, and the best of several times."""
        found = [place for place in map(self._place, range(len(self._sheet.headings))) if place is not None]
        taken = {place.variable for place in found if place.chosen}
        found = [p for p in found if p.variable and (p.chosen or p.variable not in taken)]
        times = [place for place in found if place.variable == TIME]
        best = [p for p in times if p.chosen] or [p for p in times if plain(p.name) == TIME] or times
        used: dict[str, Place] = {}
        for place in (each for each in found if each.variable != TIME or each in best):
            other = used.setdefault(place.variable, place)
            if other is not place:
                one, two = self._sheet.headers[other.column], self._sheet.headers[place.column]
                what = "times" if place.variable == TIME else place.variable
                raise InputError(
                    f"{self._sheet.name}: columns {one!r} and {two!r} are both {what}; keep one, or leave "
                    f"one out with {argument('names', {two: ''})}"
                )
        # A current beside the torque would count twice; a pad's power acts where no temperature is.
        for first, *others in self._rig.required_inputs:
            for variable in others if first in used and not first.endswith("pad_temperature") else ():
                if variable in used:
                    self._refuse_both(used[first], used[variable])
                    del used[variable]
        return used

    def _refuse_both(self, first: Place, other: Place) -> None:
        """Raise InputError where two inputs were asked for of which each says what the other does."""
        if not other.chosen:
            return
        one, two = (self._sheet.headers[each.column] for each in (first, other))
        raise InputError(
            f"{self._sheet.name}: columns {one!r} and {two!r} would both count as what drives the machine; "
            f"leave one out with {argument('names', {one: ''})}"
        )

    def time(self) -> tuple[Place, Place | None]:
        """Column of times, and that of dates where it has the time of the day alone."""
        time, date = self._used.get(TIME), self._used.get(_DATE)
        if time is not None:
            return time, date
        if date is not None:
            return date, None
        rising = [each.name for i, each in enumerate(self._sheet.headings) if self._may_be_time(i)]
        told = "add the times of the rows, headed 'time [s]'"
        if rising:
            told = f"head it as 'time [s]', or say which it is with {argument('names', {rising[0]: 'time'})}"
        raise InputError(f"{self._sheet.name}: there is no time column; {told}")

    def _may_be_time(self, column: int) -> bool:
        """Whether a column that is nothing else may hold times: in no unit but of time, and rising."""
        import pandas as pd

        unit = self._sheet.headings[column].unit
        if (unit and not converts(unit, "s")) or column in [place.column for place in self._used.values()]:
            return False
        cells: Any = self._sheet.cells[column]
        if cells.dtype.kind in "mM":
            return True
        numbers = pd.to_numeric(cells, errors="coerce")
        if numbers.isna().all():
            return any(map(layout.is_value, cells.dropna().astype(str).head(20)))
        return len(cells) > 1 and bool(numbers.is_monotonic_increasing and numbers.is_unique)

    def offers(self) -> str:
        """Say how columns that nothing is made of may be mapped, by their units and words."""
        inputs = [self._rig.column_of(each) for group in self._rig.required_inputs for each in group]
        free = dict.fromkeys([*self._rig.measurable, *inputs])
        for place in self._used.values():
            free.pop(self._rig.column_of(place.variable), None)
        meant = {}
        for column in (list(self._sheet.headers).index(header) for header in self.unused):
            _, name, unit, *_ = self._sheet.headings[column]
            alike = {each: _words_alike(name, each) for each in free}
            # A temperature of which no word says that it is an input is a reading.
            fitting = [
                each
                for each in free
                if converts(unit or "", si := self._si(self._rig.columns.get(each, each)))
                if each not in inputs or si != "K" or alike[each]
            ]
            if fitting:
                best = max(fitting, key=alike.__getitem__)
                del free[best]
                meant[name] = best
        return argument("names", meant or {"COLUMN": next(iter(free), "VARIABLE")})

    def signals(self) -> list[Place]:
        """Columns of variables."""
        return [place for variable, place in self._used.items() if variable not in (TIME, _DATE)]

    def _variable(self, header: str, name: str) -> str:
        """Variable that a name of the user's is; empty where the column is to be left out."""
        variable = self._rig.columns.get(name, name)
        if name and variable not in self._rig.variables and name not in (TIME, _DATE):
            raise InputError(
                f"{argument('names', {header: name})}: {name} is no column of {self._rig.name}; "
                f"{instead(name, (TIME, *self._rig.columns))}"
            )
        return variable

    def _absent(self, mapped: Mapping[str, str]) -> dict[str, str]:
        """Sentences on headers that the sheet lacks; InputError where it lacks the variable as well."""
        names = [each.name for each in self._sheet.headings]
        headers = [*self._sheet.headers, *names]
        known = {*headers, *map(self._rig.column_of, mapped.values()), *self._rig.columns, TIME}
        absent = {}
        for header, variable in mapped.items():
            bare = name_and_unit(header)[0]
            if not {header, bare} & set(headers):
                told = f"there is no column {header!r}; {instead(bare, names)}"
                absent[header] = f"{self._sheet.name}: {told}"
                # A file of other origin may have the column under its own name.
                if variable and self._rig.column_of(variable) not in headers:
                    raise InputError(absent[header])
        for name, unit in self._options.units.items():
            if name not in known:
                raise InputError(
                    f"{argument('units', {name: unit})}: no such column; {instead(name, headers)}"
                )
        return absent

    def _place(self, column: int) -> Place | None:
        """What a column is; the variable is empty where the user leaves it out."""
        header, name, unit, source, below = self._sheet.headings[column]
        if header in self._rig.variables:  # whose brackets are those of an element
            name, unit, source = header, below, "row of units"
        variable = self._named.get(header, self._named.get(name))
        chosen = variable is not None
        if variable is None and name != "T":  # a temperature, and no time
            variable = self._known(name)
        if unit == "-" and variable and self._si(variable) != "1":
            unit = None  # a dash in a row of units says nothing
        for stem, suffix in layout.with_suffix(name) if unit is None else ():
            meant = variable or (None if stem == "T" else self._known(stem))
            if meant and converts(suffix, self._si(meant)):
                name, unit, variable, source = name if chosen else stem, suffix, meant, "name"
                break
        if variable is None:
            return None
        for key in (header, name, self._rig.column_of(variable)):
            if key in self._options.units:
                given = self._options.units[key]
                if unit is not None and "%" not in given and not _alike(unit, given, self._si(variable)):
                    raise InputError(
                        f"{argument('units', {key: given})}: column {header!r} is in {unit} already; "
                        "correct the header, or leave this unit out"
                    )
                unit, source = given, argument("units")
        if unit is None:
            unit, source = self._units.get(name), "channels"
        if unit is None:
            fitting = (u for u in self._options.common if variable and converts(u, self._si(variable)))
            unit, source = next(fitting, None), argument("units")
        return Place(column, name, unit, variable, source, chosen)

    def _si(self, variable: str) -> str:
        """SI unit of a variable, of a time, or of a covariate."""
        if variable in (TIME, _DATE):
            return "s"
        return self._rig.unit(variable) if variable in self._rig.variables else "K"

    def _known(self, name: str) -> str | None:
        """Variable that a name says by itself."""
        rig, short = self._rig, plain(name)
        if short in layout.TIMES:
            return _DATE if short == _DATE else TIME
        if short in rig.columns:
            return rig.columns[short]
        if name in rig.inputs_by_signal:
            return rig.inputs_by_signal[name][0]
        if name in (*rig.externals, *rig.columns.values()):
            return name
        meant = [each for each in rig.externals if each.rpartition(".")[2] == short]
        # One signal may feed several inputs, as a role says.
        fed = rig.demanded.get(short, ())
        return meant[0] if len(meant) == 1 else fed[0] if len(fed) == 1 else None

    def _refuse_unknown(self, columns: Sequence[int]) -> None:
        """Refuse to pass over a column that may be what the run lacks: a name mistyped, a speed."""
        absent = {name: v for name, v in self._rig.columns.items() if v not in self._used}
        meant: dict[int, str] = {}
        for column in columns:
            if guess := self._guess(column, absent):
                meant[column] = guess
                del absent[guess]
        if not meant:
            return
        names = [self._sheet.headings[column].name for column in meant]
        guesses = [f"{self._sheet.headers[column]!r} (perhaps {guess})" for column, guess in meant.items()]
        say = argument("names", dict(zip(names, meant.values(), strict=True)))
        noun, verb, one = ("columns", "are", "one") if len(meant) > 1 else ("column", "is", "it")
        raise InputError(
            f"{self._sheet.name}: {noun} {', '.join(guesses)} {verb} not known; say {say}, or "
            f"leave {one} out with {argument('names', {names[0]: ''})}"
        )

    def _guess(self, column: int, absent: Mapping[str, str]) -> str | None:
        """Name of those that are absent, with their variables, that an unknown column may have."""
        _, name, unit, *_ = self._sheet.headings[column]
        if self._named.get(self._sheet.headers[column], self._named.get(name)) == "":
            return None
        (best,) = get_close_matches(plain(name), self._rig.columns, 1, _ALIKE) or [""]
        if best in absent:
            return best
        units = {n: self._si(v) for n, v in absent.items() if v in self._rig.externals}
        return next((n for n, si in units.items() if unit and si != "K" and converts(unit, si)), None)


def _alike(one: str, other: str, unit: str) -> bool:
    """Whether two units are one, spelled in two ways perhaps, where one like a third is due."""
    try:
        first, second = (parse_unit(spelled(each, unit)) for each in (one, other))
        return conversion(first, second) == IDENTITY
    except InputError:
        return one == other


def _words_alike(header: str, name: str) -> int:
    """How many words of a header begin one of a variable's name, as `wind` begins `winding`."""
    words = plain(header).split("_")
    meant = name.rpartition(".")[2].removesuffix("_temperature").split("_")
    return sum(len(word) > 1 and any(each.startswith(word) for each in meant) for word in words)
