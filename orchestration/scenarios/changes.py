"""What somebody asks of a scenario beside what its file says."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

from warmlink.orchestration.own_law import controller_named
from warmlink.orchestration.scenarios import mismatch
from warmlink.orchestration.scenarios.quantity import positive
from warmlink.orchestration.scenarios.scenario import Scenario


def changed(
    scenario: Scenario,
    *,
    controller: str | None = None,
    parameters: Mapping[str, str | float] = MappingProxyType({}),
    mismatches: Sequence[str] = (),
    step: str | float | None = None,
    stop: str | float | None = None,
    master: str | None = None,
) -> Scenario:
    """Scenario with what is given changed; the rest is as its file says.

    Parameters
    ----------
    controller : name of a shipped one, or a law of one's own, as `my_law.py:MyLaw`
    parameters : start values, `"2 W/K"` under `motor.joint_conductance`
    mismatches : names or files, one on top of the other
    step, stop : communication step size and stop time, `"1 h"` or in s
    master : name of the algorithm

    Raises
    ------
    InputError
        If there is no such controller or mismatch, or a time is none.
    """
    scenario = replace(
        scenario,
        duty=scenario.duty if stop is None else scenario.duty.until(positive(stop, "s", "--stop")),
        step_size=scenario.step_size if step is None else positive(step, "s", "--step"),
        master=master or scenario.master,
        controller=scenario.controller if controller is None else controller_named(controller),
        parameters={**scenario.parameters, **parameters},
    )
    for name in mismatches:
        scenario = mismatch.load(name).applied(scenario)
    return scenario
