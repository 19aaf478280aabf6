"""No text takes long to be told from a unit, a value or a header, however long it is."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from warmlink.fmus.errors import InputError
from warmlink.orchestration.diagnosis.data.experiment import read_experiment

GAP = 100_000
"""Blanks in a text."""
ASKED = f"""
from warmlink.fmus.errors import InputError
from warmlink.orchestration.scenarios.logged.layout import name_and_unit, with_suffix
from warmlink.orchestration.system.units import parse_unit
from warmlink.orchestration.written.entries import quantity

def refused(call):
    try:
        call()
    except InputError as fault:
        print(str(fault)[:300].splitlines()[0], flush=True)

gap = {GAP} * " "
refused(lambda: parse_unit("Nparameterambient_temperature_of_the_room [degC"))
refused(lambda: quantity("1" + gap + "x\\ny", "s", "stop_time"))
header = "a" + gap + {GAP} * "(" + "x)"
print(len(name_and_unit(header)), flush=True)
print(len(list(with_suffix(header))), flush=True)
"""


def test_it_is_refused_or_read_at_once() -> None:
    """In another process, for a search that tries every way does not let itself be stopped."""
    done = subprocess.run(
        [sys.executable, "-c", ASKED], capture_output=True, text=True, timeout=20, check=True
    )
    unit, value, *lengths = done.stdout.splitlines()
    assert "is no" in unit
    assert "is no" in value
    assert lengths == ["2", "0"]


def test_a_long_header_without_rows_is_refused_in_few_words(tmp_path: Path) -> None:
    path = tmp_path / "run.csv"
    path.write_text(";".join(f"axis{i}.tip_temperature [degC]" for i in range(60)) + "\n")
    with pytest.raises(InputError, match="no rows below its only line") as refusal:
        read_experiment(path)
    assert len(str(refusal.value)) < 250
