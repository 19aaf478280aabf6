"""Results of every kind are drawn as they are, or refused in one sentence."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pandas
import pytest

from warmlink.fmus.errors import InputError
from warmlink.orchestration.cli import app, guarded
from warmlink.orchestration.report.plot import plot

LONG = "m" * 5000


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("time [s],a [K]\n0,1\n1,warm\n", "a [K]: row 2 holds 'warm', which is no number"),
        ("time [s],a [K]\n0,1\nsoon,2\n", "time [s]: row 2 holds 'soon', which is no number"),
        ("time [s],a [K]\n12:00,1\n12:01,2\n", "time [s]: row 1 holds '12:00', which is no number"),
        ("time [s],a [K]\n0,1\n,2\n", "row 2 has no time"),
        ("time [s],a [K]\n", "has no rows"),
        ("", "cannot be read"),
        ('time [s],a [K]\n"0,1\n1,2\n', 'cannot be read (a quote (") opens a cell and none closes it)'),
        ("time [s],a [K]\n0,1,5\n1,2,5\n", "cannot be read"),
        ("seconds,a [K]\n0,1\n", "has no column 'time [s]'"),
        ("time [s],a [K]\n0,1\n1,\x1b[31m" + LONG + "\n", "a [K]: row 2 holds '"),
        (f"time [s],a [{LONG}],b [K]\n0,1,2\n", "is of K, mmm"),
    ],
    ids=range(11),
)
def test_it_is_refused_in_a_sentence(
    text: str, told: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("results.csv").write_text(text)
    names = ["a", "b"] if ",b" in text else ["a"]
    with pytest.raises(SystemExit) as ended:
        guarded(lambda: app(["plot", "results.csv", *names, "--out", "plot.svg"], prog_name="warmlink"))
    assert ended.value.code == 2
    (said,) = capfd.readouterr().err.strip().splitlines()
    assert told in said
    assert len(said) < 400
    assert "\x1b" not in said
    assert not Path("plot.svg").exists()


def lines(figure: object) -> dict[str, np.ndarray]:
    return {line.name: np.asarray(line.y, float) for line in figure.data}  # type: ignore[attr-defined]


def test_a_shorter_run_ends_where_it_ends() -> None:
    whole = pandas.DataFrame({"time [s]": [0.0, 10, 20, 30], "a [K]": [1.0, 2, 3, 4]})
    short = pandas.DataFrame({"time [s]": [5.0, 20], "a [K]": [7.0, 8]})
    drawn = lines(plot(whole, "a", against=short))["a, the other"]
    assert np.isnan(drawn[[0, 3]]).all()
    assert drawn[1:3] == pytest.approx([7 + 1 / 3, 8])


def test_rows_are_drawn_in_the_order_of_their_times() -> None:
    mixed = pandas.DataFrame({"time [s]": [20.0, 0, 10], "a [K]": [3.0, 1, 2]})
    whole = pandas.DataFrame({"time [s]": [0.0, 10, 20], "a [K]": [1.0, 2, 3]})
    for first, second in ((mixed, whole), (whole, mixed)):
        figure = plot(first, "a", against=second)
        assert [list(each) for each in lines(figure).values()] == [[1, 2, 3], [1, 2, 3]]
        assert list(figure.data[0].x) == pytest.approx([0, 1 / 6, 1 / 3])


def test_times_in_seconds_since_1970_are_told_apart() -> None:
    """In single precision they are two minutes apart."""
    times = 1.7e9 + np.arange(0.0, 600.0)
    (line,) = plot(pandas.DataFrame({"time [s]": times, "a [K]": 0.0}), "a").data
    np.testing.assert_allclose(3600.0 * np.diff(line.x), 1.0, rtol=0.01)


def test_what_is_no_number_yet_is_left_out() -> None:
    empty = pandas.DataFrame({"time [s]": [0.0, 1], "a [m]": [np.nan, np.nan], "on [1]": [True, False]})
    assert np.isnan(lines(plot(empty, "a"))["a"]).all()
    assert list(lines(plot(empty, "on"))["on"]) == [1, 0]


def test_dates_are_no_times(tmp_path: Path) -> None:
    frame = pandas.DataFrame({"time [s]": pandas.to_datetime(["2024-01-01", "2024-01-02"]), "a [K]": [1, 2]})
    frame.to_parquet(tmp_path / "results.parquet")
    with pytest.raises(
        InputError, match=r"time \[s\]: row 1 holds '2024-01-01 00:00:00', which is no number"
    ):
        plot(tmp_path, "a")


def test_of_a_run_that_was_killed_the_values_that_it_wrote_are_drawn(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    from warmlink.orchestration.master.communication import CommunicationPoints
    from warmlink.orchestration.master.recording.recorder import Values
    from warmlink.orchestration.master.recording.result import RecordTable

    (tmp_path / "results.csv").write_text("time [s],a.y [K]\n0,1\n1,1\n")
    os.utime(tmp_path / "results.csv", (1e9, 1e9))
    header = RecordTable(
        ("a.y",), {"a.y": "K"}, CommunicationPoints.between(0.0, 10.0, 1.0), np.empty((0, 1))
    )
    begun = Values(tmp_path)
    begun.open(header)
    begun.put(0, np.array([[5.0], [6.0], [7.0]]))
    assert list(lines(plot(tmp_path, "a.y"))["a.y"]) == [5, 6, 7]
    assert "the last run there did not end; drawn are the values that it wrote, as far as 2 s" in (
        capfd.readouterr().err
    )
    (tmp_path / "results.csv").write_text("time [s],a.y [K]\n0,1\n1,1\n")  # as a run does at its end
    assert list(lines(plot(tmp_path, "a.y"))["a.y"]) == [1, 1]
