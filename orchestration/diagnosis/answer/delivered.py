"""What is delivered: the model that predicts the held-out rows best."""

from __future__ import annotations

from collections.abc import Mapping

from warmlink.orchestration.diagnosis.answer.prediction import Predicted
from warmlink.orchestration.diagnosis.fit.problem import Problem
from warmlink.orchestration.diagnosis.fit.verdict import Word
from warmlink.orchestration.diagnosis.ladder.baselines import baselines
from warmlink.orchestration.diagnosis.ladder.rungs import Ladder, Rung
from warmlink.orchestration.diagnosis.ladder.signals import signals_of

UNCORRECTED, CALIBRATED, CAUSES = "uncorrected", "calibrated", "with causes"
"""Names of rungs that are models: as it stands, usual or declared parameters fitted, causes added."""

NEAREST = "nearest causes"
"""The rung of causes that do not explain what is wrong."""

REMAINDER = "with remainder"
"""The rung of the best of these models with what was learnt of the rest."""


def ladder_of(problem: Problem, models: Mapping[str, Predicted]) -> Ladder:
    """Judge models and baselines on the held-out rows of a whole experiment.

    Parameters
    ----------
    problem : the whole experiment
    models : by the name of their rung, the uncorrected one first
    """
    runs = signals_of(problem)
    rungs = [
        Rung(name, "simulation", each.readings, len(each.fit.freed), is_model=True)
        for name, each in models.items()
    ]
    unit = problem.experiment.rig.unit
    plain = baselines(runs, [unit(variable) == "K" for variable in problem.variables])
    rungs += [Rung(each.name, each.question, each.readings) for each in plain]
    wanted = problem.experiment.accuracy
    matters = {i: wanted[name] for i, name in enumerate(problem.variables) if name in wanted}
    return Ladder(runs, tuple(problem.names.values()), tuple(rungs), matters)


def chosen(ladder: Ladder, verdict: Word, declared: bool) -> str:
    """Choose among the models of a ladder by its held-out rows; returns the name of the rung.

    Of models that predict alike within one standard error it is the simpler one. What the fitted rows
    establish, or the user asked for, comes first among these.

    Parameters
    ----------
    ladder : models and baselines
    verdict : on the causes
    declared : whether the user named what to calibrate
    """
    models = {rung.name: rung for rung in ladder.rungs if rung.is_model}
    established = [CAUSES] if verdict in ("named", "ambiguous") else []
    asked = [CALIBRATED] if declared else []
    order = [*established, *asked, UNCORRECTED, CAUSES, CALIBRATED, NEAREST, REMAINDER]
    rungs = [models[name] for name in dict.fromkeys(order) if name in models]
    if ladder.is_judged:
        return ladder.simplest_of_the_best(rungs).name
    wanted = CAUSES if verdict not in ("adequate", "unknown") else CALIBRATED if declared else UNCORRECTED
    return wanted if wanted in models else rungs[0].name
