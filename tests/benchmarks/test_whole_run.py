"""The time of a whole `warmlink run`."""

from __future__ import annotations

import pytest

from benchmarks import whole_run
from warmlink.fmus.errors import InputError


@pytest.mark.platform
def test_a_whole_run_is_timed() -> None:
    pytest.importorskip("resource", reason="this platform does not tell a child's processor time")
    found = whole_run.bench_whole_run(1)
    # Python and numpy alone take more than a twentieth of a second.
    assert 0.05 < found.process_s < 60
    assert 'warmlink run --stop "1 h" --no-report' in str(found)


def test_a_command_that_fails_is_no_time(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(whole_run, "ARGUMENTS", ("run", "no_such_scenario"))
    with pytest.raises(InputError, match="exit code 2"):
        whole_run.bench_whole_run(1)
