"""Terms in a machine: from an experiment into equations, FMUs and SSPs that other tools run alike."""

from __future__ import annotations

import shutil
import zipfile
from pathlib import Path

import fmpy
import fmpy.fmi2
import numpy as np
import pytest

from tests.referees import libcosim
from warmlink.fmus.component.instance import Instance
from warmlink.fmus.errors import InputError
from warmlink.fmus.heat_term.component import STORED, read_stored
from warmlink.orchestration.catalogue import controller
from warmlink.orchestration.diagnosis.practice.hidden import Truth, simulate
from warmlink.orchestration.diagnosis.practice.hidden_terms import hidden_term
from warmlink.orchestration.fmu_store import FMU_KINDS, FmuStore
from warmlink.orchestration.machine.heat_paths import built_system, rig_in, with_paths
from warmlink.orchestration.machine.read import machine_of
from warmlink.orchestration.machine.rig import rig
from warmlink.orchestration.machine.terms import PlacedTerm, placed_term, term_fmu, with_terms
from warmlink.orchestration.master.algorithms.explicit import Jacobi
from warmlink.orchestration.master.run import simulate as run
from warmlink.orchestration.scenarios.duties.duty import Segment
from warmlink.orchestration.system.description import read_description
from warmlink.orchestration.system.model import System
from warmlink.orchestration.system.write import write_ssp

CELL = rig("WarmupCell")
LAW = "a * (max(speed - b, 0) / w)**1.5 + g * lag(shaft_temperature - ambient_temperature, tau)"
VALUES: dict[str, str | float] = {"a": "2 W", "b": "5 rpm", "w": "1 rad/s", "g": "0.2 W/K", "tau": "5 min"}


def placed(law: str = LAW, into: str = "base", **values: str | float) -> PlacedTerm:
    return placed_term(CELL, "gear", law, into, values or VALUES, "e.toml: term.gear")


@pytest.fixture(scope="module")
def extended() -> System:
    """The cell with a term into the link's base, at work."""
    system, _ = with_paths(built_system(CELL.machine, FmuStore("native")), {"gear": placed()})
    system.components["duty"].values.update({"duration[1]": 900.0, "segment_speed[1]": 3.0})
    return system


@pytest.mark.parametrize(
    ("law", "into", "values", "said"),
    [
        ("a * sped", "shaft", {"a": 1.0}, "did you mean speed?"),
        ("a * motor.sped", "shaft", {"a": 1.0}, "motor.sped"),
        ("a * speed", "gearbox", {"a": 1.0}, "gearbox"),
        ("a * speed", "link.base_temperature", {"a": 1.0}, "not in W"),
        ("a * speed", "motor.heat_flow", {"a": 1.0}, "no input"),
        ("a * speed", "shaft", {"a": 1.0, "b": 2.0}, "b is not in the law"),
        ("a * speed", "shaft", {"a": "1 blorg"}, "blorg"),
        ("a * speed", "shaft", {"a": "nan"}, "finite"),
    ],
)
def test_what_does_not_fit_the_machine_is_refused(
    law: str, into: str, values: dict[str, str | float], said: str
) -> None:
    with pytest.raises(InputError) as refused:
        placed(law, into, **values)
    assert said in str(refused.value)
    assert str(refused.value).startswith("e.toml: term.gear")


def test_a_term_may_not_be_called_as_a_part() -> None:
    with pytest.raises(InputError, match="rename"):
        placed_term(CELL, "motor", "a", "shaft", {"a": 1.0}, "e.toml: term.motor")


@pytest.mark.parametrize("kind", FMU_KINDS)
def test_its_fmu_holds_the_equation_and_the_term(kind: str) -> None:
    with zipfile.ZipFile(term_fmu(placed().term, FmuStore(kind))) as archive:  # type: ignore[arg-type]
        page = archive.read("documentation/index.html").decode()
        assert read_stored(archive.read(STORED)) == placed().term
    assert LAW in page
    assert "<code>tau</code> = 300 s" in page


def test_a_rig_with_its_equations_is_the_rig_with_its_fmu(extended: System) -> None:
    fast, read = with_terms(CELL, {"gear": placed()}), rig_in(extended)
    assert not fast.in_loop
    assert not read.in_loop
    assert set(fast.machine.wires) == set(read.machine.wires)
    assert fast.component.x.names == read.component.x.names
    p, u = read.component.start_values({"motor.speed": 3.0, "gear.speed": 3.0})
    x = np.linspace(290.0, 310.0, fast.component.x.size)
    one, other = (each.component.rates_of(x, u, each.component.settled(p), 7.0) for each in (fast, read))
    assert one == pytest.approx(other, rel=1e-14)


