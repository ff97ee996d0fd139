"""A member of the family of impact benchmarks: its numbers, scene, scales, quantities and truth.

`v` are the values of a member (`Member.values`, `_values.py`): the exact numbers of the member by
their names, and what follows from them.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from refdem.cases.impact_benchmarks._parameters import MATERIALS
from refdem.cases.impact_benchmarks._values import Values
from refdem.core.parameters import Parameters
from refdem.core.quantity import Quantity, Scales
from refdem.core.trajectory import Trajectory
from refdem.core.truth import Truth
from refdem.errors import UsageError
from refdem.scene import Scene

Array = NDArray[np.float64]
CHOSEN = ("branch", "cutoff", "material")
POSITIONS_ARE_ROUNDED = 8
"""R over the least length scale L: a position near R is rounded by u R, and round-off is judged as
8 u L, so that L must not be below R/8.
"""
CHOICE_OF_MEMBER = (None, "own")
"""Parameters with one of these values keep the member's own one."""


@dataclass(frozen=True)
class Member(ABC):
    """One benchmark; each file of the folder without an underscore has one, named MEMBER.

    `numbers` has each parameter that the member takes, with its default as text; `bodies` is the
    number of bodies whose motion is judged.
    """

    title: str
    numbers: Mapping[str, str]
    bodies: ClassVar[int] = 1

    def refuse(self, p: Parameters) -> None:
        """Raises UsageError for a parameter that the member does not have."""
        common = {"member", "duration", "samples"}
        foreign = sorted(set(p.given) - set(self.numbers) - common)
        if foreign:
            raise UsageError(
                f"parameter {foreign[0]}: member {p['member']} has none; expected one of"
                f" {', '.join(sorted(self.numbers))}"
            )

    def written(self, p: Parameters) -> dict[str, Any]:
        """The member's numbers by name, as exact rationals, and the words that it chooses.

        Each is the given parameter, or else the member's own; a material adds its modulus, Poisson
        ratio and density.
        """
        numbers: dict[str, Any] = {}
        for name, default in self.numbers.items():
            if p[name] not in CHOICE_OF_MEMBER:
                numbers[name] = p[name]
            elif name in CHOSEN:
                numbers[name] = default
            else:
                numbers[name] = Fraction(default)
        if "material" in numbers:
            properties = map(Fraction, MATERIALS[numbers["material"]])
            numbers |= zip(("modulus", "poisson", "density"), properties, strict=True)
        return numbers

    def written_out(self, p: Parameters) -> Parameters:
        """The parameters with the member's own numbers in place of those that are not given."""
        written = self.written(p)
        own = {}
        for name in self.numbers:
            if name not in CHOSEN and p[name] in CHOICE_OF_MEMBER:
                own[name] = written[name]
        return p.replaced(own)

    def values(self, p: Parameters) -> Values:
        """The numbers of `written`, and those that follow from them: the `mass` of the sphere.

        A number that follows is not rounded: it is a Real, which truth encloses at its own
        precision and a scene rounds once.
        """
        from refdem.truth.contact_law import sphere_mass

        v = Values(**self.written(p))
        if hasattr(v, "density"):
            v.mass = sphere_mass(v.density, v.radius)
        return v

    @abstractmethod
    def scene(self, v: Values) -> Scene:
        """The scene of these values at its start."""

    @abstractmethod
    def scales(self, v: Values) -> Scales:
        """Length, shortest time, duration and mass."""

    @abstractmethod
    def truth(self, v: Values, scale: Mapping[str, float]) -> Truth:
        """The truth of these values, on the scales of the quantities."""

    def spin_scale(self, v: Values) -> float:
        """Scale [rad/s] of the angular velocities.

        It is the larger of the largest spin at the start and the spin of rolling, largest speed /
        smallest radius; if nothing moves, that of rolling at the speed scale.
        """
        bodies = self.scene(v).bodies
        largest_speed = np.linalg.norm(bodies.velocity, axis=1).max()
        largest_spin = np.linalg.norm(bodies.omega, axis=1).max()
        rolling = largest_speed / bodies.radius.min()
        at_start = float(max(largest_spin, rolling))
        return at_start or self.scales(v).speed / float(v.radius)

    def quantities(self, v: Values) -> tuple[Quantity, ...]:
        """Position r, velocity v and angular velocity omega of every body, by component.

        The bodies are numbered from 1; a single one has no number: `r.x`, or `r2.x`.
        """
        s = self.scales(v)
        vectors = (
            ("r", "m", s.length),
            ("v", "m/s", s.speed),
            ("omega", "rad/s", self.spin_scale(v)),
        )
        if self.bodies > 1:
            numbers = [str(i + 1) for i in range(self.bodies)]
        else:
            numbers = [""]
        components = []
        for number in numbers:
            for vector, unit, scale in vectors:
                components += [Quantity(f"{vector}{number}.{axis}", unit, scale) for axis in "xyz"]
        return tuple(components)

    def observe(self, v: Values, run: Trajectory) -> dict[str, Array]:
        """The components (T,) of `quantities`, by name and in their order."""
        state = (run.position, run.velocity, run.omega)
        columns = [column[:, body] for body in range(self.bodies) for column in state]
        names = [quantity.name for quantity in self.quantities(v)]
        return dict(zip(names, np.concatenate(columns, axis=1).T, strict=True))
