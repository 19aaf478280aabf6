"""Results of blocks, kept in `out/blocks` from build to build, and lines that tell how a build gets on.

A block runs again if it, a block before it on its page, or the code has changed. Its page's earlier blocks,
whose files and names it may use, then run again too.
"""

from __future__ import annotations

import hashlib
import json
import multiprocessing
import resource
import shutil
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

from extension.texts import ROOT

Content = dict[str, Any]
"""What came of a block, as JSON holds it."""

CODE = ("fmus", "controllers", "orchestration")


@cache
def code_digest() -> str:
    """Digest of all that the blocks run."""
    found = hashlib.sha256(sys.version.encode())
    files = [path for folder in CODE for path in sorted((ROOT / folder).rglob("*.*")) if path.is_file()]
    for path in (Path(__file__).with_name("blocks.py"), *files):
        if path.suffix != ".pyc":
            found.update(str(path.relative_to(ROOT)).encode() + b"\0" + path.read_bytes())
    return found.hexdigest()


@dataclass
class Page:
    """Where the blocks of one page run, one after another; the folder stays until the next build.

    Attributes
    ----------
    folder : in which they run
    kept : folder of results
    names : of the page's Python blocks
    key : digest of the code and of all blocks so far
    waiting : blocks whose results were kept, in the order of the page, for the first one that must run
    """

    folder: Path
    kept: Path
    names: dict[str, Any] = field(default_factory=lambda: {"__name__": "__main__"})
    key: str = field(default_factory=code_digest)
    waiting: list[Callable[[], object]] = field(default_factory=list)

    def __post_init__(self) -> None:
        shutil.rmtree(self.folder, ignore_errors=True)
        self.folder.mkdir(parents=True)

    def before_the_next(self, text: str, act: Callable[[], object]) -> None:
        """Do something of which nothing is shown, before the page's next block that runs."""
        self.key = _digest(self.key, text)
        self.waiting.append(act)

    def result(self, text: str, where: str, run: Callable[[], Content]) -> Content:
        """What came of the page's next block, from an earlier build if nothing has changed."""
        self.before_the_next(text, lambda: _timed(where, text, run))
        return result_of(self.kept, self.key, self._run)

    def _run(self) -> Content:
        *earlier, last = self.waiting
        self.waiting = []
        for each in earlier:
            each()
        return last()  # type: ignore[return-value]


def alone(kept: Path, text: str, where: str, run: Callable[[], Content]) -> Content:
    """What came of something that needs no block before it, from an earlier build if nothing has changed."""
    return result_of(kept, _digest(code_digest(), text), lambda: _timed(where, text, run))


def result_of(kept: Path, key: str, run: Callable[[], Content]) -> Content:
    """The result of a key: kept, or run for and kept, unless it holds `failed`."""
    path = kept / f"{key}.json"
    if path.is_file():
        path.touch()
        return dict(json.loads(path.read_text("utf-8")))
    found = run()
    if not found.get("failed"):
        kept.mkdir(parents=True, exist_ok=True)
        scratch = path.with_suffix(f".{multiprocessing.current_process().pid}")
        scratch.write_text(json.dumps(found), "utf-8")
        scratch.replace(path)
    return found


def _digest(*texts: str) -> str:
    return hashlib.sha256("\0".join(texts).encode()).hexdigest()


def _timed(where: str, text: str, run: Callable[[], Content]) -> Content:
    first = next((line for line in text.splitlines() if line.strip()), "")
    tell(f"{where}  {first[:80]}")
    began, used = time.perf_counter(), _processor_time()
    found = run()
    lasted, used = time.perf_counter() - began, _processor_time() - used
    if lasted > 1:
        tell(f"{where}  took {lasted:.1f} s, {used:.1f} s of processor time")
    return found


def _processor_time() -> float:
    both = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(used.ru_utime + used.ru_stime for used in both)


@dataclass
class Progress:
    """Which pages are read, told by whichever process reads one."""

    names: Sequence[str]
    done: Any
    began: float = field(default_factory=time.perf_counter)

    @classmethod
    def over(cls, names: Sequence[str]) -> Progress:
        """Of pages; before processes are made that read them."""
        return cls(names, multiprocessing.Array("b", max(len(names), 1)))

    def read(self, name: str) -> None:
        """A page is read; tell which ones are left."""
        if name not in self.names:  # one that is made from code, which takes no time
            return
        with self.done.get_lock():
            self.done[self.names.index(name)] = 1
            left = [each for each, done in zip(self.names, self.done, strict=False) if not done]
        rest = f"; left: {', '.join(left[:6])}{' ...' if len(left) > 6 else ''}" if left else ""
        read, lasted = len(self.names) - len(left), time.perf_counter() - self.began
        tell(f"{read} of {len(self.names)} pages after {lasted:.0f} s  {name}{rest}")


def tell(line: str) -> None:
    """One line of progress."""
    print(line, file=sys.stderr, flush=True)


def forget(kept: Path, since: float) -> None:
    """Remove results that no page has used since a time."""
    for path in kept.glob("*.json"):
        if path.stat().st_mtime < since:
            path.unlink()
