"""A scenario in closed loop, and its plot.

A joint starts cold, works and pauses. The real cell conducts and stores heat 20 % better than the controller
assumes, and its thermometers are noisy. How far off is the tool point, with the controller and without it?
"""

import warmlink as wl

outcome = wl.run("stop_and_go", "observer", mismatches=["thermal_high", "noisy_sensors"], stop="40 min")
print(outcome)

figure = wl.plot(outcome)

before, after = outcome.uncompensated.max_abs_um, outcome.metrics.max_abs_um
assert before > 30
assert after < 0.1 * before
