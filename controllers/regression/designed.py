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
        239.962346153,
        402.877821277,
        216.40709425,
        137.806663161,
        111.668894397,
        100.782728653,
        688.250294749,
        362.020129018,
        226.4597559,
        181.70013126,
        166.13186374,
        195.320414232,
        124.873816172,
        101.41288194,
        91.2623926332,
        81.4346531055,
        66.8675372033,
        59.3166287458,
        55.2399156321,
        48.6171402982,
        43.230229639,
    ),
    "memory_time": 600.0,
    "residual_std": 2.6870103961e-07,
}
