"""A watch from its source to its files: rows in, alarms out, state and page beside them."""

from __future__ import annotations

import json
import math
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TextIO

from warmlink.fmus.errors import InputError
from warmlink.orchestration.diagnosis.data.options import ReadOptions
from warmlink.orchestration.files import fresh_file
from warmlink.orchestration.machine.rig import Rig
from warmlink.orchestration.master.slaves import under_way
from warmlink.orchestration.watch.diagnosing import Diagnoses
from warmlink.orchestration.watch.hypotheses import watched
from warmlink.orchestration.watch.law import WatchedLaw, law_error
from warmlink.orchestration.watch.offers import Design, write_offer
from warmlink.orchestration.watch.sources.protocol import FilePlace, Source
from warmlink.orchestration.watch.sources.rows import Cells, RowReader
from warmlink.orchestration.watch.state import Beside, beside, restored, saved
from warmlink.orchestration.watch.ticks import TICK, Gatherer, Tick
from warmlink.orchestration.watch.watcher import Watcher

STATE, ALARMS, JOURNAL = "watch.state", "alarms.jsonl", "watch.rows"
"""Files of a watch: what it knows; what it has told, an object a line; and rows that no state has yet."""

_SAVED, _SHOWN, _SILENT, _WAITS = 60.0, 5.0, 5.0, 0.2
"""s between two writings of the state, and of the page; s of silence after which a server is at its end; s
between two looks at what is waited for."""

_MOST_TOLD = 1000
"""Events that are kept; of more the oldest go."""

_SAID = {
    "repeated": "rows had a time that was there already and were passed over",
    "unsorted": "rows came out of order and were sorted in",
    "late": "rows came too late and were passed over",
    "spikes": "readings leapt away from their neighbours and were passed over",
    "gaps": "gaps of more than 15 ticks: the filter began anew after each",
    "clock set back": "times the clock was set back: the filter began anew after it",
}


@dataclass(frozen=True)
class WatchOptions:
    """What is asked of a watch.

    Attributes
    ----------
    rig : the machine
    known : values in SI by variable that differ from the nominal ones
    told : units and names of columns
    sound : s of the opening part that is declared sound
    rate : of false alarms in 1/day
    tick : s of the log that are judged at once
    law : of ours that runs in shadow; None if the log's correction is judged, if it has one
    design : of that law for other parameters of the plant; None if it has none
    until_end : whether to end where the log does
    speed : of a replay, as a multiple of the log's own time; 0 as fast as it goes
    diagnose : whether alarms are diagnosed meanwhile
    """

    rig: Rig
    known: Mapping[str, float]
    told: ReadOptions
    sound: float
    rate: float
    tick: float = TICK
    law: WatchedLaw | None = None
    design: Design | None = None
    until_end: bool = False
    speed: float = 0.0
    diagnose: bool = False

    def facts(self, source: Source) -> dict[str, Any]:
        """What a restart has to ask for as well, as JSON."""
        columns = {"machine": self.rig.name, "known": dict(self.known), "columns": list(source.headers)}
        return {
            **columns,
            "sound": self.sound,
            "alarms": self.rate,
            "tick": self.tick,
            "law": self.law.facts if self.law else None,
        }


Show = Callable[["Watching"], None]
"""Writes a page of a watch."""


