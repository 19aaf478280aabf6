"""A missing term becomes an equation.

A bearing sticks at low speed, which no cause of the catalogue explains. The missing heat is estimated and
turned into equations, which one run cannot tell apart; the experiment that is proposed then does.
"""

import numpy
import pandas

import warmlink as wl

sticks = "shaft: a * speed * step(b - speed); a = 3; b = 1.5 rad/s"
first = wl.hide(terms=sticks, seed=1)
found = wl.diagnose(first)
print(found.summary())

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
