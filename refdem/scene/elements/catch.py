"""A hook that catches what passes: from closest approach on, the body keeps its distance."""

from typing import ClassVar

from refdem.scene.dimension import Length
from refdem.scene.element import Link
from refdem.scene.singularity import JUMP, Singularity


class Catch(Link, frozen=True, kw_only=True, tag="catch"):
    """Joins the anchors, when they come closest, by a rod of that length, if they are then within
    `radius` [m] of each other.

    At closest approach nothing moves along the line between the anchors, so that catching does no
    work and exerts no impulse.
    """

    acts_along_line: ClassVar[bool] = True
    pauses: ClassVar[bool] = True
    switches: ClassVar[bool] = True
    is_kinked: ClassVar[bool] = True
    meaning: ClassVar[str] = "a mass that flies past a point is caught by a rod when it is closest"

    radius: Length

    @property
    def external(self) -> bool:  # type: ignore[override]
        """A hook of the world pulls from outside."""
        return self.b < 0

    def features(self) -> frozenset[str]:
        """The feature `catch`: a constraint that begins at an event."""
        return frozenset({"catch", "constraint"})

    def singularity(self) -> Singularity:
        """The force of the rod jumps where the body is caught."""
        return Singularity(JUMP, self.kind)

    def faults(self) -> list[str]:
        """Faults of the fields: a radius within which nothing is caught."""
        if self.radius > 0:
            return []
        return [f"radius is {self.radius}, expected > 0"]
