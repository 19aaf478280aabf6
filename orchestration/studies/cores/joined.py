"""Runs of a study side by side: the whole system is one component, which goes through a run in one call."""

from __future__ import annotations

import pickle
from collections.abc import Callable, Mapping, Sequence

from warmlink.fmus.errors import InputError
from warmlink.fmus.packaging.cache import kept, source_digest
from warmlink.fmus.packaging.native.lanes import processor
from warmlink.fmus.packaging.native.library import loaded
from warmlink.fmus.packaging.native.rollout import Rollout
from warmlink.fmus.packaging.native.rollout_code import compiled
from warmlink.orchestration.closed_loop.outcome import coupling_um
from warmlink.orchestration.master.algorithms.table import algorithm
from warmlink.orchestration.master.communication import CommunicationPoints
from warmlink.orchestration.master.recording.result import Result, Table
from warmlink.orchestration.scenarios.scenario import DEFAULT_MASTER, Scenario
from warmlink.orchestration.studies.case import Case, Outcome, figures, recorded

Remark = Callable[[str], None]

MOST_POINTS = 200_000
"""Communication points of a run; those of all lanes are in memory at once."""


def joined_systems(scenarios: Sequence[Scenario], remark: Remark) -> dict[str, Rollout]:
    """The systems of a study's scenarios, joined and compiled, by the component behind the controllers.

    Those that hold foreign FMUs, or are run with another master than the usual one, are left out; so are
    those that cannot be compiled, with a remark.
    """
    by_law: dict[str, list[Scenario]] = {}
    for scenario in scenarios:
        by_law.setdefault(scenario.controller.component.name, []).append(scenario)
    found: dict[str, Rollout] = {}
    for law, mine in by_law.items():
        first = mine[0]
        usual = all(each.master == DEFAULT_MASTER and not each.setup.foreign for each in mine)
        if not usual or any(each.made_from != first.made_from for each in mine):
            continue
        try:
            found[law] = _kept(first)
        except (InputError, OSError) as fault:
            remark(f"{law}: runs on its FMUs, since its system cannot be joined: {fault}")
    return found


def _kept(scenario: Scenario) -> Rollout:
    names = recorded(scenario.setup)
    made_from = (source_digest(), *scenario.made_from, names, processor())
    content = kept("rollouts", made_from, lambda: pickle.dumps(compiled(scenario.joined({}), names)))
    rollout = pickle.loads(content)
    assert isinstance(rollout, Rollout)
    loaded(rollout.library)
    return rollout


def lane_of(case: Case, rollouts: Mapping[str, Rollout]) -> tuple[object, ...] | None:
    """What the runs that go side by side with this one have in common; None for one that runs on FMUs."""
    rollout = rollouts.get(case.law)
    if rollout is None or not rollout.runs_here or case.stop_time / case.step_size > MOST_POINTS:
        return None
    periods = rollout.periods(_flat(case))
    return case.law, case.stop_time, case.step_size, case.with_budget, periods


def outcomes(cases: Sequence[Case], rollout: Rollout) -> list[Outcome | None]:
    """Run cases side by side; None for one in which an FMU would have refused what another gave it."""
    first = cases[0]
    coarse = _results(cases, rollout, first.step_size)
    fine = _results(cases, rollout, first.step_size / 2) if first.with_budget else [None] * len(cases)
    order = algorithm(first.master).order
    found: list[Outcome | None] = []
    for case, result, finer in zip(cases, coarse, fine, strict=True):
        if result is None:
            found.append(None)
            continue
        coupling = None if finer is None else coupling_um(result, finer, order, case.setup)
        found.append(figures(case.setup, result, case.tolerance, coupling))
    return found


def _results(cases: Sequence[Case], rollout: Rollout, step: float) -> list[Result | None]:
    points = CommunicationPoints.between(0.0, cases[0].stop_time, step)
    values, well = rollout.run([_flat(case) for case in cases], points.count, step)
    units = dict.fromkeys(rollout.recorded)
    return [
        Result(Table(rollout.recorded, units, points, mine.T), "completed") if good else None
        for mine, good in zip(values, well, strict=True)
    ]


def _flat(case: Case) -> dict[str, float]:
    return {f"{key}.{name}": float(value) for key, of in case.values.items() for name, value in of.items()}
