"""Whether a study on a Dask cluster ends as undisturbed though workers, scheduler and command are killed."""

from __future__ import annotations

import multiprocessing
import os
import random
import shutil
import signal
import socket
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from importlib import import_module
from multiprocessing.process import BaseProcess as Process
from pathlib import Path
from typing import Annotated, Any

import typer

from benchmarks.command import start
from warmlink.fmus.errors import InputError, MissingExtraError
from warmlink.orchestration.console import answer, remark
from warmlink.orchestration.studies.session import FILE
from warmlink.orchestration.studies.storage import default_url

STUDIES = {
    "tune": "tune lag_law --trials 24",
    "compare": "compare --controllers lag,analytic --duty-cycles windshield_wiper,heavy_payload --mismatch "
    "nominal,draw_1,draw_2,draw_3,draw_4,draw_5,draw_6,draw_7",
}
WORKER, SCHEDULER, CLIENT = KINDS = ("worker", "scheduler", "client")
WORKERS = ("worker 1", "worker 2")
PARTS = 8
"""The next kill comes after at most such a part of the study's runs."""

PATIENCE_S = 300.0
"""A command that takes longer hangs, and is counted as a fault."""

PRELOADED = (
    "distributed.cli.dask_scheduler",
    "distributed.cli.dask_worker",
    "optuna",
    "pandas",
    "scipy.optimize",
    "warmlink.orchestration.cli",
)
"""What takes long to import: done once, for all processes that are started anew."""

Results = dict[str, Any]
"""What a study leaves behind: the files of its answer, its runs, and its trials in the storage."""


@dataclass
class Row:
    """What came of a study that was killed again and again.

    Attributes
    ----------
    kills : while some of its runs were finished and others were not
    busy : those of them just before which the cluster had tasks to do; for a worker, that one
    ended, differ : studies that came to their end, and those of them whose results differ
    faults : commands that ended in another way than in order or with a sentence
    """

    study: str
    kind: str
    kills: int = 0
    busy: int = 0
    ended: int = 0
    differ: int = 0
    faults: int = 0

    def __str__(self) -> str:
        figures = f"{self.kills:>6}{self.busy:>6}{self.ended:>9}{self.differ:>8}{self.faults:>8}"
        return f"{self.study:<9}{self.kind:<11}{figures}"


def begin(log: Path, module: str, arguments: list[str]) -> Process:
    """Begin a command in a process of its own, which has the libraries that take long to import already."""
    process = multiprocessing.get_context("forkserver").Process(
        target=_command, args=(log, module, arguments)
    )
    process.start()
    return process


def _command(log: Path, module: str, arguments: list[str]) -> None:
    with log.open("ab") as stream:
        os.dup2(stream.fileno(), 1)
        os.dup2(stream.fileno(), 2)
    sys.argv[1:] = arguments
    import_module(module).main()


class Cluster:
    """A Dask scheduler and two workers, processes that may be killed and are started anew at need."""

    def __init__(self, log: Path) -> None:
        with socket.create_server(("127.0.0.1", 0)) as free:
            port = str(free.getsockname()[1])
        self.address = f"tcp://127.0.0.1:{port}"
        self._commands = {SCHEDULER: ["--host", "127.0.0.1", "--port", port, "--no-dashboard"]}
        for name in WORKERS:
            alone = ("--name", name, "--nthreads", "1", "--no-nanny", "--no-dashboard")
            self._commands[name] = [self.address, *alone]
        self._log = log
        self._running: dict[str, Process] = {}

    def start(self) -> None:
        """Start what does not run, and wait until both workers have come."""
        self._revive()
        with self._asked() as client:
            while len(client.scheduler_info()["workers"]) < len(WORKERS):
                time.sleep(0.05)
                self._revive()  # a worker that has lost its scheduler ends by itself

    def busy(self) -> list[str]:
        """Names of the workers that have tasks to do."""
        with self._asked() as client:
            known = client.scheduler_info()["workers"]
            return [known[each]["name"] for each, tasks in client.processing().items() if tasks]

    def kill(self, name: str) -> None:
        """End a process as the system does that runs out of memory."""
        self._running[name].kill()
        self._running[name].join()

    def end(self) -> None:
        """End all of it."""
        for name in self._running:
            self.kill(name)

    def _revive(self) -> None:
        for name, arguments in self._commands.items():
            if name not in self._running or not self._running[name].is_alive():
                module = f"distributed.cli.dask_{name.partition(' ')[0]}"
                self._running[name] = begin(self._log, module, arguments)

    @contextmanager
    def _asked(self) -> Iterator[Any]:
        from distributed import Client

        with Client(self.address, timeout=PATIENCE_S, set_as_default=False) as client:
            yield client


