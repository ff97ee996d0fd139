"""A spring along the line between two anchors: force `stiffness * |stretch|**exponent`, stretch = distance - length."""

from typing import Any

import numpy as np

from refdem.scene.dimension import Dimension, Length, Number, Stiffness
from refdem.scene.element import Array, Link


class Spring(Link, frozen=True, kw_only=True, tag="spring"):
    """Pulls the anchors to the distance `length` [m]; stiffness [N/m**exponent]; potential zero at that distance."""

    stiffness: Stiffness
    length: Length = 0.0
    exponent: Number = 1.0

    @property
    def external(self) -> bool:  # type: ignore[override]
        """A spring to the world pushes the bodies from outside."""
        return self.b < 0

    def dimension(self, field: str) -> Dimension | None:
        """That of `stiffness` [N/m**exponent] follows from the exponent."""
        return Dimension(1, 1 - self.exponent, -2) if field == "stiffness" else super().dimension(field)

    def faults(self) -> list[str]:
        """Negative length or an exponent that makes no restoring force."""
        found = []
        if self.length < 0:
            found.append(f"length is {self.length}, expected >= 0")
        if self.exponent <= 0:
            found.append(f"exponent is {self.exponent}, expected > 0")
        return found

    def potential(self, scene: Any, position: Array, attitude: Array) -> Array:
        """`stiffness |stretch|**(exponent+1) / (exponent+1)` (T,) [J]."""
        stretch = np.abs(self.distance(position, attitude) - self.length)
        return self.stiffness * stretch ** (self.exponent + 1) / (self.exponent + 1)
