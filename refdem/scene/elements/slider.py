"""Dry friction along an axis: `Sgn(0) = [-1, 1]`, so a body at rest under no more than the limit
stays at rest.
"""

from typing import Annotated, Any, ClassVar, Literal

from refdem.scene.dimension import Dimension, Direction, Force, Number
from refdem.scene.element import Link
from refdem.scene.singularity import JUMP, Singularity

SpeedInverse = Annotated[float, Dimension(0, -1, 1)]
SpeedsInverse = Annotated[float, Dimension(0, -2, 2)]
Speed = Annotated[float, Dimension(0, 1, -1)]


class Slider(Link, frozen=True, kw_only=True, tag="slider"):
    """Friction of size `coefficient(|u|) normal_force` [N] against u, the velocity along `axis`
    (unit, world axes) less that of the belt.

    coulomb: the coefficient is `friction`, whatever the speed. stribeck: `(mu0 - mu1)/(1 + lambda0
    |u|) + mu1 + lambda1 |u|**2`, or with |u| in the last term (stribeck_linear); lambda0 [s/m],
    lambda1 [s**2/m**2] or [s/m]. At u = 0 it holds up to the coefficient of zero speed.
    `belt_velocity` [m/s] is that of what it rubs on, along the axis.
    """

    conservative: ClassVar[bool] = False
    rubs: ClassVar[bool] = True
    switches: ClassVar[bool] = True
    is_kinked: ClassVar[bool] = True
    meaning: ClassVar[str] = "dry friction of a body along an axis, under a given normal force"

    friction: Number = 0.0
    normal_force: Force
    axis: Direction = (1.0, 0.0, 0.0)
    law: Literal["coulomb", "stribeck", "stribeck_linear"] = "coulomb"
    mu0: Number = 0.0
    mu1: Number = 0.0
    lambda0: SpeedInverse = 0.0
    lambda1: SpeedsInverse = 0.0
    belt_velocity: Speed = 0.0

    @property
    def external(self) -> bool:  # type: ignore[override]
        """Friction against the world acts from outside."""
        return self.b < 0

    @property
    def drives(self) -> bool:  # type: ignore[override]
        """True if the belt moves and so does work."""
        return self.belt_velocity != 0

    @property
    def is_plain(self) -> bool:
        """Coulomb's law on a ground that does not move."""
        return self.law == "coulomb" and self.belt_velocity == 0

    def dimension(self, field: str) -> Dimension | None:
        """The dimension of a field; that of `lambda1` follows from the law."""
        if field == "lambda1" and self.law == "stribeck_linear":
            return Dimension(0, -1, 1)
        return super().dimension(field)

    def features(self) -> frozenset[str]:
        """The features of dry friction; `friction` is one of its own because it lowers the order of
        most methods.
        """
        names = {"slider", "friction"}
        if self.law != "coulomb":
            names.add("slider:stribeck")
        if self.belt_velocity:
            names.add("slider:belt")
        return frozenset(names)

    def singularity(self) -> Singularity:
        """Dry friction jumps where the slip changes its sign."""
        return Singularity(JUMP, "friction")

    def faults(self) -> list[str]:
        """Faults of the fields: a negative coefficient or normal force."""
        names = ("friction", "normal_force", "mu0", "mu1", "lambda0", "lambda1")
        return [
            f"{name} is {value}, expected >= 0"
            for name in names
            if (value := getattr(self, name)) < 0
        ]

    def coefficient(self, speed: Any) -> Any:
        """Friction force over normal force at a speed |u| >= 0 [m/s].

        Coulomb: `friction`. Stribeck: (mu0 - mu1)/(1 + lambda0 |u|) + mu1 + lambda1 u^2, or lambda1
        |u| for the last term (stribeck_linear).
        """
        if self.law == "coulomb":
            return self.friction
        if self.law == "stribeck":
            rising = speed * speed
        else:
            rising = speed
        falling = (self.mu0 - self.mu1) / (1 + self.lambda0 * speed)
        return falling + self.mu1 + self.lambda1 * rising
