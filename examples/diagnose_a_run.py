"""Measured data diagnosed, and the model extended.

The run is made up by another solver than the one that the diagnosis uses: at its base the link loses 0.1 W/K,
which the model does not know. With data of your own, read a DataFrame with columns named in this way.
"""

import pandas

import warmlink as wl
from warmlink.orchestration.diagnosis.practice.hide import hide
from warmlink.orchestration.scenarios.duties.duty import Segment

work = [Segment(1800.0, speed=3.43, torque=2.5), Segment(1800.0)]
measured = pandas.DataFrame(hide({"hub_heat_loss": 0.1}, work, interval=60.0))
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
