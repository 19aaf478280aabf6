"""Where the heat is.

The winding warms within minutes, the shaft in half an hour, and the link last. After the work ends, the
link goes on growing for a while.
"""

import warmlink as wl

outcome = wl.run("shift_with_breaks", "none", stop="3 h", step="5 s")
parts = (
    "motor.winding_temperature",
    "motor.shaft_temperature",
    "link.base_temperature",
    "link.tip_temperature",
)
figure = wl.plot(outcome, *parts)
