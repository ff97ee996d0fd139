"""A periodic force along an axis: `amplitude cos(frequency t + phase)`, t being the time of the
scene.
"""

from math import cos
from typing import ClassVar, Self

import msgspec
import numpy as np

from refdem.mechanics import vectors as vec
from refdem.mechanics.vectors import Vector
from refdem.scene import dimension
from refdem.scene.dimension import Direction, Frequency, Number
from refdem.scene.element import Array, Link


class Force(Link, frozen=True, kw_only=True, tag="force"):
    """Pushes `a` with `amplitude` [N] `* cos(frequency t + phase)` along `axis` (unit, world axes),
    and b the other way.

    `frequency` is angular [rad/s]; t counts from the scene's own zero of time, not from the first
    sample.
    """

    conservative: ClassVar[bool] = False
    drives: ClassVar[bool] = True
    reads_clock: ClassVar[bool] = True
    has_force: ClassVar[bool] = True
    meaning: ClassVar[str] = "a force that oscillates in time"

    amplitude: dimension.Force
    frequency: Frequency = 0.0
    phase: Number = 0.0
    axis: Direction = (1.0, 0.0, 0.0)

    @property
    def external(self) -> bool:  # type: ignore[override]
        """True without a body b, on which the opposite force would act."""
        return self.b < 0

    def faults(self) -> list[str]:
        """Faults of the fields: an axis that is not a unit vector, a frequency below zero."""
        faults = []
        if not self.frequency >= 0:
            faults.append(f"frequency is {self.frequency}, expected >= 0")
        square = sum(x * x for x in self.axis)
        if not abs(square - 1) < 1e-12:
            faults.append(f"axis has length {square**0.5}, expected 1")
        return faults

    def delayed(self, delay: float) -> Self:
        """The same force for a motion begun `delay` [s] later: cos(w (t - delay) + phase)."""
        if delay:
            return msgspec.structs.replace(self, phase=self.phase - self.frequency * delay)
        return self

    def force(self, t: float, d: Vector, w: Vector) -> Vector:
        """F = amplitude cos(frequency t + phase) axis (3) [N]."""
        strength = self.amplitude * cos(self.frequency * t + self.phase)
        return vec.times(strength, self.axis)

    def strength(self, t: Array) -> Array:
        """The force along the axis (T,) [N] at times t (T,) [s]."""
        strength: Array = self.amplitude * np.cos(self.frequency * t + self.phase)
        return strength

    def power(self, t: Array, position: Array, velocity: Array) -> Array | None:
        """P = F(t) axis . (v_a - v_b) (T,) [W]; None for a force on a place off the centre."""
        if not self.has_central_anchors():
            return None
        along = self.relative_velocity(velocity) @ np.array(self.axis)
        power: Array = self.strength(t) * along
        return power
