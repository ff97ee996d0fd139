"""A dashpot in a fluid that turns: its force opposes the velocity against the fluid, and so pushes
along a circle what does not turn with it.
"""

from typing import ClassVar

import numpy as np

from refdem.mechanics import vectors as vec
from refdem.mechanics.vectors import Vector
from refdem.scene.dimension import Damping, Omega
from refdem.scene.element import Array, Link


class RotatingDashpot(Link, frozen=True, kw_only=True, tag="rotating_dashpot"):
    """Force `-damping (v - rate x d)` on the centre of a, v [m/s] being its velocity and d [m] its
    place from `anchor_b`, which is fixed in space.

    damping [N s/m]; `rate` [rad/s] is the angular velocity of the fluid, in space axes. In a shaft
    this is the damping of its own material, which turns with it (Jeffcott's rotor; Merkin,
    Introduction to the Theory of Stability, 1997).
    """

    external: ClassVar[bool] = True
    has_force: ClassVar[bool] = True
    reads_velocity: ClassVar[bool] = True
    meaning: ClassVar[str] = "a dashpot whose fluid turns: F = -damping (v - rate x d)"

    damping: Damping
    rate: Omega = (0.0, 0.0, 0.0)

    @property
    def conservative(self) -> bool:  # type: ignore[override]
        """True only for a dashpot without force: any other changes the energy."""
        return self.damping == 0

    @property
    def drives(self) -> bool:  # type: ignore[override]
        """A fluid that turns can bring energy in."""
        return self.damping > 0 and any(self.rate)

    def features(self) -> frozenset[str]:
        """The kind; and it is a dashpot, whose force depends on the velocity."""
        return frozenset({self.kind, "dashpot"})

    def faults(self) -> list[str]:
        """A damping below zero, a second body, a place off the centre of the first."""
        faults = []
        if not self.damping >= 0:
            faults.append(f"damping is {self.damping}, expected >= 0")
        if self.b >= 0:
            faults.append(f"b is {self.b}, expected -1: the fluid turns about a point of space")
        if any(self.anchor_a):
            faults.append("anchor_a is not 0; expected the centre of the body")
        return faults

    def force(self, t: float, d: Vector, w: Vector) -> Vector:
        """F = -damping (w - rate x d) (3) [N]."""
        of_fluid = vec.cross(self.rate, d)
        return vec.times(-self.damping, vec.minus(w, of_fluid))

    def power(self, t: Array, position: Array, velocity: Array) -> Array:
        """P = -damping (v - rate x d) . v (T,) [W]."""
        # d = r - anchor_b, and rate x d is the velocity of the fluid there.
        place = position[:, self.a] - np.array(self.anchor_b)
        of_body = velocity[:, self.a]
        of_fluid = np.cross(np.array(self.rate), place)
        power: Array = -self.damping * np.sum((of_body - of_fluid) * of_body, axis=-1)
        return power
