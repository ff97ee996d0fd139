"""A gas of many spheres, and the base class of the codes that move it."""

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from refdem.core.case import Instance
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.periodic_box import PeriodicBox
from refdem.scene.elements.plane import Plane

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Gas:
    """An instance of granular-gas in numbers, and the step [s]: `size` [m] is the edge of the cube,
    periodic or with walls.
    """

    instance: Instance
    step: float

    @property
    def position(self) -> Array:
        """The places (N, 3) [m] of the centres at the start."""
        return self.instance.scene.bodies.position

    @property
    def velocity(self) -> Array:
        """The velocities (N, 3) [m/s] at the start."""
        return self.instance.scene.bodies.velocity

    @property
    def diameter(self) -> float:
        """The diameter [m] of the spheres, which are all alike."""
        return 2 * float(self.instance.scene.bodies.radius[0])

    @property
    def mass(self) -> float:
        """The mass [kg] of one sphere of the gas."""
        return float(self.instance.scene.bodies.mass[0])

    @property
    def law(self) -> Contact:
        """The law of contact between the spheres."""
        return self.instance.scene.all(Contact)[0]

    @property
    def periodic(self) -> bool:
        """Whether there are no walls."""
        return bool(self.instance.scene.all(PeriodicBox))

    @property
    def size(self) -> float:
        """The edge [m] of the cube, which has a corner at the origin where it has walls."""
        boxes = self.instance.scene.all(PeriodicBox)
        if boxes:
            return boxes[0].size
        return max(plane.point[0] for plane in self.instance.scene.all(Plane))


class Crowd(ABC):
    """One code. `note` describes its gas if that is not the same one, or what it leaves out."""

    name: str
    note: str = ""
    is_reference = False

    @abstractmethod
    def missing(self) -> str | None:
        """None if the code is installed, else what to install."""

    @abstractmethod
    def unsupported(self, gas: Gas) -> str | None:
        """None if it can move this gas, else why not."""

    @abstractmethod
    def seconds(self, gas: Gas, steps: int) -> float:
        """Seconds of `steps` steps in the code's own loop, from the start, without the set-up."""
