"""No text takes long to be told from a unit, a value or a header, however long it is."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from warmlink.fmus.errors import InputError
from warmlink.orchestration.diagnosis.data.experiment import read_experiment

GAP = " " * 100_000
CASES = {
    "unit": ("system.units", "parse_unit('Nparameterambient_temperature_of_the_room [degC')"),
    "value": ("written.entries", "quantity('1' + GAP + 'x\\ny', 's', 'stop_time')"),
}


@pytest.mark.parametrize("case", CASES)
def test_it_is_refused_at_once(case: str) -> None:
    """In another process, for a search that tries every way does not let itself be stopped."""
    module, call = CASES[case]
    name = call.replace("list(", "").partition("(")[0]
    script = (
        "from warmlink.fmus.errors import InputError\n"
        f"from warmlink.orchestration.{module} import {name}\n"
        f"GAP = ' ' * {len(GAP)}\n"
        f"try:\n    {call}\nexcept InputError as fault:\n    print(str(fault)[:300])\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, timeout=20, check=True
    )
    assert "is no" in done.stdout


@pytest.mark.parametrize("function", ["name_and_unit", "with_suffix"])
def test_a_header_is_read_at_once(function: str) -> None:
    script = (
        f"from warmlink.orchestration.scenarios.logged.layout import {function}\n"
        f"print(len(list({function}('a' + {len(GAP)} * ' ' + {len(GAP)} * '(' + 'x)'))))"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, timeout=20, check=True
    )
    assert done.stdout.strip() == {"name_and_unit": "2", "with_suffix": "0"}[function]


def test_a_long_header_without_rows_is_refused_in_few_words(tmp_path: Path) -> None:
    path = tmp_path / "run.csv"
    path.write_text(";".join(f"axis{i}.tip_temperature [degC]" for i in range(60)) + "\n")
    with pytest.raises(InputError, match="no rows below its only line") as refusal:
        read_experiment(path)
    assert len(str(refusal.value)) < 250
