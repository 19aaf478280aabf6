"""Masters side by side: they run the same thing, and the table says what came of it."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from benchmarks import masters
from benchmarks.hosts import HOSTS, Host
from benchmarks.masters import Extent, Row, bench_masters, masters_table
from warmlink.fmus.errors import InputError

STEPS, SECONDS = 500, 60
FEW = [host for host in HOSTS if host.name in ("warmlink, compiled", "FMPy, plain loop")]
"""Masters for Python FMUs, which take two seconds to begin; test_cell_referees has them in the others."""


@pytest.fixture(scope="module")
def cases() -> list[list[Row]]:
    if shutil.which("cc") is None:
        pytest.skip("no C compiler on this machine")
    measured = bench_masters(Extent(STEPS, SECONDS, 1))
    found = [next(measured), next(measured)]
    with pytest.MonkeyPatch.context() as changed:
        changed.setattr(masters, "HOSTS", FEW)
        return [*found, *measured]


@pytest.mark.slow
def test_every_installed_master_runs_every_case(cases: list[list[Row]]) -> None:
    installed = {host.name for host in HOSTS if not host.missing}
    assert [row.failure for rows in cases for row in rows if row.failure is not None] == []
    assert len(cases) == 3
    assert {row.master for row in cases[1]} == installed
    assert {row.master for row in cases[2]} == {host.name for host in FEW if not host.missing}
    assert {row.master for row in cases[0]} == {h.name for h in HOSTS if not (h.missing or h.iterates)}


@pytest.mark.slow
def test_all_run_the_same_thing(cases: list[list[Row]]) -> None:
    trivial, *cells = cases
    for row in trivial:
        assert row.value == pytest.approx((STEPS - 1) * (STEPS - 2) / (6 * STEPS**2), rel=1e-12), row
    iterates = {host.name for host in HOSTS if host.iterates}
    for rows in cells:
        explicit = [row for row in rows if row.master not in iterates]
        assert len(explicit) > 1
        for row in explicit:
            assert row.value == pytest.approx(explicit[0].value, abs=1e-9)
    (iterated,) = (row for row in cells[0] if row.master in iterates)
    assert iterated.off_by is not None
    assert cells[0][0].off_by is not None
    # What is left belongs to the slaves' own integration.
    assert abs(iterated.off_by) < 0.1 * abs(cells[0][0].off_by)


def test_a_master_that_fails_says_so_in_its_row(tmp_path: Path) -> None:
    job = masters.Job(str(tmp_path / "absent.ssp"), 10, 1.0, "c.y", 1)
    row = masters.timed(masters.Case("nothing", job), Host("warmlink, plain", "ours:plain"))
    assert row.step_us is None
    assert "absent.ssp" in str(row.failure)
    assert "failed: " in masters_table([row])


def test_the_table_says_what_was_measured() -> None:
    rows = [
        Row("ours", "cell", 10.0, 1.25, 50e-6, 2e-9),
        Row("theirs", "cell", 40.0, 0.5, 51e-6, 1e-6),
        Row("broken", "cell", failure="it does not load"),
    ]
    lines = masters_table(rows).splitlines()
    assert lines[2].split() == ["ours", "10", "1.0x", "1.25", "s", "50.000000", "µm", "2.0000", "nm"]
    assert lines[3].split()[:5] == ["theirs", "40", "4.0x", "0.50", "s"]
    assert lines[4].split() == ["broken", "failed:", "it", "does", "not", "load"]


def test_what_is_not_installed_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(masters, "HOSTS", (Host("Other", "other:run", ("no-such-package",)),))
    assert masters.absent() == {"Other": ("no-such-package",)}


def test_too_little_to_time_is_refused() -> None:
    with pytest.raises(InputError, match="too little to time"):
        next(bench_masters(Extent(rounds=0)))
