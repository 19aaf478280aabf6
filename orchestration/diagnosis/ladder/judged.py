"""The models that causes, calibration, a learnt remainder and plain fits give, judged on held-out rows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from warmlink.orchestration.diagnosis.fit.problem import Problem
from warmlink.orchestration.diagnosis.fit.verdict import Word
from warmlink.orchestration.diagnosis.fit.wandering import Wander
from warmlink.orchestration.diagnosis.ladder.baselines import baselines
from warmlink.orchestration.diagnosis.ladder.prediction import MISSED, Predicted, Scores
from warmlink.orchestration.diagnosis.ladder.remainder import Remainder, leaves_out_runs, remainder
from warmlink.orchestration.diagnosis.ladder.rungs import Ladder, Rung
from warmlink.orchestration.diagnosis.ladder.signals import Signals, growth_output, signals_of

UNCORRECTED, CALIBRATED, CAUSES = "uncorrected", "calibrated", "with causes"
"""Names of rungs that are models: as it stands, usual or declared parameters fitted, causes added."""

NEAREST = "nearest causes"
"""The rung of causes that do not explain what is wrong."""

EQUATION = "with equation"
"""The rung of the model with an equation for the heat that it lacks, see `delivered.py`."""

REMAINDER = "with remainder"
"""The rung of the best of these models with what was learnt of the rest."""

PLAIN = "with plain fits"
"""The rung of the best of all these, with plain fits for the channels that they tell better."""


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
    rungs += [Rung(each.name, each.question, each.readings, linear=each.linear) for each in plain]
    return ladder_on(problem, runs, rungs)


def ladder_on(problem: Problem, runs: Sequence[Signals], rungs: Sequence[Rung]) -> Ladder:
    """Rungs judged on the rows of runs that are not fitted, by what matters in an experiment."""
    wanted = problem.experiment.accuracy
    matters = {i: wanted[name] for i, name in enumerate(problem.variables) if name in wanted}
    name = growth_output(problem)
    growth = problem.variables.index(name) if name else None
    return Ladder(tuple(runs), tuple(problem.names.values()), tuple(rungs), matters, growth)


def chosen(ladder: Ladder, verdict: Word, declared: bool, by_parts: Ladder | None = None) -> str:
    """Choose among the models of a ladder by its held-out rows; returns the name of the rung.

    Of models that predict alike within one standard error it is the simpler one. What the fitted rows
    establish, or the user asked for, comes first among these. None is chosen that foretells the growth worse
    than the uncorrected model. Of that and its plain calibration the one stays that predicts all parts of the
    log better, each by the others, whatever the end of the log says. Without held-out rows it is the one with
    the causes if there is a verdict of some, else the calibrated one if the user asked for it, else the
    uncorrected one.

    Parameters
    ----------
    ladder : models and baselines
    verdict : on the causes
    declared : whether the user named what to calibrate
    by_parts : these two models, as they predict all parts of the log
    """
    models = {rung.name: rung for rung in ladder.rungs if rung.is_model}
    established = [CAUSES] if verdict in ("named", "ambiguous") else []
    asked = [CALIBRATED] if declared else []
    order = [*established, *asked, UNCORRECTED, CAUSES, CALIBRATED, NEAREST, REMAINDER]
    rungs = [models[name] for name in dict.fromkeys(order) if name in models and _may_be_chosen(name, ladder)]
    if ladder.is_judged:
        stays = None if by_parts is None else _better_of(by_parts)
        gone = set() if stays is None else {UNCORRECTED, CALIBRATED} - {stays}
        rungs = [r for r in rungs if r.name == stays or not ladder.is_worse_in_growth(r)]
        rungs = [each for each in rungs if each.name not in gone]
        return ladder.simplest_of_the_best(rungs).name
    wanted = CAUSES if verdict not in ("adequate", "unknown") else CALIBRATED if declared else UNCORRECTED
    return wanted if wanted in models else rungs[0].name


def _better_of(two: Ladder) -> str:
    """Name of the better of the uncorrected model and its plain calibration; alike, the uncorrected one."""
    first, other = two.rungs
    if two.is_worse_in_growth(other):
        return first.name
    return two.simplest_of_the_best((first, other)).name


def _may_be_chosen(name: str, ladder: Ladder) -> bool:
    """Whether held-out rows can speak for a model: causes that do not explain a run may fit its end."""
    return name != NEAREST or ladder.judges_whole_runs


@dataclass(frozen=True)
class JudgedModels:
    """Models to choose from, whatever equations may be beside them.

    Attributes
    ----------
    scores : errors on the whole experiment
    wander : what wanders beside the log
    models : by the name of their rung, the uncorrected one first
    verdict : on the causes, after the gate
    declared : whether the user named what to calibrate
    by_parts : the uncorrected model and its plain calibration, as they predict all parts of the log; None if
        there is no such calibration, or a person holds out whole runs
    """

    scores: Scores
    wander: Wander
    models: Mapping[str, Predicted]
    verdict: Word
    declared: bool
    by_parts: Ladder | None = None

    @cached_property
    def _plainest(self) -> Ladder:
        return ladder_of(self.scores.problem, self.models)

    @cached_property
    def base(self) -> str:
        """Name of the rung of the best model, remainders aside."""
        return chosen(self._plainest, self.verdict, self.declared, self.by_parts)

    @cached_property
    def _is_off(self) -> bool:
        """Whether rows are held out, and the best model is beyond the noise there."""
        left = self.scores.held_out(self.models[self.base], self.wander)
        return self._plainest.is_judged and left is not None and left.in_noise > MISSED

    @cached_property
    def _learnt(self) -> tuple[str, Remainder] | None:
        """The model that is best with its remainder, and that remainder.

        A remainder corrects the channels alone that held-out rows tell clearly better with it. None if none
        is such, or nothing is held out, or the best model is within the noise there, or other duty cycles
        cannot speak: whole runs are held out for that, or each of several fitted ones in turn.
        """
        if not (self._is_off and (self._plainest.judges_whole_runs or leaves_out_runs(self.scores.problem))):
            return None
        ladder, found = self._plainest, []
        for name, model in self.models.items():
            if not _may_be_chosen(name, ladder):
                continue
            whole = remainder(self.scores.problem, model.readings)
            kept = [] if whole is None else self._better_with(whole, ladder.named(name))
            if whole is not None and kept:
                part = whole.only(kept, self.scores.problem, model.readings)
                found.append((ladder.score(_with(part)), name, part))
        return min(found, key=lambda each: each[0])[1:] if found else None

    def _better_with(self, learnt: Remainder, model: Rung) -> list[str]:
        """Variables that held-out rows tell clearly better with a remainder than by its model alone."""
        ladder, rung = self._plainest, _with(learnt)
        variables = enumerate(self.scores.problem.variables)
        return [name for i, name in variables if ladder.best_in(i, [rung], model) is not None]

    @cached_property
    def _modelled(self) -> Ladder:
        """The ladder of all models, the learnt remainder included."""
        plain = self._plainest
        if self._learnt is None:
            return plain
        return plain.with_model(_with(self._learnt[1]))

    @cached_property
    def best_model(self) -> str:
        """Name of the rung of the best model, with a remainder or without one."""
        return chosen(self._modelled, self.verdict, self.declared, self.by_parts)

    @cached_property
    def plain(self) -> Mapping[int, Rung]:
        """Plain fits that are delivered, by number of the channel that they tell better than the best model.

        As causes that do not explain a run, they may fit its end: whole runs have to speak for them.
        """
        ladder = self._modelled
        if not self._is_off or not ladder.judges_whole_runs:
            return {}
        model = ladder.named(self.best_model)
        found = {}
        for channel in range(len(ladder.channels)):
            tried = [each for each in ladder.plain("simulation") if is_usable(each, channel)]
            best = ladder.best_in(channel, tried, model)
            if best is not None:
                found[channel] = best
        return found

    @cached_property
    def ladder(self) -> Ladder:
        """The ladder of all these models, plain fits in the place of the best model's channels included."""
        ladder = self._modelled
        if not self.plain:
            return ladder
        tables = [table.copy() for table in ladder.named(self.best_model).readings]
        for channel, rung in self.plain.items():
            for table, said in zip(tables, rung.readings, strict=True):
                table[:, channel] = said[:, channel]
        return ladder.with_model(Rung(PLAIN, "simulation", tuple(tables), is_model=True))

    @property
    def name(self) -> str:
        """Name of the rung of the best of all these."""
        return PLAIN if self.plain else self.best_model

    @property
    def remainder(self) -> Remainder | None:
        """The learnt remainder of the best model, if it has one."""
        return self._learnt[1] if self.best_model == REMAINDER and self._learnt else None

    @property
    def model(self) -> str:
        """Name of the rung of the best model, what stands beside it aside."""
        return self._learnt[0] if self.best_model == REMAINDER and self._learnt else self.best_model

    @cached_property
    def adopted(self) -> Predicted:
        """The best model, with what stands beside it."""
        return replace(self.models[self.model], readings=self.ladder.named(self.name).readings)


def _with(learnt: Remainder) -> Rung:
    """The rung of a model with its remainder."""
    return Rung(REMAINDER, "simulation", learnt.readings, is_model=True)


def is_usable(rung: Rung, channel: int) -> bool:
    """Whether a plain fit of a channel can be handed on: it goes by signals alone."""
    return channel in rung.linear and rung.linear[channel].is_complete
