"""A remainder's inputs find what feeds them in a system, whatever its names; what cannot be fed is told."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from tests.orchestration.system.ssp_text import Lab, fmi2, fmi2_variable
from warmlink.fmus.errors import InputError
from warmlink.fmus.remainder.component import COMPONENT
from warmlink.fmus.remainder.equations import FEATURES
from warmlink.orchestration.diagnosis.answer.extension import write_ssp_of
from warmlink.orchestration.diagnosis.ladder.bank import Bank
from warmlink.orchestration.diagnosis.ladder.delivered import Delivery
from warmlink.orchestration.diagnosis.ladder.predictor import Predictor
from warmlink.orchestration.diagnosis.ladder.remainder import Remainder
from warmlink.orchestration.diagnosis.ladder.wired import with_predictor, with_remainder
from warmlink.orchestration.fmu_store import FmuStore, Remark
from warmlink.orchestration.machine.read import RolesTable, with_roles
from warmlink.orchestration.machine.rig import rig
from warmlink.orchestration.system.assemble import assemble
from warmlink.orchestration.system.model import System

NAMES = ("x.growth", "y.growth", "x.hidden")


def learnt(source: str) -> Remainder:
    """A remainder of the growth that a name stands for."""
    bank = Bank((), {}, "", (1.0, 2.0, 3.0), np.ones(FEATURES))
    return Remainder((), {"elongation_offset": 1e-6}, {"elongation": source}, {}, bank, {})


@pytest.fixture
def portal(tmp_path: Path) -> System:
    """A system of the one component `portal`, of which two outputs and an input have dotted names."""
    variables = (
        *(fmi2_variable(name, "output", attributes='unit="m"') for name in NAMES[:2]),
        fmi2_variable(NAMES[2], "local", attributes='unit="m"'),
        fmi2_variable("x.speed", "input", attributes='start="0"'),
    )
    return assemble("Portal", {"portal": Lab(tmp_path).fmu("Portal", fmi2("Portal", variables))})


@pytest.fixture
def fmus(tmp_path: Path) -> Asked:
    """A store that gives an FMU with the variable which matters here."""
    path = Lab(tmp_path).fmu(
        "Remainder",
        fmi2(
            "Remainder",
            (
                fmi2_variable("elongation", "input", attributes='unit="m" start="0"'),
                fmi2_variable(
                    "elongation_offset",
                    "parameter",
                    attributes='unit="m" start="0"',
                    outer='variability="fixed"',
                ),
            ),
        ),
    )
    return Asked("python", fmu=path)


@dataclass(frozen=True)
class Asked(FmuStore):
    """A store that notes what it is asked for."""

    fmu: Path | None = None
    names: list[str] = field(default_factory=list)

    def files(self, names: Iterable[str], remark: Remark | None = None) -> dict[str, Path]:
        wanted = [*names]
        self.names.extend(wanted)
        return super().files(wanted, remark) if self.fmu is None else dict.fromkeys(wanted, self.fmu)


def test_names_of_variables_may_hold_dots(portal: System, fmus: Asked) -> None:
    whole = with_remainder(portal, learnt("portal.x.growth"), fmus)
    assert [(each.source, each.target) for each in whole.connections] == [
        ("portal.x.growth", "remainder.elongation")
    ]


def test_an_input_that_nothing_feeds_stays_open(portal: System, fmus: Asked) -> None:
    whole = with_remainder(portal, learnt("portal.x.speed"), fmus)
    assert "remainder" in whole.components
    assert whole.connections == ()


@pytest.mark.parametrize("source", ["portal.x.growth + portal.y.growth", "portal.x.hidden", "nobody.growth"])
def test_what_no_output_gives_is_refused(source: str, portal: System, fmus: Asked) -> None:
    with pytest.raises(InputError) as refused:
        with_remainder(portal, learnt(source), fmus)
    assert f"Portal has no output {source}, which the remainder's elongation takes" in str(refused.value)


def test_a_logged_signal_that_no_system_has_is_left_to_connect(
    portal: System, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    inputs = ("hall", "growth")
    variables = tuple(fmi2_variable(name, "input", attributes='unit="m" start="0"') for name in inputs)
    fmu = Lab(tmp_path).fmu("Fits", fmi2("Fits", variables))
    monkeypatch.setattr("warmlink.orchestration.diagnosis.ladder.wired.predictor_file", lambda fits: fmu)
    fits = Predictor(COMPONENT, {"hall": "hall_temperature", "growth": "portal.x.growth"}, {})
    whole = with_predictor(portal, fits)
    assert [(each.source, each.target) for each in whole.connections] == [
        ("portal.x.growth", "predictor.growth")
    ]
    assert "predictor.hall: Portal has no hall_temperature, which it takes" in capsys.readouterr().err


def test_the_remainder_is_of_the_kind_of_fmu_that_was_asked_for(tmp_path: Path) -> None:
    fmus = Asked("native")
    found = cast(Delivery, SimpleNamespace(remainder=learnt("link.elongation"), predictor=None))
    write_ssp_of(rig("WarmupCell"), {}, tmp_path / "extended.ssp", fmus, found)
    assert COMPONENT.name in fmus.names


def test_roles_name_variables_that_hold_dots(portal: System) -> None:
    table = RolesTable(score="portal.x.growth", controller=(), speed=("portal.x.speed",))
    assert with_roles(portal, table, "mine.toml: roles").roles.plant == ("portal.x.growth",)
    with pytest.raises(InputError, match=r"portal\.x\.grown: .*has no variable x\.grown"):
        with_roles(portal, replace(table, score="portal.x.grown"), "mine.toml: roles")
