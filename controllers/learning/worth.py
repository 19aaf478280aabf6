"""What a log says beside the law: the worth of thermometers, whether it is long enough, what is left."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from warmlink.controllers.design.training import TrainingRun
from warmlink.controllers.learning.learnt import LearntMap
from warmlink.controllers.learning.line import Learner
from warmlink.controllers.learning.logs import BLOCKS, Examples, Log

Array = NDArray[np.float64]

MINUTES = (10.0, 20.0, 30.0, 45.0, 60.0, 90.0, 120.0, 180.0, 240.0, 360.0, 480.0)
"""Lengths of log for which the error of a law learnt from them is reported."""

JUDGED = 1 / 3
"""Share of the logs, at their end, by which this is judged."""

ALL_SUBSETS = 8
"""Thermometers up to which every set of them is tried; of more, sets that grow by the best one."""


def worth(
    rows: Examples, used: Sequence[int], model: TrainingRun | None = None
) -> dict[tuple[int, ...], float]:
    """Rms error in m of what was held out, by each set of thermometers that was tried.

    Parameters
    ----------
    rows : readings
    used : thermometers to choose from, places in `SENSED`
    model : a run of a plant's model; None if there is none
    """
    found: dict[tuple[int, ...], float] = {}

    def tried(chosen: tuple[int, ...]) -> float:
        found[chosen] = Learner(chosen, model).best(rows)[1].rms
        return found[chosen]

    if len(used) <= ALL_SUBSETS:
        for count in range(1, len(used) + 1):
            for chosen in combinations(used, count):
                tried(chosen)
        return found
    grown: tuple[int, ...] = ()
    while len(grown) < len(used):
        more = [tuple(sorted((*grown, i))) for i in used if i not in grown]
        grown = min(more, key=tried)
    return found


def learning_curve(learnt: LearntMap) -> dict[float, float]:
    """Rms error in m of the last third of the logs, by minutes from the beginning that were learnt from."""
    rows, found = learnt.examples, {}
    lengths = [float(rows.time[rows.log == i].max()) for i in range(int(rows.log.max()) + 1)]
    passed = rows.time + np.append(0.0, np.cumsum(lengths))[rows.log]
    judged = passed > (1 - JUDGED) * passed.max()
    learner = Learner(learnt.used, learnt.model)
    for minutes in MINUTES:
        known = (passed <= 60 * minutes) & ~judged
        if 60 * minutes > (1 - JUDGED) * passed.max() or np.count_nonzero(known) < 2 * (len(learnt.used) + 3):
            continue
        begun, rest = rows.part(known), rows.part(judged)
        block = (BLOCKS * np.arange(begun.growth.size)) // begun.growth.size
        begun = replace(begun, block=block)
        line = learner.line(begun, learner.best(begun)[0])
        error = rest.growth - line.at(rest.temperature[:, learnt.used])
        found[minutes] = float(np.sqrt(np.mean(error**2)))
    return found


def correlations(learnt: LearntMap, logs: Sequence[Log]) -> dict[str, float]:
    """Correlation of what the law leaves with other signals, by their names, the largest first."""
    rows = learnt.examples
    left = rows.growth - learnt.line.at(rows.temperature[:, learnt.used])
    found = {}
    for name in logs[0].others:
        signal = np.concatenate(
            [
                np.interp(rows.time[rows.log == i] + log.time[0], log.time, log.others[name])
                for i, log in enumerate(logs)
                if name in log.others
            ]
        )
        if signal.size == left.size and np.std(signal) > 0 and np.std(left) > 0:
            found[name] = float(np.corrcoef(signal, left)[0, 1])
    return dict(sorted(found.items(), key=lambda each: -abs(each[1])))
