"""Drag that grows with the square of the velocity, as of a fast body in a thin fluid."""

from typing import Annotated, ClassVar

import numpy as np

from refdem.mechanics import vectors as vec
from refdem.mechanics.vectors import Vector
from refdem.scene.dimension import Dimension
from refdem.scene.element import Array, Link
from refdem.scene.singularity import SQUARE, Singularity


class Drag(Link, frozen=True, kw_only=True, tag="drag"):
    """Force `-coefficient |w| w` on a, w [m/s] being the velocity of a against b, or against the
    fluid at rest.

    coefficient [kg/m], that is rho C_d A / 2 of a body of cross-section A in a fluid of density rho
    (Newton 1687, book II). The reaction acts on b.
    """

    conservative: ClassVar[bool] = False
    has_force: ClassVar[bool] = True
    reads_velocity: ClassVar[bool] = True
    resists: ClassVar[bool] = True
    meaning: ClassVar[str] = "a force against the velocity, as its square"

    coefficient: Annotated[float, Dimension(1, -1, 0)]

    @property
    def external(self) -> bool:  # type: ignore[override]
        """Drag of a fluid at rest acts from outside."""
        return self.b < 0

    def faults(self) -> list[str]:
        """A negative coefficient, with which the drag would push."""
        if self.coefficient >= 0:
            return []
        return [f"coefficient is {self.coefficient}, expected >= 0"]

    def singularity(self) -> Singularity:
        """|w| w has no second derivative where the motion turns back."""
        return Singularity(SQUARE, self.kind)

    def force(self, t: float, d: Vector, w: Vector) -> Vector:
        """F = -coefficient |w| w (3) [N]."""
        return vec.times(-self.coefficient * vec.size(w), w)

    def power(self, t: Array, position: Array, velocity: Array) -> Array | None:
        """P = -coefficient |w|^3 (T,) [W]; None for anchors off the centres."""
        if not self.has_central_anchors():
            return None
        speed = np.linalg.norm(self.relative_velocity(velocity), axis=-1)
        power: Array = -self.coefficient * speed**3
        return power
