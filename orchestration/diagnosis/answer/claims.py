"""What a model says of duty cycles that were not measured, and how far that may be trusted."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from warmlink.fmus.errors import InputError
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.answer.growth import Growth, growth_of
from warmlink.orchestration.diagnosis.answer.separation import drives, problem_with, run_of
from warmlink.orchestration.diagnosis.data.experiment import Experiment
from warmlink.orchestration.diagnosis.data.measured import names_of
from warmlink.orchestration.diagnosis.fit.fitted import Carried, Wrong
from warmlink.orchestration.diagnosis.fit.neighbours import Neighbours
from warmlink.orchestration.diagnosis.fit.verdict import Assessment
from warmlink.orchestration.diagnosis.ladder.prediction import Predicted
from warmlink.orchestration.scenarios.duties import duty_files
from warmlink.orchestration.scenarios.scenario import DEFAULT_TOLERANCE

DUTIES = ("continuous", "heavy_payload", "light_payload", "emergency_stop", "shift_with_breaks")
"""Shipped duty cycles that are foreseen: fast, heavy, light, held at rest, and with pauses."""

_SPACING = 60.0
"""s between the points at which a duty cycle is foreseen."""

_SIGMAS = 1.96
"""Standard deviations on either side of a 95 % band."""


@dataclass(frozen=True)
class Claim:
    """Elongation that is foreseen for a duty cycle, in m at times in s, shape (times,).

    By the model to use and, `before`, by the uncorrected one; `band` is half the width of the 95 % band
    about the former.
    """

    duty: str
    time: Array
    elongation: Array
    before: Array
    band: Array

    @property
    def largest(self) -> float:
        """Largest elongation in m."""
        return float(np.abs(self.elongation).max())

    @property
    def change(self) -> float:
        """Largest difference from the uncorrected model in m."""
        return float(np.abs(self.elongation - self.before).max())

    @property
    def widest(self) -> float:
        """Largest half width of the band in m."""
        return float(self.band.max())

    @property
    def holds(self) -> bool:
        """Whether the band is within the tolerance that compensation is asked to meet."""
        return self.widest <= DEFAULT_TOLERANCE


def claims(
    experiment: Experiment, assessment: Assessment, models: Sequence[Predicted], left: Mapping[str, Wrong]
) -> tuple[Claim, ...]:
    """Foresee the standard duty cycles.

    The band adds up what is uncertain in the numbers, what wanders, the one further cause below the noise
    that would matter most, how far models that explain the data alike are apart, and the share of the
    elongation that the model left unexplained in the run. The first of the models is the one
    to use; the others cannot be told from it. A model may have a machine of its own, with terms. `left` are
    the errors of its readings by column name.

    Raises InputError if the growth that a controller should take out was not read, or no duty cycle drives
    the machine.
    """
    rig = experiment.rig
    grown_in = growth_of(assessment.problem)
    if not drives((), rig):
        raise InputError(
            f"{rig.name}: no duty cycle drives its speed or torque, so none can be foreseen; name the inputs "
            'as speed and torque under [roles], in a file that the experiment names: system = "machine.toml"'
        )
    variables = tuple(names_of(experiment.columns))
    duties = {name: duty_files.load(name).unrolled() for name in DUTIES}
    runs = [replace(run_of(duty, rig, variables, 1.0, _SPACING), name=name) for name, duty in duties.items()]
    problem, before_them = problem_with(experiment, runs)
    share = _unexplained(experiment, grown_in, left)
    # What is wrong with logs and instruments is wrong in no other duty cycle.
    carried = [
        Carried(
            problem if each.model.experiment is experiment else problem_with(each.model.experiment, runs)[0],
            each.fit,
            plant_only=True,
        )
        for each in models
    ]
    carried.append(Carried(problem, assessment.null, plant_only=True))
    chosen = carried[0]
    grown_in = growth_of(problem)
    with_terms = models[0].model.experiment is not experiment
    further = [] if with_terms else Neighbours(models[0].fit, assessment.search.items, ()).unnoticed()
    unnoticed = [off for item, off in further if item.cause.kind == "plant"]
    found = []
    for run, name in enumerate(DUTIES, start=before_them):
        grown, *alike, before = (grown_in(model.predict(run)[0]) for model in carried)
        # Of further causes that the data do not show, the one that matters most here.
        moved = [grown_in(chosen.by(run, list(off))) @ np.array(list(off.values())) for off in unnoticed]
        worst = np.max([np.zeros(grown.size), *(each**2 for each in moved)], axis=0)
        variance = chosen.variance(run, grown_in) + worst
        variance += (share * grown) ** 2
        variance += chosen.wandering(run, assessment.fitter.wander, grown_in)
        apart = [np.abs(grown - other) for other in alike]
        band = np.max([_SIGMAS * np.sqrt(variance), *apart], axis=0)
        found.append(Claim(name, problem.data[run].time, grown, before, band))
    return tuple(found)


def _unexplained(experiment: Experiment, growth: Growth, left: Mapping[str, Wrong]) -> float:
    """Share of the measured growth that a model leaves unexplained, by its errors by column name."""
    names = names_of(experiment.columns)
    errors = [left[names[variable]] for variable in growth.variables if names[variable] in left]
    beyond = sum(
        abs(weight) * np.sqrt(max(each.rmse**2 - each.noise**2, 0.0))
        for weight, each in zip(growth.weights, errors, strict=False)
    )
    read = [run.readings for run in experiment.runs if set(growth.variables) <= run.readings.keys()]
    measured = np.concatenate(
        [sum(w * each[v] for w, v in zip(growth.weights, growth.variables, strict=True)) for each in read]
    )
    return float(beyond / np.sqrt(np.nanmean(measured**2)))
