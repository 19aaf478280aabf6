"""A controller of your own, tuned.

The correction is a gain times the mean rise of the temperatures at both ends of the link. Optuna finds the
gain whose largest error is smallest. The law becomes a native FMU, so it must stand in a file of its own.
"""

from pathlib import Path
from tempfile import mkdtemp

import warmlink as wl

LAW = '''
from warmlink import Law, Parameter, State

class MeanRise(Law):
    """Growth by the mean of the temperatures at both ends of the link."""

    parameters = (Parameter("gain", "m/K", 4e-6, "growth per kelvin of mean rise", display="um/K"),)
    states = (State("reference", "K"), State("mean", "K"))

    def begin(self, u, p):
        mean = 0.5 * (u.base_temperature + u.tip_temperature)
        return {"reference": mean, "mean": mean}

    def update(self, x, u, p, time, step):
        return {"reference": x.reference, "mean": 0.5 * (u.base_temperature + u.tip_temperature)}

    def correction(self, x, u, p, time):
        return p.gain * (x.mean - x.reference)
'''

STUDY = """
title = "Gain of the mean rise"
controller = "my_law.py:MeanRise"
duty_cycles = ["stop_and_go"]

[parameters]
"compensator.gain" = { min = "4 um/K", max = "8 um/K" }

[objective]
metric = "max_abs_um"
"""

folder = Path(mkdtemp())
(folder / "my_law.py").write_text(LAW)
(folder / "study.toml").write_text(STUDY)

tuned = wl.tune(folder / "study.toml", trials=6, options=wl.RunOptions(jobs=1))
print(tuned)

assert tuned.best is not None
assert tuned.best.objective < 0.3 * tuned.trials[0].objective
assert 5e-6 < tuned.best.point["compensator.gain"] < 8e-6
