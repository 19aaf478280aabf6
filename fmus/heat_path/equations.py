"""Heat between two places, and heat from a source, added to the heat flows that a model has already.

Q = G (T_from - T_to)
into the receiving place:  what arrives already + Q + P + r t + s |speed|
into the giving place:     what arrives already - Q
"""

from warmlink.fmus.component import Record, Values
from warmlink.fmus.component.arithmetic import Number, absolute


def outputs(x: Record, u: Record, p: Record, time: Number) -> Values:
    """Heat flows in W."""
    conducted = p.conductance * (u.from_temperature - u.to_temperature)
    made = p.heat + p.heat_rate * time + p.heat_per_speed * absolute(u.speed)
    return {
        "total_to_heat_flow": u.to_heat_flow + conducted + made,
        "total_from_heat_flow": u.from_heat_flow - conducted,
    }
