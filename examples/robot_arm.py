"""Six links in a chain, and the error of the tool point.

Each axis of the arm has a motor, a link and a controller. The scenario says which poses the arm takes; the
error is how far the growth of the links moves the tool point in space.
"""

import warmlink as wl

outcome = wl.run("six_axis_shift", "observer", stop="10 min", step="2 s")
print(outcome)

figure = wl.plot(outcome, *(f"axis{i}.link.elongation" for i in range(1, 7)))

assert outcome.uncompensated.max_abs_um > 4
assert outcome.metrics.max_abs_um < 0.5 * outcome.uncompensated.max_abs_um
