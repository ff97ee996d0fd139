"""Certified impact of two rigid spheres that start apart: rigid_collision.py with the time of
contact from a quadratic equation.

With d = r2 - r1 and w = v2 - v1 at the start they meet at the first root of |d + w t| = R1 + R2,
t = (-d.w - sqrt(q))/w^2 with q = (d.w)^2 - w^2 (d^2 - (R1 + R2)^2).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from refdem.core.parameters import Parameters
from refdem.core.truth import Truth
from refdem.truth.balls import UndecidedError
from refdem.truth.exact import number, vector
from refdem.truth.rigid_collision import rigid_collision
from refdem.truth.rigid_impact import ImpactLaw, Motion, RoundBody
from refdem.truth.surds import Surd, surd
from refdem.truth.vectors import dot


@dataclass(frozen=True)
class SpheresMeet:
    """Two free spheres meet where their centres are `reach` = R1 + R2 [m] apart."""

    reach: Fraction

    def time(self, states: Sequence[Motion]) -> Surd | None:
        """The time of contact [s]; UndecidedError if the spheres miss or graze each other."""
        first, second = states
        apart = difference(second.r, first.r)
        relative = difference(second.v, first.v)
        a = dot(relative, relative)
        b = dot(apart, relative)
        # a = w^2, b = d.w, q = b^2 - a (d^2 - (R1 + R2)^2);  t = (-b - sqrt(q))/a
        q = b * b - a * (dot(apart, apart) - self.reach**2)
        if q <= 0 or b >= 0:
            raise UndecidedError("the spheres do not meet, or only graze", code="grazing")
        return surd(-b / a, -1 / a, q)

    def normal(self, places: Sequence[Sequence[Any]]) -> list[Any]:
        """The unit vector (3,) from centre to centre, in numbers of the kind of the places."""
        apart = difference(places[1], places[0])
        if isinstance(apart[0], Surd):
            # At the impact the centres are exactly R1 + R2 apart.
            return [x * (1 / self.reach) for x in apart]
        distance = dot(apart, apart).sqrt()
        return [x / distance for x in apart]


def difference(a: Sequence[Any], b: Sequence[Any]) -> list[Any]:
    """The difference a - b of two vectors (3,)."""
    return [x - y for x, y in zip(a, b, strict=True)]


def start_of(p: Mapping[str, Any]) -> list[Fraction]:
    """r, v, omega of both spheres at the start, exactly.

    The centre of mass is at rest at the origin. r2 - r1 = (R1 + R2) (distance, offset), and the
    relative velocity v1 - v2 is the closing speed along x; r1 = -(m2/M)(r2 - r1), r2 = (m1/M)(r2 -
    r1), and the velocities alike.
    """
    masses = vector(p, "masses")
    radii = vector(p, "radii")
    spins = vector(p, "spins")
    reach = sum(radii, Fraction(0))
    # r2 - r1, and below v1 - v2.
    apart = [reach * part for part in (number(p, "distance"), *vector(p, "offset"))]
    closing = [number(p, "closing_speed"), Fraction(0), Fraction(0)]
    total = sum(masses, Fraction(0))
    # m2/M and m1/M.
    first = masses[1] / total
    second = masses[0] / total
    return [
        *(-first * x for x in apart),
        *(first * v for v in closing),
        *spins[:3],
        *(second * x for x in apart),
        *(-second * v for v in closing),
        *spins[3:],
    ]


def bodies_of(p: Mapping[str, Any]) -> list[RoundBody]:
    """Mass, inertia factor and radius of both spheres."""
    columns = zip(
        vector(p, "masses"), vector(p, "inertia_factors"), vector(p, "radii"), strict=True
    )
    return [RoundBody(mass=m, inertia_factor=f, radius=r) for m, f, r in columns]


def law_of(p: Mapping[str, Any]) -> ImpactLaw:
    """The law of the impact, in exact numbers."""
    return ImpactLaw(
        restitution=number(p, "restitution"),
        tangential_restitution=number(p, "tangential_restitution"),
        friction=number(p, "friction"),
    )


def truth(p: Parameters, scale: Mapping[str, float]) -> Truth:
    """The truth of case hard-spheres; `scale` of r, v, omega of both, in order."""
    bodies = bodies_of(p)
    meeting = SpheresMeet(bodies[0].radius + bodies[1].radius)
    return rigid_collision(scale, bodies, law_of(p), meeting, start_of(p))
