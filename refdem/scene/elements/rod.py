"""A rigid, massless rod: a constraint that keeps two anchors at a fixed distance."""

from typing import ClassVar

from refdem.scene.dimension import Length
from refdem.scene.element import Link


class Rod(Link, frozen=True, kw_only=True, tag="rod"):
    """Keeps the anchors `length` [m] apart; positive rod force is tension."""

    acts_along_line: ClassVar[bool] = True
    meaning: ClassVar[str] = "two anchors at a fixed distance"

    length: Length

    @property
    def external(self) -> bool:  # type: ignore[override]
        """A rod hung from the world pulls from outside."""
        return self.b < 0

    def features(self) -> frozenset[str]:
        """The features of a rod, which is a constraint."""
        return frozenset({"rod", "constraint"})

    def faults(self) -> list[str]:
        """A rod without length fixes no direction."""
        if self.length > 0:
            return []
        return [f"length is {self.length}, expected > 0"]
