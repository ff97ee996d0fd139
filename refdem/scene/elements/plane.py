"""A fixed half space: everything behind `point` against `normal` is solid."""

from typing import ClassVar

from refdem.scene.dimension import Direction, Position
from refdem.scene.element import Element


class Plane(Element, frozen=True, kw_only=True, tag="plane"):
    """A wall through `point` [m] whose unit `normal` looks at the bodies."""

    external: ClassVar[bool] = True
    pauses: ClassVar[bool] = True
    meaning: ClassVar[str] = "a wall"

    point: Position = (0.0, 0.0, 0.0)
    normal: Direction = (0.0, 0.0, 1.0)

    def faults(self) -> list[str]:
        """Faults of the fields: a normal that is not a unit vector."""
        square = sum(x * x for x in self.normal)
        if abs(square - 1) < 1e-12:
            return []
        return [f"normal has length {square**0.5}, expected 1"]
