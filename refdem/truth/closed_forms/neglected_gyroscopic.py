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
from refdem.truth.balls import GuardedTruth, arb_of
from refdem.truth.closed_form import Size
from refdem.truth.closed_forms.free_rigid_body import (
    ATTITUDE,
    BODY_OMEGA,
    MATRIX,
    OMEGA,
    FreeRigidBody,
    exact_columns,
)
from refdem.truth.events.system import Entry, Traced
from refdem.truth.events.truth import HybridFlow
from refdem.truth.exact import numbers, vector
from refdem.truth.rotation import rotated, times, upright
from refdem.truth.tumbling_contact import Modes, Seen, Slope, TracedCorners, dot, rotation

PLACE = ("x", "y", "z")
DIGITS = 32


class Flight(GuardedTruth):
    """A free body whose centre moves uniformly from the origin."""

    def __init__(self, body: FreeRigidBody, velocity: Sequence[Fraction], length: Size) -> None:
        self.body, self.velocity, self.length = body, tuple(velocity), float(length)
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


class Tumbling(HybridFlow):
    """The quantities of the case on the slope.

    S displaces attitude, spin, place and velocity, each component by its scale.
    """

    witness = (
        "Taylor integration of Euler's equations in body axes, contacts by a scan and bisection"
        " (refdem/truth/witnesses/tumbling.py)"
    )

    def __init__(self, system: Slope, start: Sequence[Any], scale: Mapping[str, Size]) -> None:
        self.system = system
        sizes = dict(scale)
        rate = Fraction(sizes["omega.x"])
        length = Fraction(sizes["x"])
        sizes |= {"spin": max(system.inertia) * rate, "speed": length * rate}
        state = (*ATTITUDE, *["spin"] * 3, *PLACE, *["speed"] * 3)
        super().__init__(
            {},
            start,
            lambda y: Entry(""),
            self.seen,
            sizes,
            state=state,
            moved=range(13),
            digits=DIGITS,
        )
        self.modes = TracedModes(Modes(system), len(start))

    def seen(self, y: Sequence[Any]) -> dict[str, Any]:
        """The quantities of a state, the attitude of either sign."""
        found = Seen(self.system, y)
        angle = (y[0] * 0 + self.system.slope) / 2
        (w, x, v, z), c, s = y[:4], angle.cos(), angle.sin()
        attitude = [c * w - s * v, c * x + s * z, c * v + s * w, c * z - s * x]
        rows = rotation(attitude)
        tilt = rotation([c, y[0] * 0, s, y[0] * 0])
        omega, place = ([dot(row, vector) for row in tilt] for vector in (found.omega, y[7:10]))
        values = [*found.omega_body, *omega, *attitude, *(x for row in rows for x in row), *place]
        return dict(zip((*BODY_OMEGA, *OMEGA, *ATTITUDE, *MATRIX, *PLACE), values, strict=True))

    def named(self, y: Sequence[arb]) -> dict[str, arb]:
        found = super().named(y)
        return found | dict(zip(ATTITUDE, upright([found[name] for name in ATTITUDE]), strict=True))


class TracedModes(dict[str, Traced]):
    """Modes as programs, each traced when it is entered."""

    def __init__(self, modes: Modes, size: int) -> None:
        super().__init__()
        self.modes = modes
        self.size = size

    def __missing__(self, name: str) -> Traced:
        self[name] = TracedCorners(self.modes[name], self.size)
        return self[name]


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
    given = numbers(p, "mass", "gravity", "slope", "height", "stiffness", "damping", "friction")
    height = given.pop("height")
    squares = tuple(6 * (sum(inertia) - 2 * j) / given["mass"] for j in inertia)
    system = Slope(inertia=inertia, squares=squares, **given)
    spin = [j * w for j, w in zip(inertia, omega, strict=True)]
    return Tumbling(
        system,
        Start(
            system.slope, attitude, spin, (Fraction(0), Fraction(0), height), velocity
        ).coordinates(),
        scale,
    )


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
