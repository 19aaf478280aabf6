"""Speed, torque, surroundings and thermometers that are lost: each law goes on, and says so."""

import math

import numpy as np
import pytest

from warmlink.controllers.interface import SENSED
from warmlink.controllers.lag.component import COMPONENT as LAG
from warmlink.fmus.component import Component
from warmlink.fmus.component.instance import Instance
from warmlink.orchestration.catalogue import controllers

COLD = 295.15
LAWS = sorted(controllers().values(), key=lambda component: component.name)


def running(component: Component, values: dict[str, float]) -> Instance:
    instance = Instance(component)
    instance.set(values)
    instance.initialize()
    return instance


DUTY = ("speed", "torque", "ambient_temperature")


@pytest.mark.parametrize("component", LAWS, ids=lambda c: c.name)
@pytest.mark.parametrize("lost", DUTY)
def test_a_duty_signal_that_is_lost_is_no_error_of_the_law(component: Component, lost: str) -> None:
    """The README said that it was handled; the FMU refused to set it."""
    instance = running(component, dict.fromkeys(SENSED, COLD) | {"speed": 3.0, "torque": 2.0})
    for k in range(60):
        instance.set({lost: math.nan if 20 <= k < 40 else {"speed": 3.0, "torque": 2.0}.get(lost, COLD)})
        instance.step(float(k), 1.0)
        assert np.isfinite(instance.outputs()).all()
        missed = 20 <= k < 40 and component.name not in {"NoCompensator", "AnalyticCompensator"}
        if missed and component.name != "RegressionCompensator" and (component, lost) != (LAG, DUTY[2]):
            assert instance.get("distrusted") == 1.0
            assert instance.get("ready") == 0.0


@pytest.mark.parametrize("component", LAWS, ids=lambda c: c.name)
def test_a_law_may_start_without_any_signal(component: Component) -> None:
    instance = running(component, dict.fromkeys((*SENSED, *DUTY), math.nan))
    instance.step(0.0, 1.0)
    assert np.isfinite(instance.outputs()).all()
