"""Cases whose parameters must fit one another: each in bounds, a set of them may still be no body
or no wheel.
"""

from refdem.core.case import Case
from refdem.core.parameters import Parameters
from refdem.errors import UsageError


class TopOnTip(Case):
    """A top whose moments J1 and J3 are about its tip, at `length` from the centre of mass."""

    def refuse(self, p: Parameters) -> None:
        """Raises UsageError for moments about the tip that no body has with this `length`.

        About the centre of mass the transverse moment is J1 - m l^2 (parallel axes); a body has
        J3 <= 2 (J1 - m l^2).
        """
        transverse = p.inertia[0] - p.mass * p.length**2
        axial = p.inertia[1]
        if not (transverse >= 0 and axial <= 2 * transverse):
            raise UsageError(
                f"parameter inertia: got J1 = {p.inertia[0]:g} and J3 = {axial:g} kg m^2; about the"
                f" centre of mass that is J1 - mass length^2 = {transverse:g}; expected J3/2 or"
                " more: take a larger J1"
            )


class StringOnWheel(Case):
    """A string over a wheel that it turns, with a mass at its end."""

    def refuse(self, p: Parameters) -> None:
        """Raises UsageError for inertia of a wheel of radius 0, which the string would not turn."""
        if p.wheel_radius == 0 and p.wheel_inertia != 0:
            raise UsageError(
                f"parameter wheel_inertia: got {p.wheel_inertia:g} kg m^2 for wheel_radius=0;"
                " expected 0 there"
            )
