"""The parameter set that ships, written by `python -m warmlink.controllers.design`."""

from __future__ import annotations

DESIGNED: dict[str, float | tuple[float, ...]] = {
    "reference_temperature": 295.15,
    "sensor_std": (
        0.0,
        0.0,
        0.1,
        0.0,
        0.1,
    ),
    "moments": (
        239.902762132,
        402.76302936,
        216.384017286,
        137.801440129,
        111.668706814,
        100.777539624,
        687.992408466,
        362.093221076,
        226.527575333,
        181.763282572,
        166.178563719,
        195.301520171,
        124.827851519,
        101.360466669,
        91.2328933254,
        81.3807687038,
        66.8128463816,
        59.280175456,
        55.1860884492,
        48.5796952389,
        43.2056952708,
    ),
    "memory_time": 600.0,
    "residual_std": 2.69622909068e-07,
}
