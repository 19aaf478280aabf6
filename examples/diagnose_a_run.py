"""Measured data diagnosed, and the model extended.

The run is made up by another solver than the one that the diagnosis uses: at its base the link loses 0.1 W/K,
which the model does not know. With data of your own, read a DataFrame with columns named in this way.
"""

import warmlink as wl

measured = wl.hide({"hub_heat_loss": 0.1})
print(measured.columns.to_list())

found = wl.diagnose(measured)
print(found)
print(found.to_frame())

nominal = wl.run("stop_and_go", "none", stop="30 min")
extended = wl.run("stop_and_go", "none", stop="30 min", parameters=found.extended)
figure = wl.plot(extended, "link.elongation", against=nominal)

assert found.causes == ("hub_heat_loss",)
(conductance,) = found.to_frame()["value"]
assert abs(conductance - 0.1) < 0.005
