"""`warmlink hide`: runs to practise `diagnose` on."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from warmlink.fmus.errors import InputError
from warmlink.orchestration.console import answer, remark

if TYPE_CHECKING:
    from warmlink.orchestration.arrays import Array
    from warmlink.orchestration.diagnosis.practice.hide import Noise

GRID, FEA = "grid", "fea"
"""Solvers that compute a made-up run: a rod on a grid, or 3-D finite elements."""


def hide(
    effects: list[str] | None = None,
    *,
    duty: str | None = None,
    out: Path = Path("run.csv"),
    seed: int = 0,
    noise: str = "white",
    with_: str = "grid",
    axis: int | None = None,
) -> None:
    """Make up a measured run that contains hidden effects, to practise `warmlink diagnose` on.

    The run is computed by another solver than the one that `diagnose` uses.

    Parameters
    ----------
    effects : Effects to hide (`warmlink list`), for example radiation, joint_resistance=0.3 (a strength in SI
        units) or sensor_lag:tip_temperature.
    duty : Duty cycle (CSV) or scenario (TOML), as for `warmlink run`. Default: two hours of varied work.
    out : CSV file to write.
    seed : Seed of the noise.
    noise : `white` noise, or `real`: correlated, rounded and with spikes.
    with_ : Solver that computes the run: `grid` (a rod) or `fea` (3-D finite elements).
    axis : Hide the effects in this axis of the six-axis arm, and record the whole arm.
    """
    from warmlink.fmus.names import instead, listed
    from warmlink.orchestration.closed_loop.load import load_scenario
    from warmlink.orchestration.diagnosis.practice import hide as made_up
    from warmlink.orchestration.diagnosis.practice.effects import EFFECTS
    from warmlink.orchestration.scenarios.duties.duty import length

    if seed < 0:
        raise InputError(f"--seed {seed}: is negative; give 0 or above")
    kinds = {"white": made_up.WHITE, "real": made_up.REAL}
    if with_ not in (GRID, FEA):
        raise InputError(f"--with {with_}: no such solver; {instead(with_, (GRID, FEA))}")
    if noise not in kinds:
        raise InputError(f"--noise {noise}: no such noise; {instead(noise, kinds)}")
    if out.suffix != ".csv":
        raise InputError(f"--out {out}: not a CSV file; give a name that ends in .csv")
    strengths = dict(map(_strength, effects or ()))
    hidden = ", ".join(f"{name} = {size:g}" for name, size in strengths.items()) or "nothing"
    if axis is not None:
        if with_ != GRID:
            raise InputError(f"--axis {axis}: the arm is computed by its FMUs; leave --with {with_} out")
        if duty is not None:
            raise InputError(f"--axis {axis}: the arm follows a program of its own; leave --duty {duty} out")
        made_up.write_csv(_in_arm(strengths, axis, kinds[noise], seed), out)
        answer(f"{out}: the six-axis arm with {hidden} hidden in axis {axis} (SI units, seed {seed})")
        return
    segments = made_up.INFORMATIVE if duty is None else made_up.duty_of(duty)
    if duty is not None and (left_out := list(load_scenario(duty).parameters)):
        told = f"{listed(left_out)} of the scenario are left out"
        remark(f"{duty}: the made-up run is of the nominal cell; {told}")
    make: Callable[..., dict[str, Array]] = made_up.hide
    if with_ == FEA:
        from warmlink.orchestration.diagnosis.practice.hidden_fea import hide_with_fea as make
    made_up.write_csv(make(strengths, segments, noise=kinds[noise], seed=seed), out)
    hours = length(segments) / 3600
    answer(
        f"{out}: {hours:.3g} h with {hidden} hidden (SI units, seed {seed}); of {len(EFFECTS)} effects known"
    )


def _in_arm(strengths: dict[str, float], axis: int, noise: Noise, seed: int) -> dict[str, Array]:
    """Columns of a run of the whole arm, with the effects in one axis."""
    from warmlink.orchestration.arm.setup import arm
    from warmlink.orchestration.catalogue import controller
    from warmlink.orchestration.diagnosis.arm.hide import hide_in_arm
    from warmlink.orchestration.fmu_store import store

    fmus = store(None, sorted({*arm().blueprint.kinds, controller("none").name}), remark)
    return hide_in_arm(strengths, axis, fmus, noise=noise, seed=seed)


def _strength(given: str) -> tuple[str, float]:
    """Name of an effect, and its strength in SI units; the usual strength if none is given."""
    from warmlink.orchestration.diagnosis.practice.effects import effect_of

    name, equals, size = given.partition("=")
    effect = effect_of(name)
    try:
        strength = float(size) if equals else effect.size
    except ValueError:
        strength = math.nan
    if not math.isfinite(strength):
        raise InputError(f"{given}: {size!r} is not a number; give the strength in SI units")
    if effect.on_truth and effect.neutral and strength <= 0:
        raise InputError(f"{given}: the strength is a factor; give one above 0, where 1 hides nothing")
    return name, strength
