"""Alarms are diagnosed while the watch goes on, one after another, each in a process of its own.

That is `warmlink diagnose` on the alarm's experiment: it looks deeper than the filter, for minutes. It is
bounded in time and memory and makes way for others; it ends with the watch, however that ends. What it says
is put beside the alarm, and an alarm that has nothing beside it is diagnosed by the next watch.
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryFile
from typing import IO, Any

from warmlink.orchestration.files import fresh_file
from warmlink.orchestration.master.slaves.other_process import die_with_parent
from warmlink.orchestration.watch.offers import EXPERIMENT_FILE

ANSWER, REPORT = "diagnosis.txt", "diagnosis"
"""What a diagnosis says, and the folder of its report, in an alarm's folder."""

COMMAND = (sys.executable, "-m", "warmlink", "diagnose", EXPERIMENT_FILE, "--out", REPORT)

_LONGEST, _MEMORY, _NICE = 1800.0, 6_000_000_000, 10
"""s and bytes of address space that a diagnosis may take, and by how much it makes way for others."""

_LOOKS = 0.5
"""s from one look at it to the next."""


@dataclass
class _Running:
    alarm: Path
    process: subprocess.Popen[bytes]
    out: IO[bytes]
    errors: IO[bytes]
    until: float


@dataclass
class Diagnoses:
    """Diagnoses of a watch's alarms.

    Parameters
    ----------
    folder : of the watch
    longest : s that one may take
    """

    folder: Path
    longest: float = _LONGEST
    _running: _Running | None = None
    _next: float = 0.0

    def due(self) -> list[Path]:
        """Folders of alarms that nothing is said of yet, oldest first."""
        found = [each.parent for each in self.folder.glob(f"alarm-*/{EXPERIMENT_FILE}")]
        left = (each for each in found if not (each / ANSWER).is_file())
        return sorted(left, key=lambda each: (len(each.name), each.name))

    @property
    def busy(self) -> bool:
        """Whether one runs or is due."""
        return self._running is not None or bool(self.due())

    def anew(self, alarm: str) -> None:
        """Diagnose an alarm anew, as it has other rows now."""
        (self.folder / alarm / ANSWER).unlink(missing_ok=True)
        if self._running is not None and self._running.alarm.name == alarm:
            self.end()

    def told(self) -> dict[str, Any] | None:
        """Begin what is due, or look after what runs; an event once it has said something."""
        if time.monotonic() < self._next:
            return None
        self._next = time.monotonic() + _LOOKS
        if self._running is None:
            for alarm in self.due()[:1]:
                self._begin(alarm)
            return None
        running, code = self._running, self._running.process.poll()
        if code is None and time.monotonic() < running.until:
            return None
        said = self._said(running, code)
        self.end()
        with fresh_file(running.alarm / ANSWER) as scratch:
            scratch.write_text(said + "\n", "utf-8")
        told = f"{running.alarm.name} was diagnosed: {said_of(running.alarm)}"
        return {"alarm": False, "diagnosed": running.alarm.name, "told": told}

    def _begin(self, alarm: Path) -> None:
        out, errors = TemporaryFile(), TemporaryFile()  # noqa: SIM115
        process = subprocess.Popen(
            COMMAND,
            cwd=alarm,
            stdin=subprocess.DEVNULL,
            stdout=out,
            stderr=errors,
            preexec_fn=_bounded if sys.platform == "linux" else None,
        )
        self._running = _Running(alarm, process, out, errors, time.monotonic() + self.longest)

    def _said(self, running: _Running, code: int | None) -> str:
        """What a diagnosis that has ended, or has to, says."""
        by_hand = f"run it by hand: warmlink diagnose {running.alarm / EXPERIMENT_FILE}"
        if code is None:
            return f"the diagnosis took longer than {self.longest / 60:g} min and was ended; {by_hand}"
        out, errors = (_read(each) for each in (running.out, running.errors))
        if code == 0 and out:
            return out
        why = errors.replace("\r", "\n").rpartition("\n")[2] or f"it ended with code {code}"
        return f"the diagnosis failed ({why}); {by_hand}"

    def end(self) -> None:
        """End what runs; what it was at is due again."""
        if self._running is None:
            return
        if self._running.process.poll() is None:
            self._running.process.kill()
        self._running.process.wait()
        for each in (self._running.out, self._running.errors):
            each.close()
        self._running = None


def said_of(alarm: Path) -> str:
    """First line of what a diagnosis said of an alarm by its folder; nothing before."""
    try:
        first = (alarm / ANSWER).read_text("utf-8").partition("\n")[0]
    except OSError:
        return ""
    return first.removeprefix(f"{EXPERIMENT_FILE}: ")


def _read(stream: IO[bytes]) -> str:
    stream.seek(0)
    return stream.read().decode("utf-8", "replace").strip()


def _bounded() -> None:
    """Have this process, which is about to be the diagnosis, take no more than it may."""
    import resource

    die_with_parent()
    os.nice(_NICE)
    _, hard = resource.getrlimit(resource.RLIMIT_AS)
    most = _MEMORY if hard == resource.RLIM_INFINITY else min(_MEMORY, hard)
    resource.setrlimit(resource.RLIMIT_AS, (most, hard))
