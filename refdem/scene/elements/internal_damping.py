"""Damping inside a body: angular momentum stays in space, kinetic energy goes, and the body ends
about its axis of largest inertia.
"""

from typing import Annotated, ClassVar

from refdem.scene.dimension import Dimension
from refdem.scene.element import Link


class InternalDamping(Link, frozen=True, kw_only=True, tag="internal_damping"):
    """Body `a` turns with omega + coefficient (L x omega), where L = J omega is its angular
    momentum, and loses coefficient |L x omega|^2.

    coefficient [s/(kg m**2)]. L stays in space, so that in body axes L' = L x omega + coefficient L
    x (L x omega): the double bracket of Bloch, Krishnaprasad, Marsden and Ratiu 1996. The omega of
    a state is that of J^-1 L, which carries L and the energy.
    """

    conservative: ClassVar[bool] = False
    external: ClassVar[bool] = False
    reads_velocity: ClassVar[bool] = True
    meaning: ClassVar[str] = "a body that dissipates inside and keeps its angular momentum"

    coefficient: Annotated[float, Dimension(-1, -2, 1)]

    def faults(self) -> list[str]:
        """Faults of the fields: damping that brings energy in, or that is between two bodies."""
        faults = []
        if not self.coefficient >= 0:
            faults.append(f"coefficient is {self.coefficient}, expected >= 0")
        if not self.b < 0:
            faults.append(f"b is {self.b}, expected -1: it is inside body a alone")
        return faults
