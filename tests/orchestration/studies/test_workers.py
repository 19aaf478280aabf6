import math
import os
import random
import signal
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import pytest

from tests.formula import fmus_named
from warmlink.fmus.errors import InputError
from warmlink.orchestration import catalogue
from warmlink.orchestration.closed_loop.load import load_scenario
from warmlink.orchestration.studies.case import Case, Outcome, case_of
from warmlink.orchestration.studies.processes import LocalWorkers
from warmlink.orchestration.studies.session import FILE, Ledger
from warmlink.orchestration.studies.workers import FmuSet, Workers, _written

OUTCOME = Outcome(3.0, 2.0, 1.0, None, 30.0, 10.0, 0.1, 0.01)


@dataclass(frozen=True)
class Deadly(Case):
    """A case that kills the process that runs it, as often as its file has letters left."""

    file: str = ""

    @property
    def master(self) -> str:  # type: ignore[override]
        lives = Path(self.file)
        if (
            lives.is_file()
            and lives.read_text()
            and os.getpid() != int(lives.with_suffix(".pid").read_text())
        ):
            lives.write_text(lives.read_text()[1:])
            os.kill(os.getpid(), signal.SIGKILL)
        return "gauss_seidel"

    @master.setter
    def master(self, value: str) -> None:
        pass


def short(folder: Path) -> Case:
    scenario = load_scenario(str(folder / "work.toml"))
    return case_of(
        replace(scenario, step_size=10.0, controller=catalogue.shipped("none")), ("none", "work", "nominal")
    )


def deadly(folder: Path, times: int) -> Deadly:
    good = short(folder)
    (folder / "lives").write_text("x" * times)
    (folder / "lives.pid").write_text(str(os.getpid()))
    return Deadly(
        good.label,
        good.law,
        good.values,
        good.stop_time,
        good.step_size,
        good.master,
        good.tolerance,
        False,
        good.machine,
        str(folder / "lives"),
    )


def test_a_worker_that_dies_once_loses_nothing(folder: Path, fmus: FmuSet) -> None:
    good = short(folder)
    cases = [good] * 4 + [deadly(folder, 1)] + [good] * 3
    with LocalWorkers(fmus, 2) as workers:
        found = dict(workers.run(cases))
    assert sorted(found) == list(range(8))
    assert len(set(found.values())) == 1
    assert found[0].stopped is None
    assert (folder / "lives").read_text() == ""


def test_a_run_that_always_kills_its_worker_is_recorded_and_no_other(folder: Path, fmus: FmuSet) -> None:
    good = short(folder)
    with LocalWorkers(fmus, 2) as workers:
        found = dict(workers.run([good, deadly(folder, 9), good, good]))
    assert [place for place, outcome in found.items() if outcome.stopped is not None] == [1]
    assert "the worker died at each of 3 attempts" in str(found[1].stopped)


def test_a_run_that_fails_tells_why(folder: Path, fmus: FmuSet) -> None:
    good = short(folder)
    values = {**good.values, "link": {"conductivity": -1.0}}
    with LocalWorkers(fmus, 1) as workers:
        found = dict(workers.run([replace(good, values=values), replace(good, law="Nobody"), good]))
    assert "conductivity" in str(found[0].stopped)
    assert found[1].stopped is not None
    assert found[2].stopped is None


def test_no_workers_at_all_are_refused(fmus: FmuSet) -> None:
    with pytest.raises(InputError, match="jobs=0"):
        LocalWorkers(fmus, 0)


class Counting:
    def __init__(self, stopped: bool = False) -> None:
        self.ran = 0
        self.stopped = stopped

    def run(self, cases: Sequence[Case]) -> Iterator[tuple[int, Outcome]]:
        for place, case in enumerate(cases):
            self.ran += 1
            score = float(case.values["compensator"]["gain"])
            yield place, Outcome(stopped="no") if self.stopped else replace(OUTCOME, max_abs_um=score)


def numbered(number: float) -> Case:
    values = {"compensator": {"gain": number}}
    return Case(("lag", "work", str(number)), "LagCompensator", values, 600.0, 1.0, "gauss_seidel", 5e-6)


def ledger(folder: Path, workers: Workers, fmus: str = "fmus", said: list[str] | None = None) -> Ledger:
    return Ledger(folder, fmus_named(fmus), workers, (said if said is not None else []).append)


def test_what_was_run_is_not_run_again(tmp_path: Path) -> None:
    workers = Counting()
    first = dict(ledger(tmp_path, workers).run([numbered(1.0), numbered(2.0), numbered(1.0)]))
    assert workers.ran == 2
    again = dict(ledger(tmp_path, workers).run([numbered(2.0), numbered(1.0), numbered(1.0)]))
    assert workers.ran == 2
    assert [again[1], again[0], again[2]] == [first[0], first[1], first[2]]
    dict(ledger(tmp_path, workers, "other fmus").run([numbered(1.0)]))
    assert workers.ran == 3


