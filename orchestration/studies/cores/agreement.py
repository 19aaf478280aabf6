"""Whether runs of a joined system agree with those of its FMUs in the ordinary master."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping, Sequence

from warmlink.fmus.packaging.cache import kept
from warmlink.fmus.packaging.native.rollout import Rollout
from warmlink.orchestration.scenarios.scenario import Scenario
from warmlink.orchestration.studies.case import case_of
from warmlink.orchestration.studies.cores.joined import outcomes
from warmlink.orchestration.studies.cores.workers import attempt
from warmlink.orchestration.studies.fmu_set import FmuSet

Remark = Callable[[str], None]

COMPARED = ("max_abs_um", "p95_abs_um", "rms_um")
"""Figures in µm that a study may rank by."""


def agreeing(
    scenarios: Sequence[Scenario], fmus: FmuSet, rollouts: Mapping[str, Rollout], remark: Remark
) -> dict[str, Rollout]:
    """The joined systems whose figures are those of the FMUs within the coupling error.

    Each controller is tried in one scenario, each in another as far as there are any. What was found is
    kept for the next study with the same FMUs.
    """
    good: dict[str, Rollout] = {}
    worst = (0.0, 0.0)
    for number, (law, rollout) in enumerate(rollouts.items()):
        mine = [each for each in scenarios if each.controller.component.name == law]
        difference, coupling = _difference(mine[number % len(mine)], fmus, rollout)
        if difference <= coupling:
            good[law] = rollout
            worst = max(worst, (difference, coupling))
        else:
            remark(
                f"{law}: figures of the joined system differ by {difference:.2g} µm from those of the FMUs, "
                f"more than the coupling error of {coupling:.2g} µm; it runs on its FMUs"
            )
    if good:
        remark(
            f"joined systems: {len(good)} runs tried beside the FMUs; figures differ by at most "
            f"{worst[0]:.2g} µm, the coupling error is {worst[1]:.2g} µm (--exact runs the FMUs)"
        )
    return good


def _difference(scenario: Scenario, fmus: FmuSet, rollout: Rollout) -> tuple[float, float]:
    """Largest difference of a run's figures, and the coupling error of the FMUs, both in µm."""
    case = case_of(scenario, (scenario.controller.name, scenario.name, "tried"), with_budget=True)

    def found() -> bytes:
        exact, (joined,) = attempt(case, fmus), outcomes([case], rollout)
        if joined is None or exact.coupling_um is None:
            return b"[1e999, 0.0]"
        differences = [abs(getattr(exact, name) - getattr(joined, name)) for name in COMPARED]
        return json.dumps([max(differences), exact.coupling_um]).encode()

    made_from = (fmus.digest, hashlib.sha256(rollout.library).hexdigest(), case.digest)
    difference, coupling = json.loads(kept("agreements", made_from, found))
    return difference, coupling
