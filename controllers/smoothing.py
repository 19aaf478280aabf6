"""Growth without the noise of thermometers: three first-order filters in a row that are not late.

    s_i' = (s_i-1 - s_i) / smoothing_time,    growth = 3 s_2 - 2 s_3

For growth at a constant rate s_2 is two time constants late, and s_3 three: the combination is not late.
"""

from warmlink.fmus.calls import as_c_function
from warmlink.fmus.component import Parameter, Record, State
from warmlink.fmus.component.arithmetic import Number, exp, stack

SMOOTHERS = 3
"""First-order filters in a row."""

NONE = 1e-3
"""s; next to no sample is as short, so that nothing is smoothed."""

STATE = State("smoothed", "m", size=SMOOTHERS)


def time(start: float) -> Parameter:
    """The time constant as a parameter, with its start value in s."""
    told = "time constant of each of the three filters of the growth"
    return Parameter("smoothing_time", "s", start, told, positive=True, nominal=10)


def begun(growth: Number) -> Number:
    """The filters at the start, in m."""
    return stack(*[growth] * SMOOTHERS)


@as_c_function
def smoothed(before: Number, growth: Number, p: Record, step: Number) -> Number:
    """The filters after a sample, in m."""
    kept = exp(-step / p.smoothing_time)
    found = []
    for i in range(SMOOTHERS):
        growth = growth + kept * (before[i] - growth)
        found.append(growth)
    return stack(*found)


def on_time(filters: Number) -> Number:
    """Growth in m that is not late as long as it changes at a constant rate."""
    return 3.0 * filters[1] - 2.0 * filters[2]
