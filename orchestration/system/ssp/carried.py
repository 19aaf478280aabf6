"""What becomes of a value on its way from connector to connector."""

from __future__ import annotations

from dataclasses import dataclass, replace

from warmlink.orchestration.system.units import Conversion, Unit, fitting

NOTHING_YET = Conversion()


@dataclass(frozen=True)
class Carried:
    """A value under way.

    Parameters
    ----------
    where
        How an error names the way, such as `motor.heat_flow -> link.heat_flow`.
    remedy
        What to do where quantities do not fit.
    unit
        Unit that the value is in by now; None where it is not known.
    difference
        Whether it is a difference, to which the zeros of scales do not apply.
    so_far
        What has become of the value where it set out.
    """

    where: str
    remedy: str
    unit: Unit | None
    difference: bool = False
    so_far: Conversion = NOTHING_YET

    def into(
        self, unit: Unit | None, transformation: Conversion | None = None, suppress: bool = False
    ) -> Carried:
        """Take the value into the next connector: its unit first, then the transformation (SSP 4.5.2).

        `unit` is that of the connector, None where it tells none. With `suppress` the value enters as it is,
        whatever the units.
        """
        so_far = self.so_far
        if self.unit is not None and unit is not None and not suppress:
            step = fitting(self.unit, unit, self.difference, self.where, self.remedy)
            so_far = so_far.then(step.factor, step.offset)
        if transformation is not None:
            so_far = so_far.then(transformation.factor, transformation.offset)
            # What is transformed is in the unit of the connector it reaches, or in none that is known.
            return replace(self, unit=unit, so_far=so_far)
        return replace(self, unit=unit or self.unit, so_far=so_far)
