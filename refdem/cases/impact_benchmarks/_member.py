"""What every member of the family is: its own numbers, a scene, scales, what is compared, and its
truth.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from types import SimpleNamespace
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from refdem.cases.impact_benchmarks._parameters import MATERIALS
from refdem.core.parameters import Parameters
from refdem.core.quantity import Quantity, Scales
from refdem.core.trajectory import Trajectory
from refdem.core.truth import Truth
from refdem.errors import UsageError
from refdem.scene import Scene

Array = NDArray[np.float64]
CHOSEN = ("branch", "cutoff", "material")
POSITIONS_ARE_ROUNDED = 8
"""A position near R is rounded to u R; round-off is judged as 8 u L, so that L must not be below
R/8.
"""


@dataclass(frozen=True)
class Member(ABC):
    """`numbers` has each parameter that the member takes, with its default as text; a file of the
    folder has one named MEMBER.
    """

    title: str
    numbers: Mapping[str, str]
    bodies: ClassVar[int] = 1

    def refuse(self, p: Parameters) -> None:
        """Raises UsageError for a parameter that the member does not have."""
        alien = sorted(set(p.given) - set(self.numbers) - {"member", "duration", "samples"})
        if alien:
            raise UsageError(
                f"parameter {alien[0]}: member {p['member']} has none; expected one of"
                f" {', '.join(sorted(self.numbers))}"
            )

    def written(self, p: Parameters) -> dict[str, Any]:
        """The member's own numbers as they are written: exact rationals, and names; with those of
        its material.
        """
        found: dict[str, Any] = {}
        for name, default in self.numbers.items():
            is_given = p[name] not in (None, "own")
            if is_given:
                found[name] = p[name]
            else:
                found[name] = default if name in CHOSEN else Fraction(default)
        if "material" in found:
            found |= zip(
                ("modulus", "poisson", "density"),
                map(Fraction, MATERIALS[found["material"]]),
                strict=True,
            )
        return found

    def values(self, p: Parameters) -> Any:
        """What is written, and what follows from it: the `mass` of a sphere of that `radius` and
        `density`.

        What follows is no rounded number but a Real, which truth encloses at its own precision and
        a scene rounds once.
        """
        from refdem.truth.contact_law import sphere_mass

        found = SimpleNamespace(**self.written(p))
        if hasattr(found, "density"):
            found.mass = sphere_mass(found.density, found.radius)
        return found

    @abstractmethod
    def scene(self, v: Any) -> Scene:
        """The scene of these values at its start."""

    @abstractmethod
    def scales(self, v: Any) -> Scales:
        """Length, shortest time, duration and mass."""

    @abstractmethod
    def truth(self, v: Any, scale: Mapping[str, float]) -> Truth:
        """The truth of these values, on the scales of the quantities."""

    def spin_scale(self, v: Any) -> float:
        """The largest spin at the start, or that of rolling at the speed of the start, or of the
        scales if nothing moves [rad/s].
        """
        bodies = self.scene(v).bodies
        rolling = np.linalg.norm(bodies.velocity, axis=1).max() / bodies.radius.min()
        largest = float(max(np.linalg.norm(bodies.omega, axis=1).max(), rolling))
        return largest or self.scales(v).speed / float(v.radius)

    def quantities(self, v: Any) -> tuple[Quantity, ...]:
        """Place, velocity and angular velocity of every body."""
        s = self.scales(v)
        kinds = (
            ("r", "m", s.length),
            ("v", "m/s", s.speed),
            ("omega", "rad/s", self.spin_scale(v)),
        )
        if self.bodies > 1:
            numbers = [str(i + 1) for i in range(self.bodies)]
        else:
            numbers = [""]
        found = []
        for number in numbers:
            for kind, unit, size in kinds:
                found += [Quantity(f"{kind}{number}.{axis}", unit, size) for axis in "xyz"]
        return tuple(found)

    def observe(self, v: Any, run: Trajectory) -> dict[str, Array]:
        """The quantities by name at the samples, each (T,)."""
        columns = [
            column[:, body]
            for body in range(self.bodies)
            for column in (run.position, run.velocity, run.omega)
        ]
        return dict(
            zip(
                (q.name for q in self.quantities(v)), np.concatenate(columns, axis=1).T, strict=True
            )
        )
