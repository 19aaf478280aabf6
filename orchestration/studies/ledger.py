"""Finished runs on disk: a study that was killed goes on without doing them again."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from warmlink.orchestration.studies.case import Case, Outcome
from warmlink.orchestration.studies.workers import Workers

FILE = "runs.jsonl"


class Ledger:
    """Workers that know what was run before, in `runs.jsonl` of a folder: a line for each finished run.

    A line that a kill cut short is overwritten. Runs that gave no figures are not kept: what stopped them
    may be mended.

    Parameters
    ----------
    folder : where the file is kept
    fmus : digest of the FMUs, by which runs of other FMUs are told apart
    workers : who runs what is not known yet
    """

    def __init__(self, folder: Path, fmus: str, workers: Workers) -> None:
        self._path, self._fmus, self._workers = folder / FILE, fmus, workers
        self._known: dict[str, Outcome] = {}
        self._end = 0
        if self._path.is_file():
            self._read()

    def run(self, cases: Sequence[Case]) -> Iterator[tuple[int, Outcome]]:
        """Give what is known, then run the rest; equal cases are run once."""
        keys = [self._key(case) for case in cases]
        waiting: dict[str, list[int]] = {}
        for place, key in enumerate(keys):
            if key in self._known:
                yield place, self._known[key]
            else:
                waiting.setdefault(key, []).append(place)
        first = [places[0] for places in waiting.values()]
        for found, outcome in self._workers.run([cases[place] for place in first]):
            key = keys[first[found]]
            if outcome.stopped is None:
                self._keep(key, outcome)
            for place in waiting[key]:
                yield place, outcome

    def _key(self, case: Case) -> str:
        return hashlib.sha256(f"{self._fmus} {case.digest}".encode()).hexdigest()[:32]

    def _keep(self, key: str, outcome: Outcome) -> None:
        self._known[key] = outcome
        line = json.dumps({"run": key, **outcome.to_dict()}).encode() + b"\n"
        with self._path.open("r+b" if self._path.exists() else "w+b") as stream:
            stream.seek(self._end)
            stream.truncate()
            stream.write(line)
        self._end += len(line)

    def _read(self) -> None:
        for line in self._path.read_bytes().splitlines(keepends=True):
            if not line.endswith(b"\n"):
                break
            try:
                known: dict[str, Any] = json.loads(line)
                key = str(known.pop("run"))
                self._known[key] = Outcome(**known)
            except (ValueError, KeyError, TypeError):
                break
            self._end += len(line)
