"""A run of a scenario, with changes to what its file says."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType

from warmlink.orchestration.closed_loop.load import load_scenario
from warmlink.orchestration.closed_loop.outcome import ClosedLoop, run_scenario
from warmlink.orchestration.console import progress_bar, remark
from warmlink.orchestration.fmu_store import FmuKind, store
from warmlink.orchestration.scenarios.scenario import DEFAULT_SCENARIO, Scenario, changed


def run(
    scenario: str | Path | Scenario = DEFAULT_SCENARIO,
    controller: str | None = None,
    *,
    parameters: Mapping[str, str | float] | str | Path = MappingProxyType({}),
    mismatches: Sequence[str] = (),
    step: str | float | None = None,
    stop: str | float | None = None,
    master: str | None = None,
    tolerance: str | float | None = None,
    fmus: FmuKind | None = None,
) -> ClosedLoop:
    """Run a scenario with a controller and without one, and compute how far off the tool point is.

    Parameters
    ----------
    scenario : name of a shipped scenario, or a TOML or CSV file; what is not given below stays as it says
    controller : name of a shipped controller, or a law of your own, as `my_law.py:MyLaw`
    parameters : start values, `"2 W/K"` under `motor.joint_conductance`, or the path of a parameter set (SSV)
    mismatches : names or files; several mismatches add up
    step, stop : communication step size and stop time, `"1 h"` or in s
    master : name of the algorithm
    tolerance : largest coupling error, `"0.1 um"` or in m, for which the steps become smaller where needed
    fmus : native (C) or python; by default native if there is a C compiler

    Raises
    ------
    InputError
        If a name does not exist, or a value is refused.
    SlaveError
        If the run failed before its first communication point.
    """
    found = scenario if isinstance(scenario, Scenario) else load_scenario(str(scenario))
    asked = changed(
        found,
        controller=controller,
        parameters=parameters,
        mismatches=mismatches,
        step=step,
        stop=stop,
        master=master,
        tolerance=tolerance,
    )
    with progress_bar(asked.title) as progress:
        return run_scenario(asked, store(fmus, sorted(asked.kinds), remark), progress)
