"""A uniform field of gravity."""

from typing import Any, ClassVar

import numpy as np

from refdem.scene.dimension import Acceleration
from refdem.scene.element import Array, Element


class UniformGravity(Element, frozen=True, kw_only=True, tag="uniform_gravity"):
    """Acceleration `g` [m/s**2] of every body that is not fixed; potential zero at the origin."""

    external: ClassVar[bool] = True

    g: Acceleration

    def potential(self, scene: Any, position: Array, attitude: Array) -> Array:
        """The potential energy `-sum m g.r` (T,) [J]."""
        energy: Array = -np.einsum("n,tnk,k->t", scene.bodies.mass, position, np.asarray(self.g))
        return energy
