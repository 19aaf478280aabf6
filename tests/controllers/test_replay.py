"""A law run through a log gives the numbers of its FMU, and a camera sees what the law has left."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.strange_machine import Machine, training
from warmlink.controllers import replay as module
from warmlink.controllers.interface import SENSED
from warmlink.controllers.replay import period, replay
from warmlink.fmus.component import Component
from warmlink.fmus.errors import InputError
from warmlink.orchestration.catalogue import controllers

Array = NDArray[np.float64]


@cache
def log() -> tuple[Array, Array, Array]:
    """Temperatures in K, duty and the growth in m of an hour, a row a second."""
    found = Machine(1).run(training()[:1], 1).log().iloc[:3600]
    temperature = np.column_stack([found[f"{name} [degC]"] + 273.15 for name in SENSED])
    duty = np.column_stack([found["speed [rad/s]"], found["torque [N.m]"]])
    return temperature, duty, 1e-6 * found["growth [um]"].to_numpy()


def rows(law: Component) -> Array:
    temperature, duty, growth = log()
    found = np.zeros((growth.size, law.u.size))
    for i, name in enumerate(SENSED):
        found[:, law.u.index[name]] = temperature[:, i]
    found[:, [law.u.index["speed"], law.u.index["torque"]]] = duty
    found[:, law.u.index["ambient_temperature"]] = 295.15
    return found


@pytest.mark.parametrize("name", ["none", "lag", "analytic", "regression", "observer", "observer_drift"])
def test_c_and_python_say_the_same(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    law, few = controllers()[name], 150
    measured = np.where(np.arange(few) % 60 == 0, log()[2][:few], np.nan)
    fast = replay(law, rows(law)[:few], measured)

    def no_compiler(law: Component) -> bytes:
        raise InputError("no compiler")

    monkeypatch.setattr(module, "_library", no_compiler)
    plain = replay(law, rows(law)[:few], measured)
    for one, other in zip(vars(fast).values(), vars(plain).values(), strict=True):
        assert one == pytest.approx(other, rel=1e-9, abs=1e-15)


def test_a_camera_closes_the_loop() -> None:
    """The law that uses it comes near the growth; without it, it does not."""
    law = controllers()["observer_drift"]
    growth = log()[2]
    measured = np.where(np.arange(growth.size) % 60 == 0, growth, np.nan)
    seen = replay(law, rows(law), measured)
    blind = replay(law, rows(law))
    late = slice(1800, None)
    assert np.abs(growth - seen.correction)[late].max() < 2e-6
    assert np.abs(growth - blind.correction)[late].max() > 5e-6


def test_a_refused_parameter_is_said() -> None:
    from dataclasses import replace

    from warmlink.controllers.start_values import with_scalars

    law = controllers()["regression"]
    wrong = replace(law, parameters=with_scalars(law.parameters, {"moments[1]": -1.0}))
    with pytest.raises(InputError, match="no positive definite matrix"):
        replay(wrong, rows(wrong)[:5])
    assert period(law) == 1.0
