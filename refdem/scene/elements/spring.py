"""A spring along the line between two anchors: a power law of the stretch = distance - length, and
its square and cube.
"""

from typing import Annotated, Any

import numpy as np

from refdem.scene.dimension import Dimension, Length, Number, Stiffness
from refdem.scene.element import Array, Link


class Spring(Link, frozen=True, kw_only=True, tag="spring"):
    """Pulls the anchors together with `stiffness |s|**exponent sgn s + quadratic s**2 + cubic
    s**3`, s = distance - length [m].

    stiffness [N/m**exponent], quadratic [N/m**2], cubic [N/m**3], each of any sign; potential zero
    at the distance `length`.
    """

    stiffness: Stiffness
    length: Length = 0.0
    exponent: Number = 1.0
    quadratic: Annotated[float, Dimension(1, -1, -2)] = 0.0
    cubic: Annotated[float, Dimension(1, -2, -2)] = 0.0

    @property
    def external(self) -> bool:  # type: ignore[override]
        """A spring to the world pushes the bodies from outside."""
        return self.b < 0

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

    def pull(self, stretch: Array) -> Array:
        """Force [N] that pulls the ends together at a stretch [m], both of any shape."""
        # k sgn(s) |s|^n + a s^2 + b s^3.
        s = np.asarray(stretch, float)
        power = self.stiffness * np.sign(s) * np.abs(s) ** self.exponent
        pull: Array = power + (self.quadratic + self.cubic * s) * s * s
        return pull

    def potential_size(self, position: Array, attitude: Array) -> Array:
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
        s = self.distance(position, attitude) - self.length
        power = self.exponent + 1
        energy: Array = self.stiffness * np.abs(s) ** power / power
        if self.quadratic or self.cubic:
            energy = energy + (self.quadratic / 3 + self.cubic * s / 4) * s**3
        return energy
