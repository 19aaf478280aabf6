"""The regression as a component."""

from __future__ import annotations

from warmlink.controllers import fail_safe
from warmlink.controllers.interface import INPUTS, OUTPUTS, SAMPLE_TIME, SENSED, TERMINALS, TOLERANCE
from warmlink.controllers.matrices import least_pivot, packed_size, symmetric
from warmlink.controllers.regression import law
from warmlink.controllers.start_values import shipped_design, with_values
from warmlink.fmus.component import Check, Component, Parameter, State
from warmlink.fmus.component.quantities import temperature_parameter

_PARAMETERS = (
    SAMPLE_TIME,
    TOLERANCE,
    *fail_safe.LIMITS,
    *fail_safe.DOUBT,
    temperature_parameter("reference_temperature", "temperature at which the elongation is 0"),
    fail_safe.SENSOR_STD,
    Parameter(
        "moments",
        "1",
        0,
        "second moments of the five rises in K and of the growth in 10 um, upper triangle's rows",
        size=packed_size(law.STATES),
        nominal=100,
    ),
    Parameter("memory_time", "s", 600, "time for which a missing reading is remembered", positive=True),
    Parameter(
        "residual_std",
        "m",
        0,
        "standard deviation of the regression's residual in the run it was fitted to",
        display="um",
        minimum=0,
        nominal=1e-6,
    ),
)

COMPONENT = Component(
    name="RegressionCompensator",
    description="Growth as a linear function of the temperatures, fitted from a run",
    inputs=INPUTS,
    terminals=TERMINALS,
    parameters=with_values(_PARAMETERS, shipped_design("regression")),
    states=(
        State("estimate", "1", size=law.STATES),
        State("spread", "1", size=packed_size(law.STATES)),
        *fail_safe.trust_states("K", len(SENSED)),
        State("correction", "m"),
        State("elongation", "m"),
        State("distrusted", "1"),
        State("wild", "1"),
    ),
    outputs=OUTPUTS,
    update=law.update,
    begin=law.begin,
    checks=(
        Check(
            lambda p: least_pivot(symmetric(p.moments, law.STATES)) - 1e-12,
            "moments: no positive definite matrix, so no covariance of temperatures and growth; "
            "fit the regression anew with warmlink design --law regression",
        ),
    ),
    observe=law.outputs,
)
