"""A designed observer in the long run: its error, filter poles and gains, and what thermometers are worth."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from scipy.linalg import solve_continuous_are, solve_continuous_lyapunov

from warmlink.controllers.design.gains import Array, Unknown
from warmlink.controllers.design.plant import INPUTS, OUTPUTS, USUAL_SPEED
from warmlink.controllers.design.reduction import ReducedPlant


@dataclass(frozen=True)
class Steady:
    """The stationary Kalman filter of a reduced plant under unknown heat, thermometers and their noise.

    Attributes
    ----------
    error : standard deviation of the correction's error in m
    time_constants : of the filter in s, longest first, shape (modes + 2,)
    gains : by which each thermometer's surprise moves the correction, in m/s per K, shape (thermometers,)
    """

    error: float
    time_constants: Array
    gains: Array


def steady(
    reduced: ReducedPlant,
    unknown: Unknown,
    noise: Mapping[str, float],
    sample_time: float,
    speed: float = USUAL_SPEED,
) -> Steady:
    """Solve the Riccati equation of the filter in continuous time, at a speed in rad/s.

    Parameters
    ----------
    reduced : the plant that the law knows
    unknown : unknown heats into shaft and link, which the filter estimates too
    noise : standard deviation in K of each reading by the thermometer's name; none if the duty counts alone
    sample_time : time in s between two readings, whose noise is independent
    """
    A, B = reduced.at(speed)
    size = np.array([unknown.shaft_heat, unknown.link_heat])
    time = np.array([unknown.shaft_heat_time, unknown.link_heat_time])
    heats = B[:, [INPUTS.index(f"{place}_heat") for place in ("shaft", "link")]]
    state = np.block([[A, heats], [np.zeros((2, len(A))), np.diag(-1 / time)]])
    driven = np.diag([*np.zeros(len(A)), *(2 * size**2 / time)])
    rows = np.pad(reduced.C, ((0, 0), (0, 2)))
    growth, seen = rows[OUTPUTS.index("elongation")], rows[[OUTPUTS.index(name) for name in noise]]
    if not noise:
        covariance, gains = solve_continuous_lyapunov(state, -driven), np.zeros((len(state), 0))
    else:
        spread = sample_time * np.diag(np.square([*noise.values()]))
        covariance = solve_continuous_are(state.T, seen.T, driven, spread)
        gains = covariance @ seen.T @ np.linalg.inv(spread)
    poles = np.linalg.eigvals(state - gains @ seen)
    # Of poles that swing the real part tells how fast they fade.
    longest_first = np.sort(-1 / poles.real)[::-1]
    error = float(np.hypot(np.sqrt(max(0.0, growth @ covariance @ growth)), reduced.error.elongation_step))
    return Steady(error, longest_first, growth @ gains)


def worth(
    reduced: ReducedPlant, unknown: Unknown, noise: Mapping[str, float], sample_time: float
) -> dict[Sequence[str], float]:
    """Expected error in m with each subset of some thermometers, the least first."""
    subsets = (some for size in range(len(noise) + 1) for some in combinations(noise, size))
    errors = {
        some: steady(reduced, unknown, {name: noise[name] for name in some}, sample_time).error
        for some in subsets
    }
    return dict(sorted(errors.items(), key=lambda each: each[1]))
