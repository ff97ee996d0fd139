"""Certified motion of a box that flies (as the free rigid body does), or tumbles down a slope
(refdem/truth/tumbling_contact.py).

Slope: axes, law and sides are those of the case; the start is exact, in flight. Certified up to
where two corners would touch at once or a corner that presses would come to a stop.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from typing import Any

from flint import arb

from refdem.core.parameters import Parameters
from refdem.core.truth import Ball, Truth
from refdem.truth.balls import Guarded, arb_of
from refdem.truth.closed_forms.free_rigid_body import (
    ATTITUDE,
    BODY_OMEGA,
    MATRIX,
    OMEGA,
    FreeRigidBody,
    exact_columns,
)
from refdem.truth.events.system import Entry, TracedModes
from refdem.truth.events.truth import HybridFlow
from refdem.truth.exact import number, numbers, vector
from refdem.truth.refiner import Size
from refdem.truth.rotation import rotated, times, upright
from refdem.truth.tumbling_contact import BodyState, Modes, Slope, dot, lean_rates, rotation

PLACE = ("x", "y", "z")
DIGITS = 32


class Flight(Guarded, Truth):
    """A free body whose centre moves uniformly from the origin."""

    def __init__(self, body: FreeRigidBody, velocity: Sequence[Fraction], length: Size) -> None:
        self.body = body
        self.velocity = tuple(velocity)
        self.length = float(length)
        self.method = body.method
        self.witness = body.witness

    def at(self, t: Fraction) -> dict[str, Ball]:
        places = {
            axis: Ball(v * t, Fraction(0)) for axis, v in zip(PLACE, self.velocity, strict=True)
        }
        return self.body.at(t) | places

    def drift(self, t: Fraction) -> float:
        """S of the place: it and the velocity are displaced by L and by |v|."""
        return 1.0 + float(t) * sum(abs(float(v)) for v in self.velocity) / self.length

    def sensitivity(self, t: Fraction) -> float:
        return max(self.body.sensitivity(t), self.drift(t))

    def scalars(self) -> Mapping[str, Ball]:
        return self.body.scalars()

    def refined(self, digits: int) -> "Flight":
        return Flight(self.body.refined(digits), self.velocity, self.length)


WITNESS = (
    "Taylor integration of Euler's equations in body axes, contacts by a scan and bisection"
    " (refdem/truth/witnesses/tumbling.py)"
)


def tumbling(system: Slope, start: Sequence[Any], scale: Mapping[str, Size]) -> HybridFlow:
    """The quantities of the case on the slope.

    S displaces attitude, spin, place and velocity, each component by its scale.
    """
    sizes = dict(scale)
    rate = Fraction(sizes["omega.x"])
    length = Fraction(sizes["x"])
    sizes |= {"spin": max(system.inertia) * rate, "speed": length * rate}
    return HybridFlow(
        TracedModes(Modes(system), len(start), lean_rates),
        start,
        lambda y: Entry(""),
        partial(seen, system),
        sizes,
        state=(*ATTITUDE, *["spin"] * 3, *PLACE, *["speed"] * 3),
        moved=range(13),
        digits=DIGITS,
        witness=WITNESS,
        finished=with_upright_attitude,
    )


def seen(system: Slope, y: Sequence[Any]) -> dict[str, Any]:
    """The quantities of a state, the attitude of either sign."""
    found = BodyState(system, y)
    half = (y[0] * 0 + system.slope) / 2
    c = half.cos()
    s = half.sin()
    w, x, v, z = y[:4]
    # The quaternion of the slope, (c, 0, s, 0), times that of the body.
    attitude = [c * w - s * v, c * x + s * z, c * v + s * w, c * z - s * x]
    rows = rotation(attitude)
    tilt = rotation([c, y[0] * 0, s, y[0] * 0])
    omega, place = ([dot(row, vector) for row in tilt] for vector in (found.omega, y[7:10]))
    values = [*found.omega_body, *omega, *attitude, *(x for row in rows for x in row), *place]
    return dict(zip((*BODY_OMEGA, *OMEGA, *ATTITUDE, *MATRIX, *PLACE), values, strict=True))


def with_upright_attitude(values: dict[str, arb]) -> dict[str, arb]:
    """The same quantities with the attitude of positive w."""
    q = upright([values[name] for name in ATTITUDE])
    return values | dict(zip(ATTITUDE, q, strict=True))


def truth(p: Parameters, scale: Mapping[str, float]) -> Truth:
    """The truth at the parameters of case neglected-gyroscopic."""
    inertia, omega, attitude = exact_columns(p)
    velocity = vector(p, "velocity")
    if p["member"] == "free":
        return Flight(
            FreeRigidBody(
                inertia, omega, attitude, {k: v for k, v in scale.items() if k not in PLACE}
            ),
            velocity,
            scale["x"],
        )
    system = slope(p)
    spin = [j * w for j, w in zip(inertia, omega, strict=True)]
    place = (Fraction(0), Fraction(0), number(p, "height"))
    start = Start(system.slope, attitude, spin, place, velocity)
    return tumbling(system, start.coordinates(), scale)


def slope(p: Parameters) -> Slope:
    """The slope and the box on it."""
    inertia, _, _ = exact_columns(p)
    given = numbers(p, "mass", "gravity", "slope", "stiffness", "damping", "friction")
    # Squares of the sides of a box: m a_i^2/12 = (J1 + J2 + J3)/2 - J_i.
    squares = tuple(6 * (sum(inertia) - 2 * j) / given["mass"] for j in inertia)
    return Slope(inertia=inertia, squares=squares, **given)


@dataclass(frozen=True)
class Start:
    """The start in space, exact: spin in body axes, the rest in space."""

    slope: Fraction
    attitude: Sequence[Fraction]
    spin: Sequence[Fraction]
    place: Sequence[Fraction]
    velocity: Sequence[Fraction]

    def coordinates(self) -> list[Any]:
        """The state in the axes of the slope, number by number."""
        return [*(partial(self.coordinate, i) for i in range(13)), Fraction(0)]

    def coordinate(self, number: int) -> arb:
        """One of them at the current precision."""
        half = arb_of(self.slope) / 2
        back = [half.cos(), arb(0), -half.sin(), arb(0)]
        size = arb_of(sum((x * x for x in self.attitude), Fraction(0))).sqrt()
        q = times(back, [arb_of(x) / size for x in self.attitude])
        spin, place, velocity = (
            [arb_of(x) for x in given] for given in (self.spin, self.place, self.velocity)
        )
        return [*q, *rotated(q, spin), *rotated(back, place), *rotated(back, velocity)][number]
