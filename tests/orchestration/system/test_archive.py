"""Archives and XML from strangers: nothing leaves its folder, fills the disk or expands."""

from __future__ import annotations

import errno
import stat
import struct
import zipfile
from pathlib import Path

import pytest

from warmlink.fmus.errors import InputError
from warmlink.orchestration.system.archive import (
    XML_LIMIT_BYTES,
    extract,
    read_member,
    repeated_entries,
    safe_relative,
    unpack,
)
from warmlink.orchestration.system.ssp.parameter_values import read_ssv
from warmlink.orchestration.system.xml import parse_xml

from .ssp_text import write_zip

ARCHIVE = "warmlink.orchestration.system.archive"


def refused(path: Path, target: Path) -> str:
    with pytest.raises(InputError) as refusal:
        extract(path, target)
    # Nothing half-written is left, neither the folder nor what it was made from.
    assert not target.exists()
    assert [p.name for p in target.parent.iterdir() if p.name.startswith(".unpacking")] == []
    return str(refusal.value)


def test_a_whole_archive_comes_out(tmp_path: Path) -> None:
    path = write_zip(tmp_path / "a.fmu", {"modelDescription.xml": "<a/>", "sources/b/c.c": b"\0" * 10})
    extract(path, tmp_path / "out")
    assert (tmp_path / "out/sources/b/c.c").read_bytes() == b"\0" * 10


@pytest.mark.parametrize(
    "name", ["../evil", "a/../../evil", "/etc/evil", "C:/evil", "..\\evil", "\\\\host\\evil"]
)
def test_a_way_out_of_the_folder_is_refused(tmp_path: Path, name: str) -> None:
    path = write_zip(tmp_path / "a.fmu", {name: "evil"})
    assert "outside the folder" in refused(path, tmp_path / "deep/er/out")
    assert list(tmp_path.rglob("evil")) == []


def test_a_link_is_refused(tmp_path: Path) -> None:
    info = zipfile.ZipInfo("link")
    info.external_attr = (stat.S_IFLNK | 0o777) << 16
    with zipfile.ZipFile(tmp_path / "a.fmu", "w") as archive:
        archive.writestr(info, "/etc/passwd")
    assert "is a link" in refused(tmp_path / "a.fmu", tmp_path / "out")


@pytest.mark.filterwarnings("ignore:Duplicate name")
def test_of_a_name_that_stands_twice_the_last_entry_counts_wherever_it_is_read(tmp_path: Path) -> None:
    path = tmp_path / "a.fmu"
    with zipfile.ZipFile(path, "w") as archive:
        for content in ("1", "2", "3"):
            archive.writestr("a", content)
        archive.writestr("b", "4")
    extract(path, tmp_path / "out")
    assert (tmp_path / "out/a").read_text() == "3"
    assert read_member(path, "a") == b"3"
    assert repeated_entries(path) == ("a.fmu: holds 'a' 3 times; the last one counts",)


def test_two_spellings_of_one_file_are_refused(tmp_path: Path) -> None:
    path = write_zip(tmp_path / "a.fmu", {"a/b": "1", "a/./b": "2"})
    assert "'a/b' in two spellings" in refused(path, tmp_path / "out")


def test_a_file_where_a_folder_should_be_is_refused(tmp_path: Path) -> None:
    path = write_zip(tmp_path / "a.fmu", {"a": "1", "a/b": "2"})
    assert "not a readable zip" in refused(path, tmp_path / "out")


@pytest.mark.parametrize(
    ("limits", "reason"),
    [
        ({"MOST_MEMBERS": 2}, "holds 3 entries, more than the 2 allowed"),
        ({"MEMBER_BYTES": 999}, "'b' unpacks to more than 999 bytes"),
        ({"TOTAL_BYTES": 1500}, "unpacks to more than 1500 bytes"),
        ({"RATIO": 5, "RATIO_FROM_BYTES": 100}, "more than 5 times its packed size"),
    ],
)
def test_too_much_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, limits: dict[str, float], reason: str
) -> None:
    for name, limit in limits.items():
        monkeypatch.setattr(f"{ARCHIVE}.{name}", limit)
    with zipfile.ZipFile(tmp_path / "a.fmu", "w", zipfile.ZIP_DEFLATED) as archive:
        for name, size in (("a", 90), ("b", 1000), ("c", 900)):
            archive.writestr(name, b"\0" * size)
    assert reason in refused(tmp_path / "a.fmu", tmp_path / "out")


