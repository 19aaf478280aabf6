"""Laws that a log taught, on machines of a structure that their model lacks: none loses to the regression."""

from dataclasses import replace
from functools import cache

import numpy as np
import pandas as pd
import pytest

from benchmarks.strange_machine import Demand, Machine, Room, training
from warmlink.controllers.learning.learnt import LearntMap, learn
from warmlink.controllers.learning.observers import taught
from warmlink.controllers.observer.component import COMPONENT as OBSERVER
from warmlink.controllers.observer_drift.component import COMPONENT as DRIFT
from warmlink.controllers.regression.component import COMPONENT as REGRESSION
from warmlink.controllers.replay import replay
from warmlink.controllers.start_values import with_values
from warmlink.fmus.component import Component
from warmlink.orchestration.replay.logs import MeasuredLog, read_logs

SENSORS = ("base_temperature", "middle_temperature", "tip_temperature")

PLANT = 71


@cache
def learnt() -> LearntMap:
    frame = Machine(PLANT).run(training(), PLANT).log()
    return learn([read_logs([frame])[0].learnt_from], SENSORS)


@cache
def logs() -> list[MeasuredLog]:
    """A cold hall, where growth passes through 0, and hot workpieces, which no duty tells of."""
    cold = [Demand(2700, 3.4, 2.5)]
    hot = [Demand(2400, 2.6, 2.2, workpiece=0.06), Demand(600)]
    frames: list[pd.DataFrame] = [
        Machine(PLANT).run(demands, PLANT + i, room).log()
        for i, (demands, room) in enumerate(((cold, Room(mean=16.0)), (hot, Room())), 1)
    ]
    return read_logs(frames)


def rms(law: Component) -> float:
    """Rms error in m over all logs after the first two minutes of each."""
    values = learnt().values if law is REGRESSION else taught(law_name(law), learnt(), 1.0)
    law, errors = replace(law, parameters=with_values(law.parameters, values)), []
    for log in logs():
        inputs, measured, acting = log.inputs_of(law, 1.0)
        told, late = replay(law, inputs, measured), log.time - log.time[0] > 120.0
        errors.append((log.reference_growth - told.correction[acting])[late])
    return float(np.sqrt(np.mean(np.concatenate(errors) ** 2)))


def law_name(law: Component) -> str:
    return "observer_drift" if law is DRIFT else "observer"


@pytest.mark.parametrize("law", [OBSERVER, DRIFT], ids=lambda law: law.name)
def test_what_no_duty_tells_of_makes_no_law_worse_than_the_regression(law: Component) -> None:
    """The observers held to what the duty told: 8 um off in a cold hall, and 10 um with hot workpieces."""
    assert rms(law) <= 1.1 * rms(REGRESSION)