def test_a_line_that_a_kill_cut_short_is_written_anew_without_a_word(tmp_path: Path) -> None:
    workers, said = Counting(), list[str]()
    dict(ledger(tmp_path, workers).run([numbered(1.0), numbered(2.0)]))
    whole = (tmp_path / FILE).read_bytes()
    for cut in range(len(whole.splitlines(keepends=True)[0]), len(whole)):
        (tmp_path / FILE).write_bytes(whole[:cut])
        before = workers.ran
        dict(ledger(tmp_path, workers, said=said).run([numbered(1.0), numbered(2.0)]))
        assert workers.ran == before + 1
        assert (tmp_path / FILE).read_bytes() == whole
    assert said == []


def test_every_damage_to_a_line_is_noticed_and_costs_that_run_alone(tmp_path: Path) -> None:
    workers = Counting()
    three = [numbered(1.0), numbered(2.0), numbered(3.0)]
    right = dict(ledger(tmp_path, workers).run(three))
    whole = (tmp_path / FILE).read_bytes()
    lines = whole.splitlines(keepends=True)
    draw = random.Random(4)
    for _ in range(300):
        damaged = bytearray(lines[1])
        at = draw.randrange(len(damaged) - 1)
        damaged[at] ^= 1 << draw.randrange(8)
        (tmp_path / FILE).write_bytes(lines[0] + damaged + lines[2])
        before, said = workers.ran, list[str]()
        assert dict(ledger(tmp_path, workers, said=said).run(three)) == right
        assert workers.ran == before + 1
        assert len(said) == 1
        assert "line 2" in said[0]
        assert "damaged" in said[0]
        assert sorted((tmp_path / FILE).read_bytes().splitlines()) == sorted(whole.splitlines())


@pytest.mark.parametrize(
    "line",
    ['{"run": "abcdef"}', "nonsense", "", "[" * 100_000, '"run"', "\xff"],
    ids=["short", "nonsense", "empty", "deep", "string", "binary"],
)
def test_a_line_that_is_none_is_removed(line: str, tmp_path: Path) -> None:
    workers, said = Counting(), list[str]()
    dict(ledger(tmp_path, workers).run([numbered(1.0), numbered(2.0)]))
    whole = (tmp_path / FILE).read_bytes()
    (tmp_path / FILE).write_bytes(line.encode("latin-1") + b"\n" + whole)
    dict(ledger(tmp_path, workers, said=said).run([numbered(1.0), numbered(2.0)]))
    assert (tmp_path / FILE).read_bytes() == whole
    assert workers.ran == 2
    assert "line 1: damaged" in said[0]
    dict(ledger(tmp_path, workers, said=said).run([numbered(1.0)]))
    assert len(said) == 1


def test_runs_of_an_fmu_with_one_other_byte_are_told_apart() -> None:
    one, other = (FmuSet("native", {"ThermalLink": content}).digest for content in (b"guid a", b"guid b"))
    assert one != other


def test_what_was_run_stays_known_when_a_controller_is_added(tmp_path: Path) -> None:
    """Its FMUs' digest was part of every run's key, so that one more controller threw all runs away."""
    alone = FmuSet("native", {"ThermalLink": b"link", "LagCompensator": b"lag"})
    more = FmuSet("native", {**alone.contents, "ObserverCompensator": b"observer"})
    other = FmuSet("native", {**more.contents, "LagCompensator": b"another lag"})
    workers, first = Counting(), numbered(1.0)
    added = replace(first, law="ObserverCompensator")
    for fmus, ran in ((alone, 1), (more, 2), (alone, 2), (other, 3)):
        dict(Ledger(tmp_path, fmus, workers, print).run([first, added] if fmus is more else [first]))
        assert workers.ran == ran


def test_runs_that_gave_no_figures_are_tried_again(tmp_path: Path) -> None:
    workers = Counting(stopped=True)
    for _ in range(2):
        assert dict(ledger(tmp_path, workers).run([numbered(1.0)]))[0].stopped == "no"
    assert workers.ran == 2


def test_runs_whose_figures_are_no_numbers_are_tried_again(tmp_path: Path) -> None:
    workers = Counting()
    for _ in range(2):
        assert math.isnan(dict(ledger(tmp_path, workers).run([numbered(math.nan)]))[0].max_abs_um)
    assert workers.ran == 2


def test_a_damaged_fmu_of_a_study_is_written_anew(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("WARMLINK_CACHE", str(tmp_path))
    first, again = (FmuSet("native", {"ThermalLink": content}) for content in (b"whole", b"whole"))
    (path,) = first.files().values()
    path.write_bytes(b"who")
    _written.cache_clear()
    assert again.files()["ThermalLink"].read_bytes() == b"whole"