def test_what_an_archive_claims_does_not_count(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """An entry that says it unpacks to 10 bytes and unpacks to a million is stopped."""
    monkeypatch.setattr(f"{ARCHIVE}.MEMBER_BYTES", 1000)
    with zipfile.ZipFile(tmp_path / "a.fmu", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("a", b"\0" * 1_000_000)
    data = (tmp_path / "a.fmu").read_bytes()
    (tmp_path / "a.fmu").write_bytes(data.replace(struct.pack("<L", 1_000_000), struct.pack("<L", 10)))
    assert "not a readable zip" in refused(tmp_path / "a.fmu", tmp_path / "out")


@pytest.mark.parametrize("data", [b"", b"PK", b"no zip at all", b"PK\x05\x06" + b"\0" * 18 + b"junk"])
def test_a_broken_archive_is_named(tmp_path: Path, data: bytes) -> None:
    (tmp_path / "a.fmu").write_bytes(data)
    with pytest.raises(InputError, match=r"a\.fmu: (not a readable zip|holds no modelDescription)"):
        read_member(tmp_path / "a.fmu", "modelDescription.xml")


def test_an_absent_file_is_named(tmp_path: Path) -> None:
    for use in (lambda p: unpack(p, tmp_path), lambda p: read_member(p, "a")):
        with pytest.raises(InputError, match="no such file"):
            use(tmp_path / "a.ssp")


def test_one_archive_is_unpacked_once_and_another_of_its_name_apart(tmp_path: Path) -> None:
    path = write_zip(tmp_path / "a.ssp", {"x": "1"})
    first = unpack(path, tmp_path / "work")
    assert unpack(path, tmp_path / "work") == first
    write_zip(path, {"x": "2"})
    second = unpack(path, tmp_path / "work")
    assert second != first
    assert ((first / "x").read_text(), (second / "x").read_text()) == ("1", "2")


def test_relative_names() -> None:
    assert safe_relative("./resources//a.fmu") == "resources/a.fmu"
    assert safe_relative("resources\\a.fmu") == "resources/a.fmu"
    assert [safe_relative(n) for n in ("..", "a/../..", "/a", "D:a", "a\0b", "a" * 300)] == [None] * 6


BOMB = '<!DOCTYPE a [<!ENTITY x "ha"><!ENTITY y "&x;&x;&x;&x;&x;&x;&x;&x;">]><a b="&y;">&y;</a>'
FILE = '<!DOCTYPE a [<!ENTITY x SYSTEM "file:///etc/passwd">]><a>&x;</a>'
OUTER = '<!DOCTYPE a SYSTEM "http://127.0.0.1:9/a.dtd"><a/>'


@pytest.mark.parametrize("text", [BOMB, FILE, OUTER])
@pytest.mark.parametrize("encoding", ["utf-8", "utf-16"])
def test_entities_are_refused_before_they_are_read(text: str, encoding: str) -> None:
    with pytest.raises(InputError, match="document type"):
        parse_xml(text.encode(encoding), "a.ssd")


def test_a_deep_document_is_refused() -> None:
    with pytest.raises(InputError, match="not well-formed XML"):
        parse_xml(b"<a>" * 100_000, "a.ssd")


def test_comments_and_instructions_are_left_out() -> None:
    assert [e.tag for e in parse_xml(b"<a><!-- c --><?p q?><b/></a>", "a.ssd")] == ["b"]


@pytest.mark.parametrize("method", [zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA])
def test_packing_that_unpacks_without_bound_is_refused(tmp_path: Path, method: int) -> None:
    with zipfile.ZipFile(tmp_path / "a.fmu", "w", method) as archive:
        archive.writestr("modelDescription.xml", b"\0" * 1000)
    assert "another method than deflate" in refused(tmp_path / "a.fmu", tmp_path / "out")
    with pytest.raises(InputError, match="another method than deflate"):
        read_member(tmp_path / "a.fmu", "modelDescription.xml")


def test_a_list_of_entries_that_fills_the_memory_is_refused_before_it_is_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(f"{ARCHIVE}.DIRECTORY_LIMIT_BYTES", 1 << 20)
    path = tmp_path / "a.fmu"
    end = struct.pack("<4s4H2LH", b"PK\5\6", 0, 0, 65535, 65535, 2 << 20, 0, 0)
    path.write_bytes(b"PK\1\2" * (1 << 19) + end)
    assert "its list of entries takes more than 1 MiB" in refused(path, tmp_path / "out")


@pytest.mark.parametrize(
    "text",
    ["<a/>" * 500_001, "<a " + 'b="" ' * 4_000_000 + "/>"],
    ids=["tags", "attributes"],
)
def test_xml_whose_tree_fills_the_memory_is_refused_before_it_is_parsed(text: str) -> None:
    with pytest.raises(InputError, match=r"x: (has more than 500000 tags|is larger than 16 MiB)"):
        parse_xml(f"<r>{text}</r>".encode(), "x")


def test_a_full_disk_is_not_called_a_broken_archive(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write_zip(tmp_path / "a.fmu", {"modelDescription.xml": "<a/>" * 1000})

    def full(*_: object, **__: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(Path, "open", full)
    assert "cannot be unpacked into" in refused(path, tmp_path / "out")
    monkeypatch.setattr("tempfile.mkdtemp", full)
    assert "No space left on device" in refused(path, tmp_path / "out")


def test_start_values_beyond_the_limit_are_called_so(tmp_path: Path) -> None:
    large = tmp_path / "large.ssv"
    large.write_bytes(b"<a>" + b" " * XML_LIMIT_BYTES + b"</a>")
    with pytest.raises(InputError, match=r"large\.ssv: is larger than 16 MiB, the limit; make it smaller"):
        read_ssv(large)
