"""Plain fits as a component: what is delivered where they predict best."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from warmlink.fmus.component import Component
from warmlink.fmus.linear_predictor.component import linear_predictor
from warmlink.fmus.linear_predictor.equations import Forms, LinearForm, features_of
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.fit.problem import Problem
from warmlink.orchestration.diagnosis.ladder.least_squares import Linear
from warmlink.orchestration.diagnosis.ladder.signals import Feature, Signals


@dataclass(frozen=True, eq=False)
class Predictor:
    """Plain fits as a component that is fed and read by names of the experiment.

    Attributes
    ----------
    component : its declaration
    inputs : variable of the system by the component's input
    outputs : the component's output by the variable that it tells
    """

    component: Component
    inputs: Mapping[str, str]
    outputs: Mapping[str, str]


def predictor_of(
    problem: Problem,
    runs: Sequence[Signals],
    fits: Mapping[int, tuple[Linear, float]],
    name: str,
    description: str,
) -> Predictor:
    """Make a component of plain fits.

    Parameters
    ----------
    problem : the whole experiment
    runs : its runs, as the fits know them
    fits : a complete fit by number of the channel, and its error in SI on held-out rows
    name, description : of the component
    """
    features = list(dict.fromkeys(f for fit, _ in fits.values() for f in fit.features))
    signals = list(dict.fromkeys(signal for feature in features for signal in feature))
    told = [runs[0].channels[channel] for channel in fits]
    called = _identifiers(problem, [*signals, *told])
    inputs = [(each,) for each in signals]
    products = [each for each in features if len(each) == 2]
    order = features_of([each for (each,) in inputs], [(one, other) for one, other in products])
    ranges = np.array([_range(runs, each) for each in order])
    first = next(run for run in runs if run.fitted.any())
    model = Forms(
        {
            called[runs[0].channels[channel]]: _form(fit, error, first, order)
            for channel, (fit, error) in fits.items()
        },
        tuple(called[each] for each in signals),
        tuple((called[one], called[other]) for one, other in products),
        *ranges.T,
    )
    rig = problem.experiment.rig
    units = {called[each]: rig.unit(each) if each in rig.variables else "K" for each in (*signals, *told)}
    component = linear_predictor(name, description, model, units)
    return Predictor(component, {called[s]: s for s in signals}, {each: called[each] for each in told})


def _identifiers(problem: Problem, signals: Iterable[str]) -> dict[str, str]:
    """Names for variables of a component by the system's variables: those of the columns if they have one."""
    columns = {column.variable: column.name for column in problem.experiment.columns}
    found: dict[str, str] = {}
    for signal in dict.fromkeys(signals):
        name = columns.get(signal, problem.experiment.rig.column_of(signal))
        plain = re.sub(r"\W+", "_", name, flags=re.ASCII).strip("_") or "signal"
        plain = plain if plain[0].isalpha() else f"signal_{plain}"
        while plain in (*found.values(), "outside", "time", "held"):
            plain += "_"
        found[signal] = plain
    return found


def _form(fit: Linear, error: float, run: Signals, order: Sequence[Feature]) -> LinearForm:
    """A fit with its weights in the order of a component's features, which starts as a run does."""
    channels = list(fit.channels)
    none = np.zeros(len(channels))
    return LinearForm(
        fit.step,
        fit.ahead,
        np.array([fit.driven.get(each, none) for each in order]).T.reshape(len(channels), len(order)),
        fit.constant,
        run.start[channels] - np.where(fit.above, run.ambient[0], 0.0),
        np.array([float(k == fit.place) for k in range(len(channels))]),
        np.array([fit.direct.get(each, 0.0) for each in order]),
        fit.offset,
        error,
    )


def _range(runs: Sequence[Signals], feature: Feature) -> tuple[float, float]:
    """Least and largest value of a feature on fitted rows."""
    found = np.concatenate([_course(run, feature)[run.fitted] for run in runs])
    return (float(np.nanmin(found)), float(np.nanmax(found))) if np.isfinite(found).any() else (0.0, 0.0)


def _course(run: Signals, feature: Feature) -> Array:
    (name, *other) = feature
    if other:
        return np.asarray(run.products[:, run.pairs.index(feature)] if feature in run.pairs else _none(run))
    if name in run.names:
        return np.asarray(run.inputs[:, run.names.index(name)])
    if name in run.channels:
        return np.asarray(run.readings[:, run.channels.index(name)])
    return run.ambient


def _none(run: Signals) -> Array:
    return np.full(run.time.size, np.nan)
