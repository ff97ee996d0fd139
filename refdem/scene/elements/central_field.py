"""A central field: Newton's attraction towards a fixed point."""

from typing import Any, ClassVar

import numpy as np

from refdem.scene.dimension import GravityParameter
from refdem.scene.element import Array, Element


class CentralField(Element, frozen=True, kw_only=True, tag="central_field"):
    """Acceleration `-gm r / |r|**3` of every body towards the origin; gm [m**3/s**2]; potential
    zero at infinity.
    """

    external: ClassVar[bool] = True

    gm: GravityParameter

    def faults(self) -> list[str]:
        """Faults of the fields: a field that repels is not Newton's."""
        if self.gm > 0:
            return []
        return [f"gm is {self.gm}, expected > 0"]

    def potential(self, scene: Any, position: Array, attitude: Array) -> Array:
        """The potential energy `-gm sum m/|r|` (T,) [J]."""
        distance = np.linalg.norm(position, axis=-1)
        # A body that a code puts into the centre has no finite energy, and so fails.
        with np.errstate(divide="ignore"):
            energy: Array = -self.gm * np.sum(scene.bodies.mass / distance, axis=-1)
        return energy
