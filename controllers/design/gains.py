"""Parameter sets of the observers: the reduced plant, what is unknown about it, and the sensors in use."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from warmlink.controllers.design.plant import (
    INPUTS,
    OUTPUTS,
    USUAL_SPEED,
    LinearPlant,
    Plant,
    cell_plant,
    no_growth,
    plant_model,
)
from warmlink.controllers.design.reduction import ReducedPlant, reduce_plant
from warmlink.controllers.design.structure import structure_spread
from warmlink.controllers.interface import SENSED
from warmlink.controllers.matrices import upper
from warmlink.controllers.observer.model import LOSSES, MODES
from warmlink.fmus.component import limits
from warmlink.fmus.component.quantities import ROOM_TEMPERATURE
from warmlink.fmus.drift_camera.component import COMPONENT as CAMERA
from warmlink.fmus.errors import InputError
from warmlink.fmus.motor_heat_source.component import COMPONENT as MOTOR
from warmlink.fmus.names import instead

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Unknown:
    """What the designer does not know: sizes (1 sigma) and how long they last, as they suit the nominal cell.

    Attributes
    ----------
    shaft_heat, shaft_heat_time : unknown heat into the shaft in W, a heating pad for one, and the time in s
        over which it is correlated
    link_heat, link_heat_time : unknown heat into the link: convection and absorbed radiation
    profile : error in K of the temperature profile that a wrong conductivity leaves, of each mode where it
        is largest
    expansion, expansion_time : relative error of the expansion coefficient
    offset, offset_time : error in m that no temperature explains
    uniform : doubt in K about a cold start
    quiet_share : share of unknown heat and profile that the quiet filter expects
    """

    shaft_heat: float = 20.0
    shaft_heat_time: float = 1200.0
    link_heat: float = 0.3
    link_heat_time: float = 2400.0
    profile: float = 0.003
    expansion: float = 0.03
    expansion_time: float = 1e6
    offset: float = 5e-6
    offset_time: float = 1e5
    uniform: float = 0.03
    quiet_share: float = 0.05


LOSS_DOUBT = 0.2
"""Share by which the link may lose less heat than was thought."""


@dataclass(frozen=True)
class Design:
    """A parameter set for a law's component, and what it was made from.

    Attributes
    ----------
    parameters : values by parameter name, a list where the parameter is a vector
    reduced : the reduced plant, with the reduction's error
    """

    parameters: Mapping[str, float | list[float]]
    reduced: ReducedPlant


def design_controller(
    law: str = "observer",
    sensors: Sequence[str] = ("base_temperature", "tip_temperature"),
    sensor_std: float | Mapping[str, float] = 0.1,
    sample_time: float = 1.0,
    plant: Plant | None = None,
    unknown: Unknown | None = None,
    camera_std: float | None = None,
) -> Design:
    """Work out the parameter set of `observer` or `observer_drift`.

    Parameters
    ----------
    law : "observer" or "observer_drift"
    sensors : which of the cell's temperatures the law goes by; any, all or none. The ending `_temperature`
        may be left off
    sensor_std : standard deviation in K of a reading, one for all or one by sensor
    sample_time : time in s between two corrections
    plant : motors and links; those of the nominal warm-up cell by default
    unknown : what is unknown, by default what `expected` gives for a cell with a heating pad
    camera_std : standard deviation in m of a camera reading, for `observer_drift`; by default that of the
        DriftCamera component

    Raises
    ------
    InputError
        The law or a sensor is unknown, a standard deviation is not positive, or the plant's parameters are
        out of range.
    """
    if law not in {"observer", "observer_drift"}:
        raise InputError(f"law: {law!r} has no design; design 'observer' or 'observer_drift'")
    stds = sensor_stds(sensors, sensor_std)
    plant = plant or cell_plant()
    linear = plant_model(plant)
    reduced = reduce_plant(linear, MODES)
    unknown = unknown or expected(linear)
    lasting = [(unknown.shaft_heat, unknown.shaft_heat_time), (unknown.link_heat, unknown.link_heat_time)]
    if law == "observer_drift":
        lasting += [(unknown.expansion, unknown.expansion_time), (unknown.offset, unknown.offset_time)]
    values: dict[str, float | list[float]] = {
        "sample_time": sample_time,
        **plant_parameters(reduced, plant),
        "model_std": reduced.error.elongation_step,
        "sensor_std": stds,
        "uniform_profile": uniform_profile(reduced).tolist(),
        "initial_std": unknown.uniform,
        "warm_spread": upper(warm_spread(reduced)).tolist(),
        "profile_std": (unknown.profile / np.abs(reduced.C[:-1]).max(axis=0)).tolist(),
        "disturbance_std": [std for std, _ in lasting],
        "disturbance_time": [time for _, time in lasting],
        # The camera's zero is where the run starts, so there is no offset yet.
        "disturbance_start": [1.0, 1.0, 1.0, 0.0][: len(lasting)],
        "quiet_share": unknown.quiet_share,
        "mean_temperature": [no_growth(plant)] * len(SENSED),
        "coefficient_spread": structure_spread(
            growth_by_sensors(reduced, stds), stds, reduced.elongation_per_kelvin
        ),
    }
    if law == "observer_drift":
        camera = CAMERA.p.read(limits.checked(CAMERA, "camera", {})[0])
        noise = float(camera.pixel_size * camera.centroid_noise)
        values["camera_std"] = noise if camera_std is None else camera_std
    return Design(values, reduced)


def expected(plant: LinearPlant) -> Unknown:
    """What is unknown of a plant: as of the nominal cell, in proportion to what it does to this one.

    Unknown heat in the link is as large a part of the heat that the link holds as in the nominal cell, when
    the shaft is heated at the usual speed. The profile's error grows as the thermometers' contradiction does
    where the losses are not those that were thought; it is always there, so that the quiet filter expects it
    too.
    """
    usual, nominal = Unknown(), plant_model()
    heat = usual.link_heat * _held_of_link_heat(nominal) / _held_of_link_heat(plant)
    profile = usual.profile * max(1.0, _contradiction(plant) / _contradiction(nominal))
    quiet = max(usual.quiet_share, 1.0 - usual.profile / profile)
    return replace(usual, link_heat=heat, profile=profile, quiet_share=quiet)


def _contradiction(plant: LinearPlant) -> float:
    """By how many K per watt in the shaft the link's thermometers contradict the plant if it loses less heat.

    In the end and at rest, beside the plant as it was thought to be with the unknown heats in shaft and link
    that explain the readings best. The losses are less by `LOSS_DOUBT`, distributed as those that motion
    brings; 0 where it brings none.
    """
    lost, by_motion = plant.link_loss(plant.B), plant.link_loss(plant.B_speed)
    if by_motion <= 0:
        return 0.0
    less = plant.A - LOSS_DOUBT * lost / by_motion * plant.A_speed
    into = plant.B[:, [INPUTS.index("shaft_heat"), INPUTS.index("link_heat")]]
    seen = plant.C[[OUTPUTS.index(f"{place}_temperature") for place in ("base", "middle", "tip")]]
    thought, true = (seen @ np.linalg.solve(-A, into) for A in (plant.A, less))
    explained = thought @ np.linalg.lstsq(thought, true[:, 0], rcond=None)[0]
    return float(np.linalg.norm(true[:, 0] - explained))


def _held_of_link_heat(plant: LinearPlant) -> float:
    """Heat that the link holds in the end by 1 W in itself, relative to 1 W in the shaft.

    InputError where none comes from the shaft.
    """
    A, B = plant.at(USUAL_SPEED)
    link = list(plant.link_states)
    held = (plant.heat_capacity * plant.uniform)[link] @ np.linalg.solve(-A, B)[link]
    own, of_shaft = (float(held[INPUTS.index(name)]) for name in ("link_heat", "shaft_heat"))
    if not of_shaft > 0:
        raise InputError(
            "design: heat of the shaft does not reach the link, whose growth does not follow the motor then; "
            "give the joint a conductance above 0 W/K"
        )
    return own / of_shaft


def plant_parameters(reduced: ReducedPlant, plant: Plant) -> dict[str, float | list[float]]:
    """The law's parameters that describe the plant, by name."""
    motor = MOTOR.p.read(limits.checked(MOTOR, "motor", plant.motor)[0])
    column = {name: i for i, name in enumerate(INPUTS)}
    sensors = reduced.C[[OUTPUTS.index(name) for name in SENSED]]
    return {
        **{name: float(getattr(motor, name)) for name in LOSSES},
        "linearisation_temperature": ROOM_TEMPERATURE,
        "reference_temperature": no_growth(plant),
        "mode_rate": reduced.rate.tolist(),
        "convection": reduced.A_speed.ravel().tolist(),
        "winding_heat_gain": reduced.B[:, column["winding_heat"]].tolist(),
        "shaft_heat_gain": reduced.B[:, column["shaft_heat"]].tolist(),
        "link_heat_gain": reduced.B[:, column["link_heat"]].tolist(),
        "ambient_gain": reduced.B[:, column["ambient_temperature"]].tolist(),
        "ambient_convection_gain": reduced.B_speed[:, column["ambient_temperature"]].tolist(),
        "sensor_rows": sensors.ravel().tolist(),
        "elongation_row": reduced.C[OUTPUTS.index("elongation")].tolist(),
        "elongation_per_kelvin": reduced.elongation_per_kelvin,
        "link_loss": reduced.link_loss,
        "link_loss_per_speed": max(0.0, reduced.link_loss_per_speed),
    }


