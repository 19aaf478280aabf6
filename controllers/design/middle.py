"""Whether the middle thermometer sits where it says anything of the link's temperature profile."""

import numpy as np

from warmlink.controllers.design.plant import INPUTS, OUTPUTS, USUAL_SPEED, Plant, plant_model
from warmlink.fmus.component import limits
from warmlink.fmus.thermal_link.component import COMPONENT as LINK
from warmlink.fmus.thermal_link.equations import sensor_positions

LEAST_SHARE, GOOD_SHARE = 0.15, 0.2
"""Share of the base's rise below which a middle thermometer tells little, and one at which it tells much."""


def middle_advice(plant: Plant) -> str | None:
    """A sentence on where a middle thermometer would tell more; None where it sits well.

    Compared are rises that heat in the shaft makes in the end at the usual speed. Along a slender link the
    rise falls exponentially, so that one place tells where it has fallen to a share.
    """
    (link, *others) = plant.links
    sits = f"{link}.sensor_position[2]"
    usual = {"base": f"{link}.base_temperature", "middle": f"{link}.sensor_temperature[2]"}
    as_usual = all(plant.read.get(f"{name}_temperature") == variable for name, variable in usual.items())
    if others or not as_usual or sits not in plant.component.p.index:
        return None
    model = plant_model(plant)
    A, B = model.at(USUAL_SPEED)
    rise = model.C @ np.linalg.solve(-A, B[:, INPUTS.index("shaft_heat")])
    base, middle = (rise[OUTPUTS.index(f"{name}_temperature")] for name in usual)
    share = float(middle / base)
    if not 0 < share < LEAST_SHARE:
        return None
    values, _ = limits.checked(LINK, link, plant.given_of(link))
    begins, now, *_ = (float(place) for place in sensor_positions(LINK.p.read(values)))
    place = begins + (now - begins) * np.log(GOOD_SHARE) / np.log(share)
    return (
        f"thermometers: the one in the middle, at {1e3 * now:.0f} mm, rises by {100 * share:.2g} % of the "
        f"base's rise; use base, middle and tip with {sits} = {1e3 * place:.0f} mm"
    )
