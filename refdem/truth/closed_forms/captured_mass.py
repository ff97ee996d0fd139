"""Certified capture: r = r0 + v0 t up to closest approach at t_c = -r0.v0/v0^2, then a circle with
omega = (r0 x v0)/d^2.

d^2 = |r0 x v0|^2/v0^2 is the square of the distance there; t_c, d^2 and the direction of r(t_c) are
rational.
"""

from collections.abc import Iterator, Mapping
from fractions import Fraction

from flint import arb, arb_mat

from refdem.core.parameters import Parameters
from refdem.core.truth import Truth
from refdem.truth.balls import arb_of
from refdem.truth.closed_form import ClosedForm, per_precision
from refdem.truth.exact import numbers
from refdem.truth.growth import Grows, Growth, Norm, Stretch, Times, narrow, smooth
from refdem.truth.refiner import Refiner, Size

RUN_UP = 2
Start = tuple[Fraction, Fraction, Fraction, Fraction]


class CapturedMass(ClosedForm):
    """x, y, vx, vy from an exact start (x, y, vx, vy) that comes nearer to the hook at the
    origin.
    """

    method = (
        "straight line up to closest approach, circle after it: exact rationals, sine and cosine in"
        " Arb balls"
    )
    witness = (
        "multiprecision integration of a point held by the force -m v^2 r/r^2"
        " (refdem/truth/witnesses/linked.py)"
    )
    state = ("x", "y", "vx", "vy")

    def __init__(self, mass: Fraction, start: Start, scale: Mapping[str, Size]) -> None:
        self.refiner = Refiner.of(scale)
        self.mass = mass
        self.start = start
        x, y, vx, vy = start
        self.speed2 = vx * vx + vy * vy
        self.caught = -(x * vx + y * vy) / self.speed2
        self.place = (x + vx * self.caught, y + vy * self.caught)
        self.spin = x * vy - y * vx

    def omega(self) -> arb:
        """Rate of turning [rad/s], positive from x to y: L/(m d^2), d^2 = spin^2/v^2."""
        return arb_of(self.speed2 / self.spin)

    def evaluate(self, t: arb) -> dict[str, arb]:
        since = t - arb_of(self.caught)
        if since <= 0:
            return self.flight(t)
        if since > 0:
            return self.circle(since)
        both = self.flight(t), self.circle(since)
        return {name: value.union(both[1][name]) for name, value in both[0].items()}

    def flight(self, t: arb) -> dict[str, arb]:
        """The state on the straight line at t, before the catch."""
        x, y, vx, vy = (arb_of(value) for value in self.start)
        return dict(zip(self.state, (x + vx * t, y + vy * t, vx, vy), strict=True))

    def circle(self, since: arb) -> dict[str, arb]:
        """The circle, so long after closest approach."""
        sine, cosine = (self.omega() * since).sin_cos()
        pairs = (self.place, self.start[2:])
        turned = [
            (arb_of(a) * cosine - arb_of(b) * sine, arb_of(a) * sine + arb_of(b) * cosine)
            for a, b in pairs
        ]
        return dict(zip(self.state, (*turned[0], *turned[1]), strict=True))

    @per_precision
    def growth(self) -> Grows:
        vectors = Norm((2, 2), (1, 1, 1, 1))
        # Errors of both components by their scale are a vector that is longer than either.
        return Times(
            Growth(self.stretches(), vectors, self.readings, step=narrow(self.omega())),
            arb(2).sqrt(),
        )

    def stretches(self) -> Iterator[Stretch]:
        """The straight line, and the circle, whose frame turns; errors in scales, of place and
        velocity, outward and along the motion.

        On the circle an error rho outwards stays, sigma along it has the rate of u - omega rho, u
        being that of the speed; the velocity outwards that goes with them is -omega sigma, and what
        is left of it the hook takes at once.
        """
        ratio = arb_of(self.scale["x"] / self.scale["vx"])
        turn = abs(self.omega()) * ratio
        one = arb(1)
        none = arb(0)

        def straight(t: arb) -> arb_mat:
            moved = t / ratio
            return arb_mat(
                [
                    [one, none, moved, none],
                    [none, one, none, moved],
                    [none, none, one, none],
                    [none, none, none, one],
                ]
            )

        def circle(t: arb) -> arb_mat:
            moved = t / ratio
            along = [-turn * moved, one, none, moved]
            outwards = [-turn * value for value in along]
            outwards[2] += 1
            return arb_mat([[one, none, none, none], along, outwards, [none, none, none, one]])

        held = arb_mat(
            [
                [one, none, none, none],
                [none, one, none, none],
                [none, -turn, none, none],
                [none, none, none, one],
            ]
        )
        yield smooth(arb(0), arb_of(self.caught), straight, jump=held)
        yield smooth(arb_of(self.caught), None, circle, felt=held)

    def readings(self, t: arb) -> arb_mat:
        """Errors along the axes of space by those outwards and along the motion."""
        since = t - arb_of(self.caught)
        if since > 0:
            angle = self.omega() * since
        else:
            angle = arb(0)
        x, y = (arb_of(value) for value in self.place)
        size = (x * x + y * y).sqrt()
        if self.spin > 0:
            side = 1
        else:
            side = -1
        sine, cosine = angle.sin_cos()
        outward = [(x * cosine - y * sine) / size, (x * sine + y * cosine) / size]
        along = [-side * outward[1], side * outward[0]]
        none = arb(0)
        places = [[a, b, none, none] for a, b in zip(outward, along, strict=True)]
        return arb_mat(places + [[none, none, *row[:2]] for row in places])

    def displaced(self, axis: int, amount: Fraction) -> "CapturedMass":
        x, y, vx, vy = (value + (amount if i == axis else 0) for i, value in enumerate(self.start))
        return CapturedMass(self.mass, (x, y, vx, vy), self.scale)

    def constants(self) -> dict[str, arb]:
        return {"omega": self.omega(), "inertia": arb_of(self.mass * self.spin**2 / self.speed2)}


def truth(p: Parameters, scale: Mapping[str, float]) -> Truth:
    """The truth at these parameters (mass, speed, radius)."""
    exact = numbers(p, "mass", "speed", "radius")
    start = (-RUN_UP * exact["radius"], -exact["radius"], exact["speed"], Fraction(0))
    return CapturedMass(exact["mass"], start, scale)
