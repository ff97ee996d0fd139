"""A ball joint: two anchors coincide, and the bodies rotate freely about them."""

from typing import ClassVar

from refdem.scene.element import Link


class BallJoint(Link, frozen=True, kw_only=True, tag="ball_joint"):
    """Keeps `anchor_a` of body `a` where `anchor_b` of body `b`, or of the world, is; free of
    friction.
    """

    acts_along_line: ClassVar[bool] = True
    meaning: ClassVar[str] = "a point of one body is held at a point of another, or of the world"

    @property
    def external(self) -> bool:  # type: ignore[override]
        """A joint to the world holds from outside."""
        return self.b < 0

    def features(self) -> frozenset[str]:
        """The features of a ball joint, which is a constraint."""
        return frozenset({"ball_joint", "constraint"})
