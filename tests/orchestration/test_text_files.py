"""What people write is read in the encodings that they use, or refused in one sentence."""

from __future__ import annotations

from pathlib import Path

import pytest

from warmlink.fmus.errors import InputError
from warmlink.orchestration.text_files import measured_text, read_text, tables_of


@pytest.mark.parametrize(
    ("content", "text"),
    [
        ("20 °C – “warm” 5 €".encode("cp1252"), "20 °C – “warm” 5 €"),
        ("20 °C".encode("latin-1"), "20 °C"),
        (b"20 \xb0C \x81", "20 °C \x81"),
        ("20 °C –".encode("utf-16"), "20 °C –"),
    ],
    ids=["cp1252", "both", "not cp1252", "utf-16"],
)
def test_measurements_are_read_in_the_encodings_of_spreadsheets(
    content: bytes, text: str, tmp_path: Path
) -> None:
    (tmp_path / "log.csv").write_bytes(content)
    assert measured_text(tmp_path / "log.csv") == text


def test_a_file_that_may_not_be_read_is_about_permissions(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(path: Path) -> bytes:
        raise PermissionError(13, "Permission denied")

    (tmp_path / "log.csv").write_text("time [s]\n")
    monkeypatch.setattr(Path, "read_bytes", refuse)
    told = r"log\.csv: cannot be read \(Permission denied\); check its permissions"
    with pytest.raises(InputError, match=told):
        measured_text(tmp_path / "log.csv")
    with pytest.raises(InputError, match=told):
        read_text(tmp_path / "log.csv", "give a file")


def test_measurements_that_are_no_file_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="is a folder; give the path of a file"):
        measured_text(tmp_path)
    with pytest.raises(InputError, match="no such file; give the path of a file"):
        measured_text(tmp_path / "absent.csv")


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("a = \nb = 1", r"not readable as TOML \(.*line 1.*\); mend that place"),
        (f"a = {'[' * 5000}", "lists or tables are nested too deep; nest them less"),
        (f"a = {'9' * 5000}", "a whole number has more digits than can be read; shorten it"),
    ],
    ids=["syntax", "nesting", "digits"],
)
def test_the_remedy_fits_what_is_wrong_in_toml(text: str, sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        tables_of(text, "study.toml")
