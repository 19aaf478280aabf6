"""A missing term becomes an equation.

A bearing sticks at low speed, which makes heat that no cause of the catalogue explains: the verdict on the
first run is `unknown`. What the model lacks is estimated as heat over time, and several equations give such
heat, which this one run cannot tell apart. The experiment that is proposed next goes through levels at which
they differ; both runs together leave one equation, and the extended system has it as an FMU. The picture has
the missing heat of the first run, and the equation; below are both answers, in which `step` is 1 where what
it is given is above 0, and 0 elsewhere.
"""

import numpy
import pandas

import warmlink as wl

sticks = "shaft: a * speed * step(b - speed); a = 3; b = 1.5 rad/s"
first = wl.hide(terms=sticks, seed=1)
found = wl.diagnose(first)
print(found.summary(), end="\n\n")

found.write("first")
second = wl.hide(terms=sticks, duty="first/next_experiment.toml", seed=2)
both = wl.diagnose(first, second)
print(both.summary())
both.write("both")  # extended.ssp has the equation as an FMU

told = both.to_dict()["equation"]
missing, term = told["missing_heat"][0], told["members"][0]["terms"][0]
size, limit = (term["parameters"][name]["value"] for name in "ab")
speed = numpy.interp(missing["time_s"], first["time [s]"], first["speed [rad/s]"])
course = {"missing heat [W]": missing["heat_W"], "equation [W]": size * speed * (speed < limit)}
frame = pandas.DataFrame({"time [s]": missing["time_s"], **course})
figure = wl.plot(frame, "missing heat", "equation")
