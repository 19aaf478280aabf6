"""When and where heat is missing: the course of heat into the shaft that would make up for what is wrong."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.fit.likeliest import Integrated
from warmlink.orchestration.diagnosis.fit.verdict import Assessment
from warmlink.orchestration.diagnosis.fit.wandering import Responses, Wander

_HEATS = tuple(0.1 * 2.0**k for k in range(10))
"""W, standard deviations of the course that are tried."""


@dataclass(frozen=True)
class MissingHeat:
    """Course of the missing heat over one run, the smoothest that the readings allow.

    Attributes
    ----------
    run : its name
    time : s, shape (nodes,)
    heat, deviation : W, with its standard deviation
    """

    run: str
    time: Array
    heat: Array
    deviation: Array

    @property
    def sentence(self) -> str:
        """Say when most heat is missing, or too much is made."""
        k = int(np.argmax(np.abs(self.heat)))
        way = "more" if self.heat[k] > 0 else "less"
        return (
            f"heat into the shaft would have to be {abs(self.heat[k]):.2g} W {way} at "
            f"{self.time[k] / 60:.0f} min of {self.run} (95 %: within {1.96 * self.deviation[k]:.2g} W)."
        )


def missing_heat(assessment: Assessment) -> tuple[MissingHeat, ...]:
    """The course by fitted run, in the model as it stands; none in a system without a motor."""
    problem, fit = assessment.problem, assessment.null
    responses = Responses(problem, problem.values_by_run(fit.freed, fit.theta))
    if "heat" not in responses.signals:
        return ()
    seen = Integrated(assessment.search, fit, responses)
    wander = min((Wander(heat=heat) for heat in _HEATS), key=seen.misfit_alone)
    found = []
    for run in problem.fitted_runs:
        mean, covariance = seen.smoothed(run, wander)
        nodes = responses.nodes[run]
        heat = slice(mean.size - nodes.size, None)
        deviation = np.sqrt(np.diag(covariance))[heat]
        found.append(MissingHeat(problem.experiment.runs[run].name, nodes, mean[heat], deviation))
    return tuple(found)
