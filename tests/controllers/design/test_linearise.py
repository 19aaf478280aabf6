"""Any component as a linear state space of python-control."""

from typing import Any

import numpy as np
import pytest

from warmlink.controllers.design.linearise import linearise, slopes, start
from warmlink.fmus.component.reference import Phase, integrate
from warmlink.fmus.errors import InputError
from warmlink.fmus.plant import plant
from warmlink.fmus.thermal_link.component import COMPONENT as LINK

control = pytest.importorskip("control", reason="python-control comes with the extra `studies`")


def test_signals_bear_the_components_names() -> None:
    system = linearise(plant())
    layouts = (plant().u, plant().y, plant().continuous)
    labels = (system.input_labels, system.output_labels, system.state_labels)
    for layout, found in zip(layouts, labels, strict=True):
        assert found == [name.replace(".", "_") for name in layout.names]


def test_a_link_answers_a_small_heat_as_its_linear_model_does() -> None:
    """Without radiation the link is linear, so that the two are one but for the tolerance."""
    system = linearise(LINK)[["elongation"], ["heat_flow"]]
    times = np.linspace(0.0, 600.0, 13)
    linear = control.step_response(system, times).outputs.ravel()
    found = integrate(LINK, [Phase(600.0, {"heat_flow": 1.0})], ["elongation"], every=50.0, tolerance=1e-11)
    assert linear == pytest.approx(found.values["elongation"], abs=1e-12)


def test_the_slowest_pole_is_slower_than_either_part_alone() -> None:
    """Heat that leaves the motor into the link comes back; alone, the base would take it away."""
    poles = np.real(linearise(plant()).poles())
    moving = poles[poles < -1e-12]
    assert (poles < 1e-12).all()
    assert -1 / moving.max() > 600.0


def test_the_point_can_be_chosen() -> None:
    fast = linearise(plant(), start(plant(), {"link.speed": 3.0}))
    still = linearise(plant())
    assert np.trace(fast.A) < np.trace(still.A)


def test_names_that_do_not_exist_are_refused() -> None:
    with pytest.raises(InputError, match=r"link\.colour: ThermalLink has no such variable"):
        start(plant(), {"link.colour": 1.0})


def test_slopes_by_what_a_component_has_not_are_refused() -> None:
    with pytest.raises(InputError, match="ThermalLink: sped is no state, input or parameter of it"):
        slopes(LINK.rates_of, LINK, start(LINK), ["speed", "sped"])


def test_only_a_component_is_linearised() -> None:
    nothing: Any = None
    with pytest.raises(InputError, match="component=None: is no component"):
        linearise(nothing)
