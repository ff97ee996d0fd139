"""An anchor that is moved by a law of time: it carries a body along a straight line to and fro,
whatever pulls at it.
"""

from typing import ClassVar, Self

import msgspec
import numpy as np

from refdem.scene.dimension import Direction, Frequency, Length, Number
from refdem.scene.element import Array, Link


class MovingAnchor(Link, frozen=True, kw_only=True, tag="moving_anchor"):
    """Keeps `a` at `anchor_b + amplitude cos(frequency t + phase) axis` (axis: unit, world axes), t
    being the time of the scene.

    amplitude [m] of either sign, `frequency` angular [rad/s]. What is joined to `a` hangs from a
    pivot that no force moves.
    """

    conservative: ClassVar[bool] = False
    external: ClassVar[bool] = True
    drives: ClassVar[bool] = True
    reads_clock: ClassVar[bool] = True
    meaning: ClassVar[str] = "a body that is moved along a line as a cosine of time"

    amplitude: Length
    frequency: Frequency
    phase: Number = 0.0
    axis: Direction = (1.0, 0.0, 0.0)

    def features(self) -> frozenset[str]:
        """A place that is prescribed is a constraint."""
        return frozenset({"moving_anchor", "constraint"})

    def faults(self) -> list[str]:
        """Faults of the fields: an end that is not the world's, an anchor off the body's centre, an
        axis that is not a unit vector, a frequency below zero.
        """
        faults = []
        if not self.b < 0:
            faults.append(f"b is {self.b}, expected -1: a law of time is one of the world")
        if any(self.anchor_a):
            faults.append(
                f"anchor_a is {self.anchor_a}, expected zeros: the centre of the body is carried"
            )
        if not self.frequency >= 0:
            faults.append(f"frequency is {self.frequency}, expected >= 0")
        square = sum(x * x for x in self.axis)
        if not abs(square - 1) < 1e-12:
            faults.append(f"axis has length {square**0.5}, expected 1")
        return faults

    def delayed(self, delay: float) -> Self:
        """The same anchor for a motion begun `delay` [s] later: cos(w (t - delay) + phase)."""
        if not delay:
            return self
        return msgspec.structs.replace(self, phase=self.phase - self.frequency * delay)

    def place(self, t: Array) -> Array:
        """The position (T, 3) [m] of the body at times t (T,) [s]: anchor + A cos(w t + phase)
        axis.
        """
        cosine = np.cos(self.frequency * t + self.phase)
        displacement = self.amplitude * cosine[:, None] * np.array(self.axis)
        position: Array = np.array(self.anchor_b) + displacement
        return position

    def velocity(self, t: Array) -> Array:
        """The velocity of the body (T, 3) [m/s] at times t (T,) [s]: -A w sin(w t + phase) axis."""
        sine = np.sin(self.frequency * t + self.phase)
        factor = -self.amplitude * self.frequency
        velocity: Array = factor * sine[:, None] * np.array(self.axis)
        return velocity
