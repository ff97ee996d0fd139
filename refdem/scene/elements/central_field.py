"""A central field: Newton's attraction towards a fixed point."""

from typing import Any, ClassVar

import numpy as np

from refdem.mechanics import vectors as vec
from refdem.mechanics.vectors import Vector
from refdem.scene.dimension import GravityParameter
from refdem.scene.element import Array, Field


class CentralField(Field, frozen=True, kw_only=True, tag="central_field"):
    """Acceleration `-gm r / |r|**3` of every body towards the origin; gm [m**3/s**2]; potential
    zero at infinity.
    """

    external: ClassVar[bool] = True
    meaning: ClassVar[str] = "acceleration -gm r/|r|^3 towards the origin"

    gm: GravityParameter

    def faults(self) -> list[str]:
        """Faults of the fields: a field that repels is not Newton's."""
        if self.gm > 0:
            return []
        return [f"gm is {self.gm}, expected > 0"]

    def torque_reason(self) -> None:
        """None: the force points to the origin, so that r x F = 0."""

    def breaks(self, symmetry: str) -> str | None:
        """The origin is a place of its own, at rest."""
        if symmetry in ("shifted", "boosted"):
            return "the central field fixes an origin"
        return None

    def force(self, t: float, mass: float, r: Vector, v: Vector) -> Vector:
        """F = -gm m r/|r|^3 (3) [N]."""
        distance = vec.size(r)
        return vec.times(-mass * self.gm / (distance * distance * distance), r)

    def potential(self, scene: Any, position: Array, attitude: Array) -> Array:
        """The potential energy `-gm sum m/|r|` (T,) [J]."""
        # V = -gm sum m/|r|. For a body that an engine puts into the centre it is infinite, and the
        # check of the energy fails.
        distance = np.linalg.norm(position, axis=-1)
        with np.errstate(divide="ignore"):
            energy: Array = -self.gm * np.sum(scene.bodies.mass / distance, axis=-1)
        return energy
