"""The parameter set that ships, written by `python -m warmlink.controllers.design`."""

from __future__ import annotations

DESIGNED: dict[str, float | tuple[float, ...]] = {
    "disturbance_std": (
        20.0,
        0.3,
        0.03,
        5e-06,
    ),
    "disturbance_time": (
        1200.0,
        2400.0,
        1000000.0,
        100000.0,
    ),
    "disturbance_start": (
        1.0,
        1.0,
        1.0,
        0.0,
    ),
    "camera_std": 1.075e-07,
}
