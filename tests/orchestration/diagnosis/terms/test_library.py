"""The library of terms: every form is heat, and its course is what the component of it gives."""

from __future__ import annotations

import numpy as np
import pytest

from warmlink.fmus.component.instance import Instance
from warmlink.fmus.heat_term.component import HeatTerm, heat_term
from warmlink.fmus.heat_term.dimension import refuse_other_than_heat
from warmlink.fmus.heat_term.law import FUNCTIONS, HeatLaw, PlainNumber, power
from warmlink.orchestration.diagnosis.causes.catalogue import catalogue
from warmlink.orchestration.diagnosis.ladder.baselines import filtered
from warmlink.orchestration.diagnosis.terms.library import (
    FORMS,
    MORE,
    UNITS,
    Candidate,
    Form,
    candidates,
)
from warmlink.orchestration.diagnosis.terms.missing import _onto
from warmlink.orchestration.diagnosis.terms.shape import ShapeNumber

SIGNALS = {
    "speed": np.array([0.0, 1.0, 1.0, 4.0]),
    "torque": np.array([0.0, 2.0, 5.0, 1.0]),
    "ambient_temperature": np.array([295.0, 295.5, 295.0, 294.0]),
    **{f"{name}_temperature": np.array([295.0, 299.0, 305.0, 315.0]) for name in ("shaft", "winding")},
    **{f"{name}_temperature": np.array([295.0, 297.0, 300.0, 304.0]) for name in ("base", "tip")},
}
EVERY = list(candidates(SIGNALS, ("shaft", "winding", "base", "tip")))
UNIT = {"speed": "rad/s", "torque": "N.m"}


@pytest.mark.parametrize("form", FORMS, ids=lambda form: form.about)
def test_a_form_is_heat(form: Form) -> None:
    here = form.at(form.places[0])
    units: dict[str, str | None] = {name: UNIT.get(name, "K") for name in here.variables}
    units |= {name: unit for name, (_, unit) in {**UNITS, **MORE}.items()}
    units |= {"a": "W", **{each.name: each.unit for each in form.shapes}}
    refuse_other_than_heat(HeatLaw(here.heat), units)


def test_a_form_in_disguise_names_a_cause_that_is_there() -> None:
    known = {each.name for each in catalogue()}
    said = {cause for form in FORMS for cause in form.causes.values()}
    assert said <= known
    assert {"coulomb_friction", "viscous_friction", "copper_loss", "standby_heat"} <= said


def test_forms_are_told_apart_by_their_names() -> None:
    names = [form.about for form in FORMS]
    assert len(set(names)) == len(names)


def test_every_form_is_tried_where_it_may_enter() -> None:
    assert {each.form.about for each in EVERY} == {form.about for form in FORMS}
    assert all(each.place in each.form.places for each in EVERY)


def test_a_switch_lies_between_two_levels() -> None:
    assert ShapeNumber("b", "rad/s", of="speed", fitted=False).tried(SIGNALS) == (0.5, 2.5)
    dead = ShapeNumber("b", "rad/s", of="speed").tried(SIGNALS)
    assert min(dead) > 0.0
    assert max(dead) < 4.0


def test_a_machine_that_has_no_torque_gets_no_form_with_it() -> None:
    some = {name: values for name, values in SIGNALS.items() if name != "torque"}
    assert not any("torque" in each.form.heat for each in candidates(some, ("shaft",)))


@pytest.mark.parametrize("candidate", EVERY[::7], ids=lambda each: f"{each.form.about}, {each.place}")
def test_the_course_of_a_candidate_is_what_its_component_gives(candidate: Candidate) -> None:
    form = candidate.form
    shape = {each.name: (v, each.unit) for each, v in zip(form.shapes, candidate.shape, strict=True)}
    names = HeatLaw(form.heat).variables
    parameters = {n: v for n, v in {"a": (1.5, "W"), **candidate.fixed, **shape}.items() if n in names}
    term = HeatTerm("Tried", form.heat, {n: UNIT.get(n, "K") for n in form.variables}, parameters)
    instance, step = Instance(heat_term(term)), 20.0
    instance.set({name: float(SIGNALS[name][0]) for name in form.variables})
    instance.initialize()
    heat = [instance.get("heat")]
    for k in range(1, 4):
        instance.step(step * (k - 1), step)
        instance.set({name: float(SIGNALS[name][k]) for name in form.variables})
        heat.append(instance.get("heat"))
    time = step * np.arange(4.0)

    def lag(follows: np.ndarray, constant: float) -> np.ndarray:
        table = np.broadcast_to(np.asarray(follows, dtype=float), time.shape)[:, None]
        return filtered(time, np.vstack([table[:1], table[:-1]]), constant)[:, 0]

    values = {**{n: v for n, (v, _) in parameters.items()}, **SIGNALS, "time": time}
    course = HeatLaw(form.heat).in_arithmetic(
        values.__getitem__, {**FUNCTIONS, "lag": (2, lag)}, power, PlainNumber
    )
    assert np.broadcast_to(course, time.shape) == pytest.approx(np.array(heat), rel=2e-3, abs=1e-9)


def test_a_heat_that_holds_is_projected_onto_broken_lines() -> None:
    nodes, time = np.linspace(0.0, 600.0, 11), np.arange(0.0, 601.0, 10.0)
    assert _onto(nodes, time) @ np.full(61, 3.0) == pytest.approx(np.full(11, 3.0))
    jumps = np.where(time < 290.0, 0.0, 2.0)
    projected = _onto(nodes, time) @ jumps
    assert np.trapezoid(projected, nodes) == pytest.approx(2.0 * 310.0, rel=0.02)
