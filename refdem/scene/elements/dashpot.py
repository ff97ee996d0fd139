"""A dashpot between two anchors, or in a fluid at rest: its force opposes their relative
velocity.
"""

from typing import Annotated, ClassVar

import numpy as np

from refdem.mechanics import vectors as vec
from refdem.mechanics.vectors import Vector
from refdem.scene.dimension import Damping, Dimension
from refdem.scene.element import Array, Link


class Dashpot(Link, frozen=True, kw_only=True, tag="dashpot"):
    """Force `-(damping + van_der_pol d**2) w` on a, d [m] being the distance of the anchors and w
    [m/s] the velocity of a against b.

    damping [N s/m], van_der_pol [N s/m**3]; either may be negative: then the dashpot brings energy
    in. It resists in all directions alike, as a fluid does, so that nothing is singular where the
    anchors meet.
    """

    has_force: ClassVar[bool] = True
    reads_velocity: ClassVar[bool] = True
    resists: ClassVar[bool] = True
    meaning: ClassVar[str] = "a force against the velocity of one anchor towards the other"

    damping: Damping = 0.0
    van_der_pol: Annotated[float, Dimension(1, -2, -1)] = 0.0

    @property
    def conservative(self) -> bool:  # type: ignore[override]
        """True only for a dashpot without force: any other changes the energy."""
        return self.damping == 0 and self.van_der_pol == 0

    @property
    def drives(self) -> bool:  # type: ignore[override]
        """A coefficient below zero brings energy in."""
        return self.damping < 0 or self.van_der_pol < 0

    @property
    def external(self) -> bool:  # type: ignore[override]
        """A dashpot to the world acts from outside."""
        return self.b < 0

    def features(self) -> frozenset[str]:
        """The kind, and that its damping depends on the place where it does."""
        names = {"dashpot"}
        if self.van_der_pol:
            names.add("dashpot:van_der_pol")
        return frozenset(names)

    def force(self, t: float, d: Vector, w: Vector) -> Vector:
        """F = -(damping + van_der_pol d^2) w (3) [N]."""
        return vec.times(-(self.damping + self.van_der_pol * vec.dot(d, d)), w)

    def power(self, t: Array, position: Array, velocity: Array) -> Array | None:
        """P = -(damping + van_der_pol d^2) |w|^2 (T,) [W]; None for anchors off the centres."""
        if not self.has_central_anchors():
            return None
        # The anchors are the centres, so that attitudes do not matter: they are all (1, 0, 0, 0).
        unturned = np.zeros((len(t), position.shape[1], 4))
        unturned[..., 0] = 1.0
        distance = self.distance(position, unturned)
        relative = self.relative_velocity(velocity)
        coefficient = self.damping + self.van_der_pol * distance**2
        power: Array = -coefficient * np.sum(relative**2, axis=-1)
        return power
