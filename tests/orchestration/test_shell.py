"""No name in a command that people are told to copy runs in the shell that they paste it into."""

from __future__ import annotations

import os
import shlex
import subprocess
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from warmlink.fmus.errors import InputError
from warmlink.orchestration.closed_loop.belief import design_check
from warmlink.orchestration.closed_loop.load import load_scenario
from warmlink.orchestration.scenarios.scenario import changed
from warmlink.orchestration.shell import command, quoted

pytestmark = pytest.mark.skipif(os.name == "nt", reason="asks a shell of POSIX")
HOSTILE = "$(touch ran)`touch ran`;touch ran;'\"&| ~!*"


@given(st.lists(st.text(st.characters(codec="utf-8", exclude_characters="\0")), min_size=1, max_size=4))
@settings(deadline=None, max_examples=300)
def test_a_shell_reads_the_words_that_were_written(words: list[str]) -> None:
    assert shlex.split(command("warmlink", *words)) == ["warmlink", *words]


@pytest.mark.parametrize(
    "word", [HOSTILE, "a b", "$HOME", "~", "*", "a\nb", "\\", "'", '"', "#", "a=b c", "été"]
)
def test_a_shell_runs_nothing_of_a_word(word: str, tmp_path: Path) -> None:
    line = command("printf", "%s|", word, "end")
    done = subprocess.run(["sh", "-c", line], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert done.stdout == f"{word}|end|"
    assert list(tmp_path.iterdir()) == []


def test_what_needs_no_quotes_has_none_and_a_path_is_no_option() -> None:
    assert command("warmlink", "run", "my_cell.toml") == "warmlink run my_cell.toml"
    assert quoted("motor.x=2 W/K") == '"motor.x=2 W/K"'
    assert quoted(Path("-rf.ssp")) == "./-rf.ssp"


@pytest.mark.parametrize("suffix", [".ssp", ".fmu", ".ssv"])
def test_a_file_that_is_no_scenario(suffix: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    path = Path(f"{HOSTILE}{suffix}")
    path.touch()
    with pytest.raises(InputError) as refused:
        load_scenario(str(path))
    assert shlex.split(str(refused.value).rpartition("warmlink ")[2])[-1] == str(path)


def test_a_law_that_is_to_be_designed_anew(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    path = Path(f"{HOSTILE}.toml")
    path.write_text('duty = "stop_and_go"\n[parameters]\n"link.length" = "800 mm"\n')
    asked = changed(load_scenario(str(path)), "observer", {"motor.joint_conductance": "2 W/K"}, ())
    told, _ = design_check(asked)
    assert told is not None
    words = shlex.split(told.partition("design it anew: ")[2].partition("; then add")[0])
    assert words[:3] == ["warmlink", "design", str(path)]
    assert words[3:] == [
        *("--law", "observer", "--set", "motor.joint_conductance=2 W/K", "--out", "observer.ssv")
    ]