def uniform_profile(reduced: ReducedPlant) -> Array:
    """The modes of everything being 1 K warmer: what surroundings 1 K warmer lead to at standstill."""
    return -reduced.B[:, INPUTS.index("ambient_temperature")] / reduced.rate


def growth_by_sensors(reduced: ReducedPlant, stds: Sequence[float]) -> Array:
    """Growth in m/K by each thermometer over cells left warm and cells warm throughout, shape (len(SENSED),).

    0 for a thermometer without a standard deviation, which is not in use.
    """
    used, found = np.flatnonzero(stds), np.zeros(len(SENSED))
    profile = uniform_profile(reduced)
    spread = 100.0 * (warm_spread(reduced) + np.outer(profile, profile))
    rows = reduced.C[[OUTPUTS.index(SENSED[i]) for i in used]]
    noisy = rows @ spread @ rows.T + np.diag(np.square(stds)[used])
    found[used] = np.linalg.solve(noisy, rows @ spread @ reduced.C[OUTPUTS.index("elongation")])
    return found


def warm_spread(reduced: ReducedPlant, time: float = 1800.0) -> Array:
    """Covariance of the states that past heat in the motor leaves, shape (r, r).

    The stationary covariance under as much heat in the shaft as in the winding, each with a correlation time
    in s, scaled such that the shaft's temperature has the variance 1 K2; where nobody reads it, the read one
    that varies most.
    """
    heats = reduced.B[:, [INPUTS.index(f"{place}_heat") for place in ("shaft", "winding")]]
    count = heats.shape[1]
    state = linalg.block_diag(np.diag(reduced.rate), -np.eye(count) / time)
    state[: reduced.order, reduced.order :] = heats
    drive = linalg.block_diag(np.zeros((reduced.order,) * 2), 2 / time * np.eye(count))
    covariance = linalg.solve_continuous_lyapunov(state, -drive)[: reduced.order, : reduced.order]
    variances = [float(row @ covariance @ row) for row in reduced.C[:-1]]
    return covariance / (variances[OUTPUTS.index("shaft_temperature")] or max(variances))


def sensor_stds(sensors: Sequence[str], sensor_std: float | Mapping[str, float]) -> list[float]:
    """Standard deviation in K of every sensor of the cell, 0 for those not in use.

    Raises
    ------
    InputError
        A sensor is unknown, or its standard deviation not positive.
    """
    used = {_sensor(name) for name in sensors}
    several = sensor_std if isinstance(sensor_std, Mapping) else dict.fromkeys(SENSED, sensor_std)
    given = {_sensor(name): float(std) for name, std in several.items()}
    for name in (each for each in SENSED if each in used):
        std = given.setdefault(name, 0.0)
        if not std > 0:
            raise InputError(
                f"sensor_std: {std:g} K for {name} is not positive; give the sensor's noise above 0 K"
            )
    return [given[name] if name in used else 0.0 for name in SENSED]


def _sensor(name: str) -> str:
    for full in (name, f"{name}_temperature"):
        if full in SENSED:
            return full
    short = [each.removesuffix("_temperature") for each in SENSED]
    raise InputError(f"sensors: {name!r} is not measured in the cell; {instead(name, short)}")