@dataclass
class Watching:
    """A watch at work.

    Parameters
    ----------
    source : of the rows
    asked : what is asked
    folder : for its files
    show : writes its page
    """

    source: Source
    asked: WatchOptions
    folder: Path
    show: Show
    events: list[dict[str, Any]] = field(default_factory=list)
    rows: int = 0
    _journal: TextIO | None = None

    def __post_init__(self) -> None:
        asked, source = self.asked, self.source
        told = ReadOptions(asked.told.units, asked.told.common, asked.told.names, asked.told.decimal)
        self.reader = RowReader(source.name, source.headers, asked.rig, told, source.comma)
        reader = self.reader
        machine = watched(asked.rig, asked.known, reader.inputs, reader.readings, reader.names, asked.tick)
        law = law_error(asked.law, asked.rig, reader.readings, reader.has_correction, asked.tick)
        self.watcher = Watcher(machine, asked.sound, asked.rate, law)
        self.gatherer = Gatherer(asked.rig, asked.known, reader.readings, asked.tick)
        self.diagnoses = Diagnoses(self.folder) if asked.diagnose else None
        self._due = self._shown = 0.0
        self._paced: float | None = None

    @staticmethod
    def begin_of(folder: Path) -> FilePlace | None:
        """Where an earlier run ended in its file, by the state in a folder; None without one."""
        kept = beside(folder / STATE)
        return None if kept is None else kept.place

    def restore(self) -> bool:
        """Go on from the state in the folder; False if there is none; InputError as by `state.restored`."""
        path = self.folder / STATE
        kept = beside(path)
        if kept is None:
            return False
        self.events, self.rows, self.reader.doubtful, _ = kept
        return restored(path, self.asked.facts(self.source), self.watcher, self.gatherer)

    def run(self) -> Iterator[dict[str, Any]]:
        """Events as they come; it ends where the source does, or does not end.

        Raises
        ------
        InputError
            The log ended within its sound part, or this is too short.
        KeyboardInterrupt
            Ctrl-C came; the state is written, unless a second one came or the sound part was being learnt.
        """
        with under_way.interruption(lambda: self.watcher.learning):
            yield from self._run()

    def _run(self) -> Iterator[dict[str, Any]]:
        silent = time.monotonic()
        yield from self._taken_up()
        for cells in self.source.rows():
            yield from self._beside()
            if cells is None:
                if self.asked.until_end and time.monotonic() - silent > _SILENT:
                    break
                self._write_if_due()
                self._end_if_asked()
                continue
            silent = time.monotonic()
            self._keep(cells)
            yield from self._read(cells, self._pace)
            self._write_if_due()
            self._end_if_asked()
        yield from self._judged(self.gatherer.rest())
        self.write()
        self.watcher.refuse_unlearnt()
        if self.diagnoses is not None:
            while self.diagnoses.busy:
                yield from self._beside()
                time.sleep(_WAITS)
                self._end_if_asked()
            self._show()

    def _end_if_asked(self) -> None:
        if under_way.asked():
            self.write()
            raise KeyboardInterrupt

    def _read(self, cells: Cells, wait: Callable[[float], None]) -> Iterator[dict[str, Any]]:
        """Judge a row."""
        self.rows += 1
        row = self.reader.read(cells)
        if row is not None:
            wait(row.time)
            yield from self._judged(self.gatherer.add(row))

    def _keep(self, cells: Cells) -> None:
        """Keep a row of a source that cannot go back until a state knows it."""
        if self.source.place() is not None:
            return
        if self._journal is None:
            self._journal = (self.folder / JOURNAL).open("a", encoding="utf-8")
            self._journal.write("\n")  # what an earlier run left there may end within a line
        self._journal.write(json.dumps([self.rows + 1, list(cells)]) + "\n")
        self._journal.flush()

    def _taken_up(self) -> Iterator[dict[str, Any]]:
        """Judge the rows that were kept when an earlier run ended; the last may have been cut off."""
        path = self.folder / JOURNAL
        for line in path.read_text("utf-8").splitlines() if path.is_file() else ():
            try:
                number, cells = json.loads(line)
            except ValueError:
                continue
            if number > self.rows:
                yield from self._read(cells, lambda at: None)

    def _judged(self, ticks: Iterator[Tick]) -> Iterator[dict[str, Any]]:
        for tick in ticks:
            for event in self.watcher.add(tick):
                if event["alarm"]:
                    event["offered"] = self._offer("again" in event)
                self.events = [*self.events, event][-_MOST_TOLD:]
                self._due = 0.0
                yield event

    def _offer(self, again: bool) -> list[str]:
        """Write what the present alarm offers; the names of the files, in the watch's folder."""
        watcher = self.watcher
        assert watcher.learnt is not None
        folder = f"alarm-{len(self.alarms) + (not again)}"
        system = self.asked.told.machine
        system = str(Path(system).resolve()) if Path(system).is_file() else system
        offered = system, watcher.machine, watcher.learnt, list(watcher.recent), watcher.explained
        written = write_offer(self.folder / folder, *offered, self.asked.design)
        if self.diagnoses is not None:
            self.diagnoses.anew(folder)
        return [f"{folder}/{each}" for each in written]

    def _beside(self) -> Iterator[dict[str, Any]]:
        """What the source and a diagnosis have to tell; it is not part of what was judged."""
        while self.source.told:
            yield {"alarm": False, "told": self.source.told.pop(0)}
        if self.diagnoses is not None and (said := self.diagnoses.told()) is not None:
            yield said

    def close(self) -> None:
        """End what goes on beside the watch."""
        if self.diagnoses is not None:
            self.diagnoses.end()

    def _pace(self, at: float) -> None:
        """Wait until a row of a replay is due."""
        if not self.asked.speed:
            return
        if self._paced is None:
            self._paced = time.monotonic() - at / self.asked.speed
        due = min(self._paced + at / self.asked.speed, time.monotonic() + 60.0)
        while not under_way.asked() and (wait := due - time.monotonic()) > 0:
            time.sleep(min(wait, _WAITS))

    def _write_if_due(self) -> None:
        if time.monotonic() >= self._due:
            self.write()
        elif time.monotonic() >= self._shown:
            self._show()

    def _show(self) -> None:
        with fresh_file(self.folder / ALARMS) as scratch:
            scratch.write_text("".join(f"{json.dumps(each)}\n" for each in self.events), "utf-8")
        self.show(self)
        self._shown = time.monotonic() + _SHOWN

    def write(self) -> None:
        """Write state, events and page, each whole or as it was."""
        more = Beside(self.events, self.rows, self.reader.doubtful, self.source.place())._asdict()
        path = self.folder / STATE
        saved(path, self.asked.facts(self.source), self.watcher, self.gatherer, more)
        if self._journal is not None:
            self._journal.truncate(0)
        else:
            (self.folder / JOURNAL).unlink(missing_ok=True)
        self._show()
        self._due = time.monotonic() + _SAVED

    @property
    def alarms(self) -> list[dict[str, Any]]:
        """Alarms so far, without those that name one anew."""
        return [each for each in self.events if each["alarm"] and "again" not in each]

    def remarks(self) -> list[str]:
        """What was passed over, in sentences."""
        found = [f"{count} {_SAID[name]}" for name, count in sorted(self.gatherer.counts.items()) if count]
        if self.reader.doubtful:
            found.append(f"{self.reader.doubtful} cells or times held something else than a credible number")
        if self.reader.unused:
            found.append(f"columns that are not used: {', '.join(self.reader.unused)}")
        return found


def rate_of(text: str, where: str) -> float:
    """Rate in 1/day of `"1 per 30 days"`; raises InputError where it says no rate above 0."""
    from warmlink.orchestration.written.quantities import quantity

    count, per, lasting = text.partition(" per ")
    remedy = f'write how many in which time, as {where} "1 per 30 days"'
    try:
        number = float(count)
        unit = lasting.strip()
        seconds = quantity(unit if unit[:1].isdigit() else f"1 {unit}", "s", where)
    except ValueError:
        raise InputError(f"{where} {text!r}: is no rate of false alarms; {remedy}") from None
    if not per or not (0 < number < math.inf and seconds > 0):
        raise InputError(f"{where} {text!r}: is no rate of false alarms above 0; {remedy}")
    return number / seconds * 86400.0
