"""Dry friction along an axis: `Sgn(0) = [-1, 1]`, so a body at rest under no more than the limit stays at rest."""

from typing import ClassVar

from refdem.scene.dimension import Direction, Force, Number
from refdem.scene.element import Link


class Slider(Link, frozen=True, kw_only=True, tag="slider"):
    """Coulomb force of size `friction * normal_force` [N] against the relative velocity along `axis` (unit, world axes)."""

    conservative: ClassVar[bool] = False

    friction: Number
    normal_force: Force
    axis: Direction = (1.0, 0.0, 0.0)

    @property
    def external(self) -> bool:  # type: ignore[override]
        """Friction against the world acts from outside."""
        return self.b < 0

    def features(self) -> frozenset[str]:
        """Dry friction is a feature of its own: it lowers the order of most methods."""
        return frozenset({"slider", "friction"})

    def faults(self) -> list[str]:
        """A negative coefficient or normal force."""
        return [f"{name} is {value}, expected >= 0" for name in ("friction", "normal_force") if (value := getattr(self, name)) < 0]
