"""What other packages add: what it names, and why it is refused."""

from __future__ import annotations

from pathlib import Path

import pytest

from warmlink.fmus import plugins as room
from warmlink.fmus.errors import InputError
from warmlink.fmus.plugins import Plugin, plugins


def test_a_place_is_a_module_or_a_name_in_it() -> None:
    assert Plugin("masters", "a", "fractions:Fraction", "p").load().__name__ == "Fraction"
    assert Plugin("causes", "a", "fractions", "p").load().__name__ == "fractions"


@pytest.mark.parametrize(
    ("source", "sentence"),
    [
        ("", r"does not load \(AttributeError: .*MADE"),
        ("raise SystemExit(3)", r"does not load \(SystemExit: 3\)"),
        ("import nowhere_at_all", r"does not load \(ModuleNotFoundError"),
    ],
)
def test_code_that_does_not_load_is_refused(
    source: str, sentence: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    module = f"added_{abs(hash(source))}"
    (tmp_path / f"{module}.py").write_text(source, "utf-8")
    monkeypatch.syspath_prepend(str(tmp_path))
    with pytest.raises(
        InputError, match=f"^{module}:MADE: the package theirs adds it .* as made: {sentence}"
    ):
        Plugin("laws", "made", f"{module}:MADE", "theirs").load()


def test_two_of_one_name_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    made = tuple(Plugin("laws", "half", f"{of}:LAW", of) for of in ("one", "two"))
    other = Plugin("masters", "half", "three:MASTER", "three")
    monkeypatch.setattr(room, "installed", lambda: (*made, other))
    assert plugins("masters") == (other,)
    with pytest.raises(InputError, match=r"the package two adds it .*: one adds another one"):
        plugins("laws")