def test_a_machine_with_a_term_is_joined() -> None:
    """Before an input that nothing feeds too, whose value the term's own input takes."""
    base = built_system(CELL.machine, FmuStore("native"))
    base.components["motor"].values["added_shaft_heat"] = 1.5
    system, moved = with_paths(base, {"gear": placed(into="shaft")})
    machine = machine_of(system, ["compensator"])
    assert moved == {"motor.added_shaft_heat": "gear.to_heat_flow"}
    assert not machine.never_joined
    joined = machine.joined(controller("none"))
    assert "gear.lagged[1]" in joined.x.names
    assert joined.start_values()[1][joined.u.index["gear.to_heat_flow"]] == 1.5


def test_the_extended_model_is_the_truth_that_hides_the_terms() -> None:
    """The joined equations against a solver that shares none of them, with a term at each place."""
    laws = {
        "shaft": "4 * (speed / 3) * lag(speed / 3, 300)",
        "winding": "6 * step(torque - 1) * step(time - 100)",
        "base": "0.3 * (winding_temperature - base_temperature)",
        "tip": "2e-9 * (base_temperature**4 - tip_temperature**4)",
    }
    cell = rig("WarmupCell", 20)
    terms = {f"at_{each}": placed_term(cell, f"at_{each}", law, each, {}, "t") for each, law in laws.items()}
    instance = Instance(with_terms(cell, terms).component)
    inputs = instance.component.u.names
    instance.set(
        {n: 3.0 if n.endswith(".speed") else 2.0 for n in inputs if n.endswith((".speed", ".torque"))}
    )
    instance.initialize()
    for k in range(10):
        instance.step(30.0 * k, 30.0)
    times, duty = np.array([0.0, 300.0]), [Segment(300.0, 3.0, 2.0)]
    hidden = tuple(hidden_term(f"{place}: {law}") for place, law in laws.items())
    true, bare = (simulate(each, duty, times) for each in (Truth(terms=hidden), Truth()))
    for name in ("shaft", "winding", "base", "tip"):
        part = "motor" if name in ("shaft", "winding") else "link"
        modelled, seen = instance.get(f"{part}.{name}_temperature"), getattr(true, name)[-1]
        assert modelled == pytest.approx(seen, abs=0.02)
        assert abs(seen - getattr(bare, name)[-1]) > 0.2


def test_fmpy_says_the_same_heat(extended: System) -> None:
    """The FMU by itself in FMPy, fed with what our master gave it, step by step."""
    given = ("motor.shaft_temperature", "duty.ambient_temperature", "motor.heat_flow", "duty.speed")
    said = ("gear.heat", "gear.total_to_heat_flow")
    result = run(extended, 300.0, 1.0, Jacobi(), record=[*given, *said])
    info = read_description(extended.components["gear"].fmu).variables
    inputs = ("shaft_temperature", "ambient_temperature", "to_heat_flow", "speed")
    references = [info[name].value_reference for name in inputs]
    theirs = []
    fmu = str(extended.components["gear"].fmu)
    unzipped = fmpy.extract(fmu)
    description = fmpy.read_model_description(fmu)
    slave = fmpy.fmi2.FMU2Slave(
        guid=description.guid,
        unzipDirectory=unzipped,
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="gear",
    )
    slave.instantiate()
    slave.setupExperiment(startTime=0.0)
    slave.enterInitializationMode()
    slave.exitInitializationMode()
    for k in range(300):
        slave.setReal(references, [float(result[name][k]) for name in given])
        slave.doStep(float(k), 1.0)
        theirs.append(slave.getReal([info[name.split(".")[1]].value_reference for name in said]))
    slave.terminate()
    slave.freeInstance()
    shutil.rmtree(unzipped)
    ours = np.column_stack([result[name] for name in said])
    assert np.abs(np.array(theirs) - ours[1:]).max() < 1e-9
    assert ours[-1, 0] > 5.0


@pytest.mark.platform
def test_libcosim_agrees(extended: System, tmp_path: Path) -> None:
    watched = ("gear.heat", "gear.total_to_heat_flow", "link.elongation", "motor.shaft_temperature")
    result = run(extended, 300.0, 1.0, Jacobi(), record=watched)
    ours = np.column_stack([result[name] for name in watched])[1:]
    write_ssp(extended, tmp_path / "extended.ssp")
    references = [
        (name, read_description(extended.components[name.split(".")[0]].fmu).variables[name.split(".")[1]])
        for name in watched
    ]
    theirs = libcosim(tmp_path / "extended.ssp", 300, [(n, v.value_reference) for n, v in references])
    assert np.abs(theirs - ours).max() < 1e-9
    assert ours[-1, 0] > 1.0
