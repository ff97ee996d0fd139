"""A wall and particles that are wedges: edge first they are pressed back otherwise than flat side
first, and they turn when they stop.
"""

from typing import Annotated, Any, ClassVar

import numpy as np

from refdem.mechanics.quaternion import rotated
from refdem.scene.dimension import Dimension, Direction, Position, Stiffness
from refdem.scene.element import Array, Element
from refdem.scene.singularity import JUMP, Singularity


class Wedge(Element, frozen=True, kw_only=True, tag="wedge"):
    """Presses bodies that have passed `point` against `normal` by d [m] back along the normal, by
    their orientation.

    Edge first (the body's y axis looks at the wall) with `quadratic d**2` [N/m^2], flat side first
    with `stiffness d` [N/m]. Where a body that presses comes to a stop it turns by pi about its z
    axis, at once: the force depends on place and orientation, never on the velocity. Run back, it
    comes in with the law with which it went out. Potential zero at the wall.
    """

    conservative: ClassVar[bool] = False
    external: ClassVar[bool] = True
    drives: ClassVar[bool] = True
    pauses: ClassVar[bool] = True
    switches: ClassVar[bool] = True
    is_kinked: ClassVar[bool] = True
    meaning: ClassVar[str] = (
        "presses bodies that have passed a point, by the side that they turn to it"
    )

    quadratic: Annotated[float, Dimension(1, -1, -2)]
    stiffness: Stiffness
    point: Position = (0.0, 0.0, 0.0)
    normal: Direction = (-1.0, 0.0, 0.0)

    @property
    def reversible(self) -> bool:
        """True: the force depends on place and orientation, not on the direction of time."""
        return True

    def singularity(self) -> Singularity:
        """The force jumps where a body that presses turns."""
        return Singularity(JUMP, self.kind)

    def faults(self) -> list[str]:
        """Faults of the fields: forces that do not press, a normal that is not a unit vector."""
        faults = [
            f"{name} is {value}, expected > 0"
            for name in ("quadratic", "stiffness")
            if not (value := getattr(self, name)) > 0
        ]
        square = sum(x * x for x in self.normal)
        if not abs(square - 1) < 1e-12:
            faults.append(f"normal has length {square**0.5}, expected 1")
        return faults

    def overlap(self, position: Array) -> Array:
        """The overlap d (...) [m] with the wall at position (..., 3) [m], negative in front of
        it.
        """
        # d = (point - r).n, as the normal points to the bodies.
        depth: Array = (np.asarray(self.point) - position) @ np.asarray(self.normal)
        return depth

    def edge_first(self, attitude: Array) -> Array:
        """True (...) where the edge points to the wall, for attitude (..., 4)."""
        # The edge points along y in body axes.
        y_axis = np.array([0.0, 1.0, 0.0])
        edge = rotated(attitude, np.broadcast_to(y_axis, (*attitude.shape[:-1], 3)))
        points_to_wall: Array = edge @ np.asarray(self.normal) < 0
        return points_to_wall

    def potential(self, scene: Any, position: Array, attitude: Array) -> Array:
        """`quadratic d**3 / 3` or `stiffness d**2 / 2` of every body that presses (T,) [J]."""
        d = np.maximum(self.overlap(position), 0.0)
        of_edge = self.quadratic * d**3 / 3
        of_side = self.stiffness * d**2 / 2
        energy = np.where(self.edge_first(attitude), of_edge, of_side)
        total: Array = np.sum(energy * ~scene.bodies.fixed, axis=-1)
        return total
