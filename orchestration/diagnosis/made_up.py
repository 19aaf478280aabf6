"""Measured runs that are made up, with effects by name and how the run is made."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from importlib import import_module
from typing import TYPE_CHECKING

from warmlink.fmus.arguments import argument
from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead, listed, several
from warmlink.orchestration.closed_loop.load import load_scenario
from warmlink.orchestration.console import remark
from warmlink.orchestration.diagnosis.practice import hide
from warmlink.orchestration.diagnosis.practice.effects import effect_of
from warmlink.orchestration.diagnosis.practice.hidden_terms import HiddenTerm, hidden_term
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
    seed: int = 0,
    noise: str = "white",
    solver: str = "grid",
    axis: int | None = None,
    terms: str | Iterable[str] = (),
) -> pandas.DataFrame:
    """Make up a measured run that contains hidden effects, to practise `diagnose` on.

    The run is computed by another solver than the one that `diagnose` uses.

    Parameters
    ----------
    effects : names of effects, as `radiation` or `sensor_lag:tip_temperature`, or their strengths in SI units
        by name
    duty : duty cycle (CSV) or scenario (TOML), by file or name; two hours of varied work by default
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
        If there is no such effect, or something else of a name, or a term is no equation for heat.

    Examples
    --------
    >>> measured = wl.hide({"joint_resistance": 0.3}, seed=1)
    >>> wl.diagnose(measured)
    """
    import pandas

    strengths, hidden = _strengths(effects), [hidden_term(each) for each in several(terms)]
    if seed < 0:
        raise InputError(f"{argument('seed', seed)}: is negative; give 0 or above")
    if solver not in SOLVERS:
        raise InputError(f"{argument('solver', solver)}: no such solver; {instead(solver, SOLVERS)}")
    if noise not in NOISES:
        raise InputError(f"{argument('noise', noise)}: no such noise; {instead(noise, NOISES)}")
    if axis is None:
        with spinner("Making up a run") as progress:
            columns = _in_cell(strengths, duty, seed, noise, solver, progress, hidden)
    else:
        other = (
            ("solver", None if solver == "grid" else solver),
            ("duty", duty),
            ("terms", next(iter(several(terms)), None)),
        )
        for name, given in other:
            if given is not None:
                arm = "the arm is computed by its FMUs, in a program of its own"
                raise InputError(f"{argument('axis', axis)}: {arm}; leave {argument(name, given)} out")
        with spinner("Making up a run of the arm"):
            columns = _in_arm(strengths, axis, seed, noise)
    return pandas.DataFrame(columns)


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
    if duty is not None and (left_out := list(load_scenario(duty).parameters)):
        remark(
            f"{duty}: the made-up run is of the nominal cell; {listed(left_out)} of the scenario are left out"
        )
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


def _strengths(effects: Mapping[str, float] | Iterable[str]) -> dict[str, float]:
    """Strengths in SI units by name, the usual one of an effect for which none is given; each is checked."""
    given = (
        dict(effects)
        if isinstance(effects, Mapping)
        else {name: effect_of(name).size for name in several(effects)}
    )
    for name, size in given.items():
        effect = effect_of(name)
        if not math.isfinite(size):
            raise InputError(f"{name}={size:g}: is not finite; give the strength in SI units")
        if effect.on_truth and effect.neutral and size <= 0:
            raise InputError(
                f"{name}={size:g}: the strength is a factor; give one above 0, where 1 hides nothing"
            )
    return given
