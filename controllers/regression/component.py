"""The regression as a component."""

from warmlink.controllers import fail_safe
from warmlink.controllers.interface import SENSED, compensator, length
from warmlink.controllers.matrices import least_pivot, packed_size, symmetric
from warmlink.controllers.regression import law
from warmlink.controllers.start_values import shipped_design, with_values
from warmlink.fmus.component import Check, Parameter, State
from warmlink.fmus.component.quantities import temperature_parameter

_MOMENTS = "second moments of the five rises in K and of the growth in 10 um, upper triangle's rows"
_RESIDUAL = "standard deviation of the regression's residual in the run it was fitted to"

_PARAMETERS = (
    *fail_safe.LIMITS,
    *fail_safe.DOUBT,
    temperature_parameter("reference_temperature", "temperature at which the elongation is 0"),
    fail_safe.SENSOR_STD,
    Parameter("moments", "1", 0, _MOMENTS, size=packed_size(law.STATES), nominal=100),
    Parameter("memory_time", "s", 600, "time for which a missing reading is remembered", positive=True),
    length("residual_std", 0, _RESIDUAL, minimum=0),
)

COMPONENT = compensator(
    "RegressionCompensator",
    "Growth as a linear function of the temperatures, fitted from a run",
    law,
    with_values(_PARAMETERS, shipped_design("regression")),
    (
        State("estimate", "1", size=law.STATES),
        State("spread", "1", size=packed_size(law.STATES)),
        *fail_safe.trust_states("K", len(SENSED)),
        *(State(name, "m") for name in ("correction", "elongation")),
        *(State(name, "1") for name in ("distrusted", "wild")),
        State("waited", "s"),
    ),
    checks=(
        Check(
            lambda p: least_pivot(symmetric(p.moments, law.STATES)) - 1e-12,
            "moments: no positive definite matrix, so no covariance of temperatures and growth; "
            "fit the regression anew with warmlink design --law regression",
        ),
    ),
)
