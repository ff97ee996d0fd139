"""A string that runs over a wheel: one body swings on one side, another hangs straight down on the
other (fig. 1.3b).
"""

from typing import Annotated, Any, ClassVar

import numpy as np

from refdem.scene.dimension import Dimension, Length, Position
from refdem.scene.element import Array, Element


class StringOverWheel(Element, frozen=True, kw_only=True, tag="string_over_wheel"):
    """Body `a` swings in a plane with gravity, body `b` moves along gravity on the other side; the
    taut string does not slip.

    The string leaves the wheel (`radius` [m] >= 0, `inertia` [kg m^2] about its axle at `centre`)
    at its tangents; its length is what the start has. Wheel and string hold no potential energy;
    the wheel turns at u/radius, u being the speed of the string.
    """

    external: ClassVar[bool] = True
    meaning: ClassVar[str] = "two masses on a string over a wheel, of which one swings"

    a: int
    b: int
    centre: Position = (0.0, 0.0, 0.0)
    radius: Length = 0.0
    inertia: Annotated[float, Dimension(1, 2, 0)] = 0.0

    def features(self) -> frozenset[str]:
        """The features of a string, which is a constraint."""
        return frozenset({"string_over_wheel", "constraint"})

    def faults(self) -> list[str]:
        """Faults of the fields: negative sizes, a wheel of radius 0 with inertia, no body b."""
        faults = [
            f"{name} is {value}, expected >= 0"
            for name in ("radius", "inertia")
            if (value := getattr(self, name)) < 0
        ]
        if self.radius == 0 and self.inertia > 0:
            faults.append(
                f"inertia is {self.inertia} at radius 0, expected 0: a point does not turn with the"
                " string"
            )
        if self.b >= 0:
            return faults
        return [*faults, f"b is {self.b}, expected a body: the world does not hang on a string"]

    @property
    def drag(self) -> float:
        """J/R^2 [kg]: the mass that the wheel adds to the string."""
        if self.inertia:
            return self.inertia / self.radius**2
        return 0.0

    def kinetic(self, scene: Any, velocity: Array) -> Array:
        """J (u/R)^2/2 (T,) [J], u being the speed of the body that hangs straight down."""
        # J (u/R)^2/2 = drag u^2/2, with drag = J/R^2.
        energy: Array = 0.5 * self.drag * np.sum(velocity[:, self.b] ** 2, axis=-1)
        return energy