@dataclass
class Trial:
    """A study and what is killed under it."""

    row: Row
    cluster: Cluster
    draw: random.Random
    folder: Path
    undisturbed: Results

    def carry_out(self, count: int) -> None:
        """Kill so many times, and let every study come to its end."""
        while self.row.kills < count or self.folder.exists():
            if not self._command(count):
                continue
            self.row.ended += 1
            self.row.differ += results(self.folder) != self.undisturbed
            shutil.rmtree(self.folder)
            remark(f"{self.row.study}: {self.row.kind} killed {self.row.kills} times of {count}")

    def _command(self, count: int) -> bool:
        """Give the command once, as after each interruption; whether the study came to its end."""
        self.cluster.start()
        with begun(self.row.study, self.cluster, self.folder) as client:
            while self.row.kills < count and self._waited(client):
                busy = self.cluster.busy()
                if not self._at_work(client):  # it ended while the cluster was asked
                    break
                if self.row.kind == CLIENT:
                    client.kill()
                    client.join()
                    if client.exitcode != -signal.SIGKILL:
                        break
                else:
                    victim = self.draw.choice(busy or WORKERS) if self.row.kind == WORKER else SCHEDULER
                    self.cluster.kill(victim)
                self.row.kills += 1
                self.row.busy += bool(busy)
                if self.row.kind == CLIENT:
                    return False
                self.cluster.start()
            client.join(PATIENCE_S)
            self._check(client)
            return client.exitcode == 0

    def _waited(self, client: Process) -> bool:
        """Wait for a moment drawn from those at which work is done; False where none is left."""
        done, total = finished_runs(self.folder), len(self.undisturbed[FILE])
        if done + 2 > total:
            return False
        moment = self.draw.randint(done + 1, min(done + total // PARTS, total - 1))
        give_up = time.monotonic() + PATIENCE_S
        while finished_runs(self.folder) < moment and client.is_alive() and time.monotonic() < give_up:
            time.sleep(0.005)
        time.sleep(self.draw.uniform(0.0, 0.1))
        return finished_runs(self.folder) >= moment

    def _at_work(self, client: Process) -> bool:
        return client.is_alive() and finished_runs(self.folder) < len(self.undisturbed[FILE])

    def _check(self, client: Process) -> None:
        """Count a command that ended badly; only the loss of its scheduler may end one, in a sentence."""
        said = log_of(self.folder).read_text("utf-8")
        good = (0, 2) if self.row.kind == SCHEDULER else (0,)
        if client.exitcode not in good or "Traceback" in said:
            self.row.faults += 1
            remark(f"{self.row.study}, {self.row.kind} killed: exit code {client.exitcode}: {said}")


@contextmanager
def begun(study: str, cluster: Cluster, folder: Path) -> Iterator[Process]:
    """The command of a study on a cluster."""
    asked = [*STUDIES[study].split(), "--exact", "--no-report", "--scheduler", cluster.address]
    log_of(folder).unlink(missing_ok=True)
    process = begin(log_of(folder), "warmlink.orchestration.cli", [*asked, "--out", str(folder)])
    try:
        yield process
    finally:
        process.kill()
        process.join()


def log_of(folder: Path) -> Path:
    """What the command last said whose results are in a folder."""
    return folder.with_suffix(".log")


def finished_runs(folder: Path) -> int:
    """Lines of the ledger."""
    ledger = folder / FILE
    return ledger.read_bytes().count(b"\n") if ledger.is_file() else 0


def results(folder: Path) -> Results:
    """What a study left in its folder, to the last bit."""
    import optuna

    found: Results = {path.name: path.read_bytes() for path in folder.glob("*.[cs]sv")}
    # Which of two workers ends first is chance.
    found[FILE] = sorted((folder / FILE).read_bytes().splitlines())
    if (folder / "study.db").exists():
        trials = optuna.load_study(study_name=None, storage=default_url(folder)).trials
        found["trials"] = [(each.number, each.state, each.params, each.values) for each in trials]
    return found


HEADINGS = f"{'study':<9}{'killed':<11}{'kills':>6}{'busy':>6}{'studies':>9}{'differ':>8}{'faults':>8}"


def main(
    count: Annotated[int, typer.Option(help="Kills of each kind in each study.")] = 50,
    seed: Annotated[int, typer.Option(help="The same seed draws the same moments.")] = 1,
    only: Annotated[str | None, typer.Option(help="One kind: worker, scheduler or client.")] = None,
) -> None:
    """Kill a study's workers, scheduler and command, and compare its end with that of an undisturbed one.

    A small `tune` and a small `compare` run on a Dask scheduler with two workers on this machine. Each kill
    (SIGKILL) comes at a random moment at which some of the study's runs are finished and others are not; what
    died is started anew, and the same command is given again. Trials, winner, tables and runs must be those
    of the undisturbed study, bit for bit, with no run or trial twice. Exit code 1 where they are not.
    """
    try:
        import distributed  # noqa: F401
        import optuna
    except ImportError:
        raise MissingExtraError("a study on a Dask cluster", "studies") from None
    if count < 1 or only not in (None, *KINDS):
        raise InputError(
            f"--count {count} --only {only}: give a number above 0, and one of {', '.join(KINDS)}"
        )
    if os.name != "posix":
        raise InputError("SIGKILL: this platform has no such signal; run this on Linux or macOS")
    multiprocessing.set_forkserver_preload([*PRELOADED])
    optuna.logging.set_verbosity(optuna.logging.ERROR)
    rows = []
    answer(f"seed {seed}\n{HEADINGS}")
    with tempfile.TemporaryDirectory(prefix="warmlink-") as home:
        cluster = Cluster(Path(home) / "cluster.log")
        try:
            for study in STUDIES:
                cluster.start()
                whole = Path(home) / study
                with begun(study, cluster, whole) as process:
                    process.join(PATIENCE_S)
                if process.exitcode:
                    raise InputError(f"{study}: not even undisturbed: {log_of(whole).read_text('utf-8')}")
                undisturbed = results(whole)
                for kind in KINDS if only is None else [only]:
                    rows.append(Row(study, kind))
                    draw = random.Random(f"{seed} {study} {kind}")
                    Trial(rows[-1], cluster, draw, Path(home) / "part", undisturbed).carry_out(count)
                    print(rows[-1], flush=True)
        finally:
            cluster.end()
    raise SystemExit(any(row.differ or row.faults for row in rows))


if __name__ == "__main__":
    start(main)
