"""A uniform field of gravity."""

from typing import Any, ClassVar

import numpy as np

from refdem.mechanics import vectors as vec
from refdem.mechanics.vectors import Vector
from refdem.scene.dimension import Acceleration
from refdem.scene.element import Array, Field


class UniformGravity(Field, frozen=True, kw_only=True, tag="uniform_gravity"):
    """Acceleration `g` [m/s**2] of every body that is not fixed; potential zero at the origin."""

    external: ClassVar[bool] = True
    pauses: ClassVar[bool] = True
    meaning: ClassVar[str] = "an acceleration that is the same everywhere"

    g: Acceleration

    def breaks(self, symmetry: str) -> None:
        """None: the field is the same everywhere and at every velocity."""

    def has_arbitrary_zero(self) -> bool:
        """True: a weight's potential is zero at the origin of space, wherever the body is."""
        return True

    def force(self, t: float, mass: float, r: Vector, v: Vector) -> Vector:
        """The weight F = m g (3) [N]."""
        return vec.times(mass, self.g)

    def potential(self, scene: Any, position: Array, attitude: Array) -> Array:
        """The potential energy `-sum m g.r` (T,) [J]."""
        energy: Array = -np.einsum("n,tnk,k->t", scene.bodies.mass, position, np.asarray(self.g))
        return energy
