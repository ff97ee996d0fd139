"""Certified impact of a rigid sphere on a wall: rigid_collision.py with a uniform motion up to the
wall.

The wall passes through the origin; its normal N, of any length, points towards the sphere. The
sphere touches it where r.N = R |N|, at t = (R |N| - r.N)/(v.N), and the unit normal is N |N|/N^2.
Both are numbers a + b sqrt(N^2) with rational a and b.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from refdem.core.parameters import Parameters
from refdem.core.truth import Truth
from refdem.truth.balls import UndecidedError
from refdem.truth.closed_forms.hard_spheres import law_of
from refdem.truth.exact import number, vector
from refdem.truth.rigid_collision import rigid_collision
from refdem.truth.rigid_impact import Motion, RoundBody
from refdem.truth.surds import Surd, surd
from refdem.truth.vectors import dot


@dataclass(frozen=True)
class MeetsWall:
    """A sphere of `radius` [m] meets a wall through the origin, whose normal points to it."""

    normal_vector: Sequence[Fraction]
    radius: Fraction

    def time(self, states: Sequence[Motion]) -> Surd | None:
        """The time of contact [s]; UndecidedError if the sphere does not approach the wall."""
        (sphere,) = states
        approach = dot(sphere.v, self.normal_vector)
        if approach >= 0:
            raise UndecidedError("the sphere does not come nearer to the wall", code="grazing")
        # t = -(r.N)/(v.N) + R/(v.N) sqrt(N^2)
        height = dot(sphere.r, self.normal_vector)
        squared = dot(self.normal_vector, self.normal_vector)
        return surd(-height / approach, self.radius / approach, squared)

    def normal(self, places: Sequence[Sequence[Any]]) -> list[Any]:
        """The unit vector (3,) into the wall, in exact numbers or balls."""
        # -N |N|/N^2 = -(N/N^2) sqrt(N^2)
        squared = dot(self.normal_vector, self.normal_vector)
        unit = [surd(Fraction(0), -x / squared, squared) for x in self.normal_vector]
        if isinstance(places[0][0], Surd):
            return unit
        return [x.ball() for x in unit]


def truth(p: Parameters, scale: Mapping[str, float]) -> Truth:
    """The truth of case hard-wall; `scale` of r, v, omega, in order."""
    body = RoundBody(
        mass=number(p, "mass"),
        inertia_factor=number(p, "inertia_factor"),
        radius=number(p, "radius"),
    )
    start = [*vector(p, "position"), *vector(p, "velocity"), *vector(p, "spin")]
    meeting = MeetsWall(vector(p, "normal"), body.radius)
    return rigid_collision(scale, [body], law_of(p), meeting, start)
