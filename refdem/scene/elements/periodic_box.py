"""Space that repeats itself: what leaves a cubic box on one side is also what comes in on the
other.
"""

from typing import ClassVar

from refdem.scene.dimension import Length
from refdem.scene.element import Array, Element


class PeriodicBox(Element, frozen=True, kw_only=True, tag="periodic_box"):
    """Every body has images `size` [m] apart along x, y and z, and pairs meet by their nearest
    images.

    Positions of a trajectory go on beyond the box, so that velocities are their rates; which of the
    images they are does not matter. Momentum is kept; angular momentum is not, for the force
    between images does not act along one line.
    """

    pauses: ClassVar[bool] = True
    meaning: ClassVar[str] = "images of all bodies, a period apart"

    size: Length

    def faults(self) -> list[str]:
        """Faults of the fields: a box without size."""
        if self.size > 0:
            return []
        return [f"size is {self.size}, expected > 0"]

    def torque_reason(self) -> str:
        """A pair across the border exerts forces on two lines."""
        return "forces between periodic images do not act along one line"

    def breaks(self, symmetry: str) -> str | None:
        """The edges of the box have directions."""
        if symmetry == "rotated":
            return "the periodic box has fixed axes"
        return None

    def nearest(self, branch: Array) -> Array:
        """The branch vectors (..., 3) [m] between bodies, each to the nearest image of the other:
        x - size round(x/size).
        """
        to_nearest: Array = branch - self.size * (branch / self.size).round()
        return to_nearest
