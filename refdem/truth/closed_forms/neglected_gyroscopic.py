"""Certified motion of a box: in free flight (free_rigid_body.py), or tumbling down a slope
(refdem/truth/tumbling_contact.py).

Slope: axes, contact law and sides are those of the case; the start is exact and in flight. The
motion is certified up to a time at which two corners touch at once, or the slip of a corner in
contact becomes 0.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from typing import Any

from flint import arb

from refdem.core.parameters import Parameters
from refdem.core.truth import Ball, Truth
from refdem.truth.balls import Guarded, arb_of, precision
from refdem.truth.closed_forms.free_rigid_body import (
    ATTITUDE,
    BODY_OMEGA,
    MATRIX,
    OMEGA,
    FreeRigidBody,
    exact_columns,
)
from refdem.truth.dual import Derivatives, slopes_of
from refdem.truth.events.system import Entry, TracedModes
from refdem.truth.events.truth import HybridFlow
from refdem.truth.exact import number, numbers, vector
from refdem.truth.growth import CLOSED_BITS, Told
from refdem.truth.refiner import Refiner, Size
from refdem.truth.rotation import rotated, times, upright
from refdem.truth.tumbling_contact import BodyState, Modes, Slope, lean_rates, rotation
from refdem.truth.tumbling_stop import first_stop
from refdem.truth.vectors import dot

PLACE = ("x", "y", "z")
DIGITS = 32
"""Digits of the values, twice those of binary64."""


class Flight(Guarded, Truth):
    """A free body whose centre moves uniformly from the origin."""

    def __init__(self, body: FreeRigidBody, velocity: Sequence[Fraction], length: Size) -> None:
        self.body = body
        self.velocity = tuple(velocity)
        self.length = Fraction(length)
        self.drift = Told(self.place_growth)
        self.method = body.method
        self.witness = body.witness

    def at(self, t: Fraction) -> dict[str, Ball]:
        places = {
            axis: Ball(v * t, Fraction(0)) for axis, v in zip(PLACE, self.velocity, strict=True)
        }
        return self.body.at(t) | places

    def derivatives(self, t: Fraction, count: int) -> Derivatives:
        """The derivatives at t of every quantity by each of `count` parameters: those of the body
        from its equations, those of its place v t exactly.
        """
        places = {}
        for axis, v in zip(PLACE, self.velocity, strict=True):
            # d(v t)/dp = (dv/dp) t.
            slopes = slopes_of(v) or (Fraction(0),) * count
            places[axis] = tuple(Ball(slope * t, Fraction(0)) for slope in slopes)
        return self.body.by_equation().derivatives(t, count) | places

    def place_growth(self, t: arb) -> arb:
        """S of the position, 1 + t |v|/L, for errors of length L and |v| in the same direction.

        They are errors of position and velocity, in the Euclidean norm.
        """
        square_of_speed = sum((v * v for v in self.velocity), Fraction(0))
        return 1 + t * arb_of(square_of_speed).sqrt() / arb_of(self.length)

    def sensitivity(self, t: Fraction) -> float:
        with precision(CLOSED_BITS[0]):
            of_place = self.drift.at(t)
        return max(self.body.sensitivity(t), of_place)

    def scalars(self) -> Mapping[str, Ball]:
        return self.body.scalars()

    def refined(self, digits: int) -> "Flight":
        return Flight(self.body.refined(digits), self.velocity, self.length)


WITNESS = (
    "Taylor integration of Euler's equations in body axes, contacts by a scan and bisection"
    " (refdem/truth/witnesses/tumbling.py)"
)


def tumbling(system: Slope, start: Sequence[Any], scale: Mapping[str, Size]) -> HybridFlow:
    """The truth of the box on the slope, from the coordinates of its start in the slope's axes.

    S displaces attitude, angular momentum, position and velocity, each component by its scale:
    those of the angular momentum and the velocity are J_max and L times that of omega.
    """
    sizes = dict(scale)
    omega_size = Fraction(sizes["omega.x"])
    length = Fraction(sizes["x"])
    # J_max [omega] and L [omega].
    sizes |= {"spin": max(system.inertia) * omega_size, "speed": length * omega_size}
    return HybridFlow(
        TracedModes(Modes(system, first_stop), len(start), lean_rates),
        start,
        lambda y: Entry(""),
        partial(seen, system),
        Refiner.of(sizes, digits=DIGITS),
        state=(*ATTITUDE, *["spin"] * 3, *PLACE, *["speed"] * 3),
        moved=range(13),
        witness=WITNESS,
        finished=with_upright_attitude,
    )


def seen(system: Slope, y: Sequence[Any]) -> dict[str, Any]:
    """The quantities of a state in axes of space, the attitude of either sign.

    The state y is in axes of the slope (tumbling_contact.py): attitude (0 to 3), angular momentum
    (4 to 6), position (7 to 9), velocity. These are turned by the slope's angle about y.
    """
    in_slope = BodyState(system, y)
    # By operations of a traced field: a constant is made from 0 times a coordinate.
    zero = y[0] * 0
    half_angle = (zero + system.slope) / 2
    c = half_angle.cos()
    s = half_angle.sin()
    q_w, q_x, q_y, q_z = y[:4]
    # The quaternion of the slope, (c, 0, s, 0), times that of the body.
    attitude = [c * q_w - s * q_y, c * q_x + s * q_z, c * q_y + s * q_w, c * q_z - s * q_x]
    matrix = [entry for row in rotation(attitude) for entry in row]
    slope_rows = rotation([c, y[0] * 0, s, y[0] * 0])
    # Vectors are turned by the matrix of the same quaternion.
    omega = [dot(row, in_slope.omega) for row in slope_rows]
    position = [dot(row, y[7:10]) for row in slope_rows]
    values = [*in_slope.omega_body, *omega, *attitude, *matrix, *position]
    return dict(zip((*BODY_OMEGA, *OMEGA, *ATTITUDE, *MATRIX, *PLACE), values, strict=True))


def with_upright_attitude(values: dict[str, arb]) -> dict[str, arb]:
    """The same quantities with the attitude of positive w."""
    q = upright([values[name] for name in ATTITUDE])
    return values | dict(zip(ATTITUDE, q, strict=True))


def truth(p: Parameters, scale: Mapping[str, float]) -> Truth:
    """The truth at the parameters of case neglected-gyroscopic, of its member free or slope."""
    inertia, omega, attitude = exact_columns(p)
    velocity = vector(p, "velocity")
    if p["member"] == "free":
        body_scale = {name: size for name, size in scale.items() if name not in PLACE}
        body = FreeRigidBody(Refiner.of(body_scale), inertia, omega, attitude)
        return Flight(body, velocity, scale["x"])
    system = slope(p)
    # L = J omega in principal axes.
    angular_momentum = [j * w for j, w in zip(inertia, omega, strict=True)]
    place = (Fraction(0), Fraction(0), number(p, "height"))
    start = Start(system.slope, attitude, angular_momentum, place, velocity)
    return tumbling(system, start.coordinates(), scale)


def slope(p: Parameters) -> Slope:
    """The slope and the box on it."""
    inertia, _, _ = exact_columns(p)
    given = numbers(p, "mass", "gravity", "slope", "stiffness", "damping", "friction")
    # Squares of the sides of a box: m a_i^2/12 = (J1 + J2 + J3)/2 - J_i, from J1 = m (a2^2 +
    # a3^2)/12 and so on.
    squares = tuple(6 * (sum(inertia) - 2 * j) / given["mass"] for j in inertia)
    return Slope(inertia=inertia, squares=squares, **given)


@dataclass(frozen=True)
class Start:
    """The exact start: `spin`, the angular momentum, in body axes, the rest in axes of space."""

    slope: Fraction
    attitude: Sequence[Fraction]
    spin: Sequence[Fraction]
    place: Sequence[Fraction]
    velocity: Sequence[Fraction]

    def coordinates(self) -> list[Any]:
        """The 13 numbers of the state in the axes of the slope, each a function that returns a
        ball, and the clock.
        """
        return [*(partial(self.coordinate, i) for i in range(13)), Fraction(0)]

    def coordinate(self, number: int) -> arb:
        """Number `number` of the state at the current precision.

        The transformation to axes of the slope is the rotation about y by minus its angle.
        """
        half_angle = arb_of(self.slope) / 2
        back = [half_angle.cos(), arb(0), -half_angle.sin(), arb(0)]
        length = arb_of(sum((x * x for x in self.attitude), Fraction(0))).sqrt()
        # The quaternion back q/|q|.
        attitude = times(back, [arb_of(x) / length for x in self.attitude])
        # The angular momentum is in body axes, position and velocity are in axes of space.
        spin = rotated(attitude, [arb_of(x) for x in self.spin])
        place = rotated(back, [arb_of(x) for x in self.place])
        velocity = rotated(back, [arb_of(x) for x in self.velocity])
        return [*attitude, *spin, *place, *velocity][number]
