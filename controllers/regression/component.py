"""The regression as a component."""

from warmlink.controllers import fail_safe, leaps, smoothing
from warmlink.controllers.interface import SENSED, compensator, length
from warmlink.controllers.matrices import least_pivot, packed_size, symmetric
from warmlink.controllers.regression import law
from warmlink.controllers.start_values import shipped_design, with_values
from warmlink.fmus.component import Check, Parameter, State
from warmlink.fmus.component.quantities import temperature_parameter

_MOMENTS = "second moments of the five rises above their means in K, upper triangle's rows"
_SPREAD = "covariance of the coefficients in (um/K)2, upper triangle's rows; affects only correction_std"
_RESIDUAL = "standard deviation of what the law leaves of growth that it was not fitted to"

_PARAMETERS = (
    *fail_safe.LIMITS,
    *fail_safe.DOUBT,
    temperature_parameter("reference_temperature", "temperature above which rises count"),
    fail_safe.SENSOR_STD,
    length("intercept", 0, "growth with every temperature at the reference", nominal=1e-5),
    Parameter(
        "coefficients",
        "m/K",
        0,
        "growth per kelvin of each sensor: shaft, winding, base, middle, tip",
        display="um/K",
        size=law.SENSORS,
        nominal=1e-6,
    ),
    Parameter(
        "mean_rise", "K", 0, "mean rise of each sensor above the reference", size=law.SENSORS, nominal=10
    ),
    Parameter("moments", "1", 0, _MOMENTS, size=packed_size(law.SENSORS), nominal=100),
    Parameter("coefficient_spread", "1", 0, _SPREAD, size=packed_size(law.SENSORS), nominal=0.01),
    Parameter("memory_time", "s", 600, "time for which a missing reading is remembered", positive=True),
    smoothing.time(15),
    length("residual_std", 0, _RESIDUAL, minimum=0),
)

COMPONENT = compensator(
    "RegressionCompensator",
    "Growth as a linear function of the temperatures, fitted to a run or learnt from a log",
    law,
    with_values(_PARAMETERS, shipped_design("regression")),
    (
        State("estimate", "K", size=law.SENSORS),
        State("spread", "1", size=packed_size(law.SENSORS)),
        *fail_safe.trust_states("K", len(SENSED)),
        *leaps.STATES,
        smoothing.STATE,
        *(State(name, "m") for name in ("correction", "elongation")),
        *(State(name, "1") for name in ("distrusted", "wild")),
        State("waited", "s"),
    ),
    checks=(
        Check(
            lambda p: least_pivot(symmetric(p.moments, law.SENSORS)) - 1e-12,
            "moments: no positive definite matrix, so no covariance of temperatures; "
            "fit the regression anew with warmlink design --law regression",
        ),
    ),
)
