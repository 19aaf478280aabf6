"""Two lumps, winding and shaft, the losses that heat them, and the paths by which heat leaves.

    C_w dT_w/dt = P_cu + P_fe + P_w - G_ws (T_w - T_s)
    C_s dT_s/dt = G_ws (T_w - T_s) + P_fr + P_pad + P_idle + P_s - G_sh (T_s - T_a) - Q - Q_n

The usual two-node thermal model of a servo motor: copper loss by Joule's law with a resistance linear in
temperature, iron loss with the square of speed, Coulomb and viscous friction. A lubricant thins exponentially
as it warms, and viscous friction alone falls with it (A. C. Bittencourt and S. Gunnarsson, Static friction in
a robot joint, Journal of Dynamic Systems, Measurement, and Control 134(5), 2012).
"""

from warmlink.fmus.component import Record, Values
from warmlink.fmus.component.arithmetic import Number, absolute, clip, exp, real, where

RESISTANCE_TEMPERATURE = 293.15
"""K, at which the winding has its stated resistance."""

REFERENCE_TEMPERATURE = 295.15
"""K, at which friction and the joint's conductance have their stated level."""

PAD_POWER, PAD_TEMPERATURE = 1, 2
"""Values of `pad_mode` besides 0, no pad."""


def rates(x: Record, u: Record, p: Record, time: Number) -> Values:
    """Time derivatives of the states: temperatures in K/s, heat delivered in W."""
    flows, to_link = heat_flows(x, u, p, time), heat_flow(x.shaft_temperature, u, p)
    made = flows["copper_loss"] + flows["iron_loss"] + u.added_winding_heat
    into_winding = made - flows["winding_heat_flow"]
    into_shaft = (
        flows["winding_heat_flow"]
        + flows["friction_loss"]
        + flows["pad_heat_flow"]
        + idle_loss(u, p)
        + u.added_shaft_heat
        - flows["housing_heat_flow"]
        - to_link
        - neighbour_heat_flow(x.shaft_temperature, u, p)
    )
    return {
        "winding_temperature": into_winding / p.winding_heat_capacity,
        "shaft_temperature": into_shaft / p.shaft_heat_capacity,
        "heat_delivered": to_link,
    }


def outputs(x: Record, u: Record, p: Record, time: Number) -> Values:
    """Heat flows in W, temperatures in K, heat in J."""
    return {
        "heat_flow": heat_flow(x.shaft_temperature, u, p),
        "neighbour_heat_flow": neighbour_heat_flow(x.shaft_temperature, u, p),
        "shaft_temperature": x.shaft_temperature,
        "winding_temperature": x.winding_temperature,
        "heat_delivered": x.heat_delivered,
    }


def heat_flows(x: Record, u: Record, p: Record, time: Number) -> Values:
    """Losses and heat flows in W inside the motor."""
    winding, shaft = x.winding_temperature, x.shaft_temperature
    return {
        "copper_loss": copper_loss(winding, u, p),
        "iron_loss": iron_loss(u, p),
        "friction_loss": friction_loss(shaft, u, p),
        "pad_heat_flow": pad_heat(shaft, u, p),
        "winding_heat_flow": p.winding_conductance * (winding - shaft),
        "housing_heat_flow": housing_heat_flow(shaft, u, p, time),
    }


def heat_flow(shaft: Number, u: Record, p: Record) -> Number:
    """Heat flow in W through the joint into the link; the joint's resistance lies in series."""
    conductance = p.joint_conductance / (1 + p.joint_conductance * p.joint_resistance)
    warmth = 1 + p.joint_temperature_coefficient * (shaft - REFERENCE_TEMPERATURE)
    return conductance * warmth * (shaft - u.link_base_temperature)


def housing_heat_flow(shaft: Number, u: Record, p: Record, time: Number) -> Number:
    """Heat flow in W from the shaft through the housing to the surroundings."""
    ambient = u.ambient_temperature + p.ambient_offset + p.ambient_drift * time
    conductance = p.housing_conductance + p.housing_conductance_per_speed * absolute(u.speed)
    return conductance * (shaft - ambient)


def neighbour_heat_flow(shaft: Number, u: Record, p: Record) -> Number:
    """Heat flow in W to the neighbouring joint."""
    return p.neighbour_conductance * (shaft - u.neighbour_temperature)


def copper_loss(winding: Number, u: Record, p: Record) -> Number:
    """Joule loss in W; the current is given, or follows from the torque."""
    current = u.current + u.torque / p.torque_constant
    warmth = 1 + p.winding_temperature_coefficient * (winding - RESISTANCE_TEMPERATURE)
    return p.winding_resistance * warmth * current**2


def iron_loss(u: Record, p: Record) -> Number:
    """Loss in W in the iron."""
    return p.iron_loss_coefficient * u.speed**2


def friction_loss(shaft: Number, u: Record, p: Record) -> Number:
    """Loss in W in bearings and gear."""
    speed = absolute(u.speed)
    warmth = shaft - REFERENCE_TEMPERATURE
    level = p.friction_factor * (1 - p.friction_temperature_coefficient * warmth)
    viscosity = p.viscous_friction * exp(-p.viscosity_temperature_coefficient * warmth)
    return level * (p.coulomb_friction + viscosity * speed) * speed


def idle_loss(u: Record, p: Record) -> Number:
    """Heat into the shaft in W that no load asks for: at all times, and while the joint moves."""
    return p.standby_power + p.moving_power * where(absolute(u.speed) > 0, 1.0, 0.0)


def pad_heat(shaft: Number, u: Record, p: Record) -> Number:
    """Heat in W from the pad around the shaft: off, a power, or held at a temperature."""
    mode = real(u.pad_mode)
    held = clip(p.pad_gain * (u.pad_temperature - shaft), 0.0, p.pad_power_limit)
    return where(mode == PAD_TEMPERATURE, held, where(mode == PAD_POWER, u.pad_power, 0.0))
