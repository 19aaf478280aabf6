"""Measured runs that are made up, with effects by name and how the run is made."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from importlib import import_module
from typing import TYPE_CHECKING

from warmlink.fmus.arguments import argument
from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead, listed, several
from warmlink.orchestration.closed_loop.load import driven, load_scenario
from warmlink.orchestration.console import remark
from warmlink.orchestration.diagnosis.data.inputs import of_scenario
from warmlink.orchestration.diagnosis.practice import hide
from warmlink.orchestration.diagnosis.practice.effects import effect_of
from warmlink.orchestration.diagnosis.practice.hidden_terms import HiddenTerm, hidden_term
from warmlink.orchestration.machine.heat_paths import rig_of
from warmlink.orchestration.progress import Progress, spinner

if TYPE_CHECKING:
    import pandas

    from warmlink.orchestration.arrays import Array

SOLVERS = {"grid": "hide:hide", "fea": "hidden_fea:hide_with_fea"}
"""What computes a made-up run: a rod on a grid, or 3-D finite elements."""

NOISES = {"white": hide.WHITE, "real": hide.REAL}


def hide_effects(
    effects: Mapping[str, float] | Iterable[str] = (),
    duty: str | None = None,
    *,
    scenario: str | None = None,
    seed: int = 0,
    noise: str = "white",
    solver: str = "grid",
    axis: int | None = None,
    terms: str | Iterable[str] = (),
) -> pandas.DataFrame:
    """Make up a measured run that contains hidden effects, to practise `diagnose` on.

    The run is computed by another solver than the one that `diagnose` uses; that of a machine of one's own
    by its FMUs.

    Parameters
    ----------
    effects : names of effects, as `radiation` or `sensor_lag:tip_temperature`, or their strengths in SI units
        by name; in a machine of one's own `joint_resistance:x_motor` if it has several motors, or the value
        of any parameter by its full name
    duty : duty cycle (CSV) or scenario (TOML), by file or name; two hours of varied work by default, or that
        of the scenario
    scenario : scenario (TOML) of one's own machine, of which the run is then made, with its parameters
    seed : seed of the noise
    noise : `white`, or `real`: correlated, rounded and with spikes
    solver : what computes the run: `grid` (a rod) or `fea` (3-D finite elements)
    axis : axis of the six-axis arm, from 1, in which the effects are hidden; the whole arm is then recorded
    terms : heat by equations, as `"shaft: a * max(speed - b, 0)**1.5; a = 0.3; b = 0.5 rad/s"`: the place
        (`shaft`, `winding`, `base` or `tip`), the heat in W, and the values of its parameters

    Returns
    -------
    pandas.DataFrame
        a row for each sample, with columns as `tip_temperature [degC]`; NaN where a cell is empty

    Raises
    ------
    InputError
        If there is no such effect, or something else of a name, it cannot be hidden in the machine, or
        a term is no equation for heat.

    Examples
    --------
    >>> measured = wl.hide({"joint_resistance": 0.3}, seed=1)
    >>> wl.diagnose(measured)
    """
    import pandas

    strengths = strengths_of(effects, scenario)
    hidden = [hidden_term(each) for each in several(terms)]
    if seed < 0:
        raise InputError(f"{argument('seed', seed)}: is negative; give 0 or above")
    if solver not in SOLVERS:
        raise InputError(f"{argument('solver', solver)}: no such solver; {instead(solver, SOLVERS)}")
    if noise not in NOISES:
        raise InputError(f"{argument('noise', noise)}: no such noise; {instead(noise, NOISES)}")
    others = {"solver": "" if solver == "grid" else solver, "duty": duty or "", "scenario": scenario or ""}
    others["terms"] = next(iter(several(terms)), "")
    if axis is not None:
        arm = f"{argument('axis', axis)}: the arm is computed by its FMUs, in a program of its own"
        _refuse(arm, others)
        with spinner("Making up a run of the arm"):
            columns = _in_arm(strengths, axis, seed, noise)
    elif scenario is not None:
        _refuse(
            f"{argument('scenario', scenario)}: a machine is computed by its FMUs", others, "solver", "terms"
        )
        with spinner("Making up a run"):
            columns = _in_machine(strengths, scenario, duty, seed, noise)
    else:
        with spinner("Making up a run") as progress:
            columns = _in_cell(strengths, duty, seed, noise, solver, progress, hidden)
    return pandas.DataFrame(columns)


def _refuse(why: str, given: Mapping[str, str], *names: str) -> None:
    """Raise InputError for the first of some arguments that is given, by default of all."""
    for name in names or given:
        if given[name]:
            raise InputError(f"{why}; leave {argument(name, given[name])} out")


def _in_cell(
    strengths: Mapping[str, float],
    duty: str | None,
    seed: int,
    noise: str,
    solver: str,
    progress: Progress,
    hidden: Sequence[HiddenTerm],
) -> dict[str, Array]:
    segments = hide.INFORMATIVE if duty is None else hide.duty_of(duty)
    if duty is not None:
        told = f"{duty}: the made-up run is of the nominal cell"
        asked = load_scenario(duty)
        if rig_of(of_scenario(duty)[0]).system is not None:
            own = f"give {argument('scenario', duty)} for one of it"
            remark(f"{told}, not of {asked.machine.name}; {own}")
        elif left_out := list(asked.parameters):
            remark(f"{told}; {listed(left_out)} of the scenario are left out")
    module, _, name = SOLVERS[solver].partition(":")
    made: dict[str, Array] = getattr(
        import_module(f"warmlink.orchestration.diagnosis.practice.{module}"), name
    )(strengths, segments, noise=NOISES[noise], seed=seed, progress=progress, terms=hidden)
    return made


def _in_arm(strengths: Mapping[str, float], axis: int, seed: int, noise: str) -> dict[str, Array]:
    from warmlink.orchestration.arm.program import arm
    from warmlink.orchestration.catalogue import controller
    from warmlink.orchestration.diagnosis.arm.hide import hide_in_arm
    from warmlink.orchestration.fmu_store import store

    fmus = store(None, sorted({*arm().kinds, controller("none").name}), remark)
    return hide_in_arm(strengths, axis, fmus, noise=NOISES[noise], seed=seed)


def _in_machine(
    strengths: Mapping[str, float], scenario: str, duty: str | None, seed: int, noise: str
) -> dict[str, Array]:
    from warmlink.orchestration.diagnosis.practice.by_fmus import hide_in_machine
    from warmlink.orchestration.fmu_store import store

    asked, machine = load_scenario(scenario), rig_of(of_scenario(scenario)[0])
    if duty is not None:
        asked = driven(asked, load_scenario(duty))
    fmus = store(None, sorted(asked.kinds), remark)
    return hide_in_machine(strengths, asked, machine, fmus, noise=NOISES[noise], seed=seed)


def strengths_of(
    effects: Mapping[str, float | None] | Iterable[str], scenario: str | None = None
) -> dict[str, float]:
    """Strengths in SI units by name, the usual one of an effect for which none is given; each is checked.

    InputError is raised if there is no such effect, in the machine of a scenario if one is given.
    """
    asked: Mapping[str, float | None] = (
        effects if isinstance(effects, Mapping) else dict.fromkeys(several(effects))
    )
    known = _usual_in_cell if scenario is None else _usual_in(scenario)
    found: dict[str, float] = {}
    for name, given in asked.items():
        usual, factor = known(name)
        size = usual if given is None else given
        if size is None:
            raise InputError(f"{name}: has no usual strength; write {name}=VALUE in SI units")
        if not math.isfinite(size):
            raise InputError(f"{name}={size:g}: is not finite; give the strength in SI units")
        if factor and size <= 0:
            raise InputError(
                f"{name}={size:g}: the strength is a factor; give one above 0, where 1 hides nothing"
            )
        found[name] = size
    return found


Usual = tuple[float | None, bool]
"""Usual strength of an effect, and whether it is a factor on the nominal value."""


def _usual_in_cell(name: str) -> Usual:
    effect = effect_of(name)
    return effect.size, bool(effect.on_truth and effect.neutral)


def _usual_in(scenario: str) -> Callable[[str], Usual]:
    from warmlink.orchestration.diagnosis.practice.by_fmus import effect_in

    machine = rig_of(of_scenario(scenario)[0])

    def usual(name: str) -> Usual:
        effect = effect_in(machine, name)
        return effect.size, effect.relative

    return usual
