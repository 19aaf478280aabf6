"""Joined systems in place of a study's FMUs: compiled, and tried beside the FMUs before they run cases."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import cycle
from pathlib import Path

import numpy as np

from warmlink.fmus.arguments import argument
from warmlink.fmus.errors import InputError
from warmlink.fmus.packaging.cache import remembered
from warmlink.fmus.packaging.native.library import loaded, made_here, processor
from warmlink.fmus.packaging.native.rollout import Rollout
from warmlink.fmus.packaging.native.rollout_code import compiled
from warmlink.orchestration.master.algorithms import DEFAULT_MASTER
from warmlink.orchestration.progress import Progress, unseen
from warmlink.orchestration.scenarios.duties.duty import IDLE
from warmlink.orchestration.scenarios.scenario import Scenario
from warmlink.orchestration.studies.case import BOUNDED, Case, case_of, recorded
from warmlink.orchestration.studies.workers import FmuSet, Remark, attempt, joined_outcomes, joined_results


def joined_systems(
    runs: Sequence[Scenario], remark: Remark, progress: Progress = unseen
) -> dict[str, Rollout]:
    """The systems of a study's runs, joined and compiled, by the component behind the controllers.

    Those that hold foreign FMUs, or are run with another master than the usual one, are left out; so are
    those that cannot be compiled, with a remark.
    """
    found: dict[str, Rollout] = {}
    # Whatever drives them is no part of what is compiled: tables stand in place of the segments.
    laws = _by_law([replace(each, duty=IDLE) if each.duty.tables else each for each in runs])
    for done, (law, mine) in enumerate(laws.items()):
        progress(f"compiling system {done + 1} of {len(laws)}, with {law}", done / len(laws))
        first = mine[0]
        usual = DEFAULT_MASTER, dict[str, Path](), first.made_from
        if any((each.master, each.machine.foreign, each.made_from) != usual for each in mine):
            continue
        names = tuple(dict.fromkeys(name for each in mine for name in recorded(each.machine)))
        made_from = (*made_here(), *first.made_from, names, processor())
        try:
            rollout = remembered("rollouts", made_from, lambda: compiled(first.joined({}), names))  # noqa: B023
            loaded(rollout.library)
            found[law] = rollout
        except (InputError, OSError) as fault:
            remark(f"{law}: runs on its FMUs, since its system cannot be joined: {fault}")
    return found


def _by_law(runs: Sequence[Scenario]) -> dict[str, list[Scenario]]:
    """Runs by the component behind their controllers."""
    found: dict[str, list[Scenario]] = {}
    for each in runs:
        found.setdefault(each.controller.component.name, []).append(each)
    return found


def agreeing(runs: Sequence[Scenario], fmus: FmuSet, remark: Remark, progress: Progress = unseen) -> FmuSet:
    """The FMUs with those of their joined systems whose figures are theirs within the coupling error."""
    found = differences_from_fmus(runs, fmus, remark, progress)
    good = {law: each for law, each in found.items() if each[0] <= each[1]}
    for law, (difference, coupling) in found.items():
        if law not in good:
            told = f"{law}: figures of the joined system differ by {difference:.2g} µm from those of the FMUs"
            remark(f"{told}, more than the coupling error of {coupling:.2g} µm; it runs on its FMUs")
    if good:
        difference, coupling = np.max(list(good.values()), axis=0)
        told = f"joined systems: {len(good)} run{'s' if len(good) > 1 else ''} tried beside the FMUs"
        told += f"; figures differ by at most {difference:.2g} µm"
        remark(f"{told}, the coupling error is up to {coupling:.2g} µm ({argument('exact')} runs the FMUs)")
    return replace(fmus, rollouts={law: fmus.rollouts[law] for law in good})


def differences_from_fmus(
    runs: Sequence[Scenario], fmus: FmuSet, remark: Remark, progress: Progress = unseen
) -> dict[str, tuple[float, float]]:
    """Difference of the figures of joined systems from those of FMUs, and the coupling error, both in µm.

    FMUs hand on what changes up to a step late, so that a run in which the growth turns most sharply has the
    largest coupling error. Each controller is tried in such a run, each in another as far as there are any.
    What was found is kept for the next study with the same FMUs; where nothing was, a remark says why.
    """
    by_law = _by_law([each for each in runs if each.controller.component.name in fmus.rollouts])
    planned = {
        law: [case_of(each, (each.controller.name, each.name)) for each in of] for law, of in by_law.items()
    }
    cases, turns = next(iter(planned.values()), []), dict[int, float]()
    progress("looking for the runs to try beside the FMUs", 0.0)
    for place, result in joined_results(cases, fmus.rollouts):
        growth = cases[place].machine.roles.uncompensated.value(result.__getitem__)
        turns[place] = -float(np.max(np.abs(np.diff(growth, 2)), initial=0.0))
    sharpest_first = sorted(range(len(cases)), key=lambda place: turns.get(place, 0.0))
    found = dict[str, tuple[float, float]]()
    for done, ((law, mine), at) in enumerate(zip(planned.items(), cycle(sharpest_first), strict=False)):
        progress(f"trying {law} beside its FMUs", done / len(planned))
        try:
            found[law] = _difference(mine[at], fmus)
        except _UntriedError as why:
            remark(f"{law}: runs on its FMUs, since {why}")
    return found


class _UntriedError(Exception):
    """A run did not end both ways; it says which way, and is no answer to be kept."""


def _difference(planned: Case, fmus: FmuSet) -> tuple[float, float]:
    """Largest difference of a run's figures, and the coupling error of the FMUs, both in µm."""
    case = replace(planned, with_budget=True)

    def found() -> tuple[float, float]:
        exact, joined = attempt(case, fmus), joined_outcomes([case], fmus.rollouts).get(0)
        if exact.coupling_um is None:
            why = exact.stopped or "at half its step"
            raise _UntriedError(f"the run that was tried of it stopped: {why}")
        if joined is None:
            raise _UntriedError("its joined system does not take the run that was tried")
        most = float(np.max([abs(getattr(exact, name) - getattr(joined, name)) for name in BOUNDED]))
        if not math.isfinite(most):
            raise _UntriedError("the score of the run that was tried of it is no number")
        return most, exact.coupling_um

    return remembered("agreements", (fmus.digest_for(case), case.digest), found)
