"""The contact law between shapes that meet: linear spring-dashpot with tangential spring and Coulomb limit, or rigid."""

from typing import Any, Literal

import numpy as np

from refdem.scene.dimension import Damping, Number, Stiffness
from refdem.scene.element import Array, Element


class Contact(Element, frozen=True, kw_only=True, tag="contact"):
    """One law for every pair of shapes in the scene, planes included.

    linear: normal force `stiffness * overlap + damping * d(overlap)/dt`; tangential spring `tangential_stiffness * slip`
    with no dashpot, clipped (spring included) at `friction` times the normal force; `tangential_stiffness = 0` with
    friction > 0 is sliding friction of full size whenever there is slip. `branch` is the lever arm of the tangential
    force: the radius R, R - overlap, or R - overlap/2. `cutoff`: the force ends with the overlap, or already when it
    would pull (zero_force). rigid: no overlap, `restitution` for the normal velocity, Coulomb friction.
    """

    law: Literal["linear", "rigid"]
    stiffness: Stiffness = 0.0
    damping: Damping = 0.0
    tangential_stiffness: Stiffness = 0.0
    friction: Number = 0.0
    restitution: Number = 0.0
    branch: Literal["R", "R-d", "R-d/2"] = "R-d/2"
    cutoff: Literal["zero_overlap", "zero_force"] = "zero_overlap"

    @property
    def conservative(self) -> bool:  # type: ignore[override]
        """Neither damping nor friction, and a rigid law that gives everything back."""
        return self.damping == 0 and self.friction == 0 and (self.law == "linear" or self.restitution == 1)

    def features(self) -> frozenset[str]:
        """The law, and friction where there is some."""
        names = {"contact", f"contact:{self.law}"}
        if self.friction > 0:
            names |= {"friction", "contact:friction"}
        if self.damping > 0:
            names.add("contact:damping")
        return frozenset(names)

    def faults(self) -> list[str]:
        """Negative coefficients, and a linear law without stiffness."""
        numbers = ("stiffness", "damping", "tangential_stiffness", "friction", "restitution")
        found = [f"{name} is {value}, expected >= 0" for name in numbers if (value := getattr(self, name)) < 0]
        if self.law == "linear" and not self.stiffness > 0:
            found.append(f"stiffness is {self.stiffness}, expected > 0 for the linear law")
        if self.restitution > 1:
            found.append(f"restitution is {self.restitution}, expected <= 1")
        return found

    def potential(self, scene: Any, position: Array, attitude: Array) -> Array:
        """`stiffness overlap**2 / 2` of every pair of spheres (T,) [J]; the tangential spring is not in it."""
        energy = np.zeros(len(position))
        if self.law != "linear":
            return energy
        radius = scene.bodies.radius
        for i, j in zip(*np.triu_indices(len(radius), 1), strict=True):
            overlap = radius[i] + radius[j] - np.linalg.norm(position[:, i] - position[:, j], axis=-1)
            energy += 0.5 * self.stiffness * np.maximum(overlap, 0.0) ** 2 * (min(radius[i], radius[j]) > 0)
        return energy
