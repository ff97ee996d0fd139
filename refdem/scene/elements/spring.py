"""A spring along the line between two anchors: a power law of the stretch = distance - length, and
its square and cube.
"""

from typing import Annotated, Any, ClassVar

import numpy as np

from refdem.mechanics import vectors as vec
from refdem.mechanics.vectors import Vector
from refdem.scene.dimension import Dimension, Length, Number, Stiffness
from refdem.scene.element import Array, Link
from refdem.scene.singularity import Singularity


class Spring(Link, frozen=True, kw_only=True, tag="spring"):
    """Pulls the anchors together with `stiffness |s|**exponent sgn s + quadratic s**2 + cubic
    s**3`, s = distance - length [m].

    stiffness [N/m**exponent], quadratic [N/m**2], cubic [N/m**3], each of any sign; potential zero
    at the distance `length`.
    """

    has_force: ClassVar[bool] = True
    acts_along_line: ClassVar[bool] = True
    meaning: ClassVar[str] = "a force along the line of two anchors, proportional to the stretch"

    stiffness: Stiffness
    length: Length = 0.0
    exponent: Number = 1.0
    quadratic: Annotated[float, Dimension(1, -1, -2)] = 0.0
    cubic: Annotated[float, Dimension(1, -2, -2)] = 0.0

    @property
    def external(self) -> bool:  # type: ignore[override]
        """A spring to the world pushes the bodies from outside."""
        return self.b < 0

    @property
    def is_kinked(self) -> bool:  # type: ignore[override]
        """A power of the stretch other than 1 is not smooth where the spring is at rest."""
        return self.exponent != 1

    def dimension(self, field: str) -> Dimension | None:
        """The dimension of a field; `stiffness` [N/m**exponent] depends on the exponent."""
        if field == "stiffness":
            return Dimension(1, 1 - self.exponent, -2)
        return super().dimension(field)

    def features(self) -> frozenset[str]:
        """The kind, and what makes its force other than proportional to the stretch."""
        laws = {
            "spring:exponent": self.exponent != 1,
            "spring:quadratic": self.quadratic != 0,
            "spring:cubic": self.cubic != 0,
        }
        present = [name for name, is_present in laws.items() if is_present]
        return frozenset({"spring", *present})

    def faults(self) -> list[str]:
        """Faults of the fields: a negative length, an exponent that is not > 0."""
        faults = []
        if self.length < 0:
            faults.append(f"length is {self.length}, expected >= 0")
        if self.exponent <= 0:
            faults.append(f"exponent is {self.exponent}, expected > 0")
        return faults

    def singularity(self) -> Singularity | None:
        """|s|^n sgn s has no Taylor series at s = 0 unless n is odd."""
        if self.stiffness == 0 or self.exponent % 2 == 1:
            return None
        return Singularity(self.exponent, "spring:exponent")

    def has_arbitrary_zero(self) -> bool:
        """True for a spring that repels: its potential is zero on top of a hill."""
        return self.stiffness < 0

    def force(self, t: float, d: Vector, w: Vector) -> Vector:
        """F = -pull(|d| - length) d/|d| (3) [N]; zero where the ends meet."""
        is_linear = self.exponent == 1 and not (self.quadratic or self.cubic)
        if is_linear and self.length == 0:
            return vec.times(-self.stiffness, d)
        # -pull(s)/|d| d, with s = |d| - length.
        distance = vec.size(d)
        if distance > 0:
            return vec.times(-self.pull(distance - self.length) / distance, d)
        return vec.ZERO

    def pull(self, stretch: Any) -> Any:
        """Force [N] that pulls the ends together at a stretch [m], both of any shape."""
        # k sgn(s) |s|^n + a s^2 + b s^3.
        s = stretch
        power = self.stiffness * abs(s) ** self.exponent * np.copysign(1.0, s)
        return power + (self.quadratic + self.cubic * s) * s * s

    def potential_terms(self, position: Array, attitude: Array) -> Array:
        """The sum (T,) [J] of the absolute terms of the potential, to which its rounding is
        relative.

        With s the absolute stretch: |k| s^(n+1)/(n+1) + |a| s^3/3 + |b| s^4/4.
        """
        s = np.abs(self.distance(position, attitude) - self.length)
        total: Array = abs(self.stiffness) * s ** (self.exponent + 1) / (self.exponent + 1)
        total += (abs(self.quadratic) / 3 + abs(self.cubic) * s / 4) * s**3
        return total

    def potential(self, scene: Any, position: Array, attitude: Array) -> Array:
        """`stiffness |s|**(exponent+1) / (exponent+1) + quadratic s**3 / 3 + cubic s**4 / 4` (T,)
        [J].
        """
        # V = k |s|^(n+1)/(n+1) + a s^3/3 + b s^4/4.
        s = self.distance(position, attitude) - self.length
        power = self.exponent + 1
        energy: Array = self.stiffness * np.abs(s) ** power / power
        if self.quadratic or self.cubic:
            energy = energy + (self.quadratic / 3 + self.cubic * s / 4) * s**3
        return energy
