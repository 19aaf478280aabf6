"""No compensation, as a component."""

from warmlink.controllers.interface import compensator, length
from warmlink.controllers.none import law

_LEFT = "standard deviation of the growth, which stays uncorrected"

COMPONENT = compensator(
    "NoCompensator",
    "No compensation",
    law,
    (length("elongation_std", 5e-5, _LEFT, minimum=0, nominal=5e-5),),
)
