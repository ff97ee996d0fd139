"""A field of force along one axis that rises linearly from x1 to the origin and falls linearly to
x2 (1.139).
"""

from typing import Any, ClassVar

import numpy as np

from refdem.mechanics import vectors as vec
from refdem.mechanics.vectors import Vector
from refdem.scene.dimension import Direction, Length, Position, Stiffness
from refdem.scene.element import Array, Field
from refdem.scene.singularity import KINK, Singularity


class PiecewiseField(Field, frozen=True, kw_only=True, tag="piecewise_field"):
    """Force F(s) along `axis` on every body that is not fixed, s = (r - point).axis [m]; potential
    zero before x1.

    `k1 (s - x1)` for x1 <= s <= 0, `k2 (s - x2)` for 0 <= s <= x2, else 0, with x1 < 0 < x2, k1 > 0
    > k2 and k1 x1 = k2 x2, so that the force is continuous. What crosses it along the axis gains
    `k1 |x1| (x2 - x1)/2`, and loses that on the way back.
    """

    external: ClassVar[bool] = True
    pauses: ClassVar[bool] = True
    is_kinked: ClassVar[bool] = True
    meaning: ClassVar[str] = (
        "a force that is linear in the place in each of two pieces, and zero beyond"
    )

    k1: Stiffness
    k2: Stiffness
    x1: Length
    x2: Length
    point: Position = (0.0, 0.0, 0.0)
    axis: Direction = (1.0, 0.0, 0.0)

    def faults(self) -> list[str]:
        """Faults of the fields: flanks that do not meet, an axis that is not a unit vector."""
        faults = []
        if not (self.x1 < 0 < self.x2 and self.k1 > 0 > self.k2):
            faults.append(
                f"x1, x2, k1, k2 are {self.x1}, {self.x2}, {self.k1}, {self.k2}, expected x1 < 0 <"
                " x2 and k1 > 0 > k2"
            )
        elif abs(self.k1 * self.x1 - self.k2 * self.x2) > 1e-12 * self.k1 * -self.x1:
            faults.append(
                f"k1 x1 is {self.k1 * self.x1} and k2 x2 {self.k2 * self.x2}, expected the same:"
                " the force is continuous"
            )
        if abs(sum(x * x for x in self.axis) - 1) > 1e-12:
            faults.append(f"axis has length {sum(x * x for x in self.axis) ** 0.5}, expected 1")
        return faults

    def singularity(self) -> Singularity:
        """The slope of the force jumps at x1, 0 and x2."""
        return Singularity(KINK, self.kind)

    def force(self, t: float, mass: float, r: Vector, v: Vector) -> Vector:
        """The force F(s) (3) [N] along the axis at s = (r - point) . axis."""
        s = vec.dot(vec.minus(r, self.point), self.axis)
        return vec.times(float(self.strength(np.array(s))), self.axis)

    def strength(self, s: Array) -> Array:
        """The force F [N] at positions s [m] along the axis, both of any shape: k1 (s - x1) from x1
        to 0, k2 (s - x2) from 0 to x2, else 0.
        """
        # max(s - x1, 0) is 0 before x1, and min(s - x2, 0) is 0 beyond x2.
        rising = self.k1 * np.maximum(s - self.x1, 0.0)
        falling = self.k2 * np.minimum(s - self.x2, 0.0)
        return np.where(s <= 0, rising, falling)

    def potential(self, scene: Any, position: Array, attitude: Array) -> Array:
        """The potential energy `-integral F` of every body (T,) [J]."""
        s = (position - np.asarray(self.point)) @ np.asarray(self.axis)
        # Work of the force from x1 on: k1 (s - x1)^2/2, then k2 ((s - x2)^2 - x2^2)/2 more.
        from_x1 = np.clip(s, self.x1, 0.0) - self.x1
        from_x2 = np.clip(s, 0.0, self.x2) - self.x2
        work = 0.5 * self.k1 * from_x1**2 + 0.5 * self.k2 * (from_x2**2 - self.x2**2)
        energy: Array = -np.sum(np.where(scene.bodies.fixed, 0.0, work), axis=-1)
        return energy
