"""Certified capture: r = r0 + v0 t up to closest approach at t_c = -r0.v0/v0^2, then a circle with
omega = (r0 x v0)/d^2.

d^2 = |r0 x v0|^2/v0^2 is the square of the distance there; t_c (`caught`), d^2 and r(t_c) (`place`)
are rational. `spin` is r0 x v0, `speed2` v0^2.
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
"""The start is this many radii before closest approach."""
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
        """The state at time t; where a ball of times holds the capture, both motions together.

        The state is continuous there: position and velocity are the same in both.
        """
        since = t - arb_of(self.caught)
        if since <= 0:
            return self.flight(t)
        if since > 0:
            return self.circle(since)
        flight = self.flight(t)
        circle = self.circle(since)
        return {name: value.union(circle[name]) for name, value in flight.items()}

    def flight(self, t: arb) -> dict[str, arb]:
        """The state on the straight line at t, before the catch."""
        x, y, vx, vy = (arb_of(value) for value in self.start)
        return dict(zip(self.state, (x + vx * t, y + vy * t, vx, vy), strict=True))

    def circle(self, since: arb) -> dict[str, arb]:
        """The state on the circle, `since` [s] after closest approach: r(t_c) and v0, turned."""
        sine, cosine = (self.omega() * since).sin_cos()
        turned = []
        for a, b in (self.place, self.start[2:]):
            turned.append(arb_of(a) * cosine - arb_of(b) * sine)
            turned.append(arb_of(a) * sine + arb_of(b) * cosine)
        return dict(zip(self.state, turned, strict=True))

    @per_precision
    def growth(self) -> Grows:
        """How errors grow: along the stretches, in the norm of vectors of two components."""
        vectors = Norm((2, 2), (1, 1, 1, 1))
        # Errors of both components by their scale are a vector that is longer than either.
        return Times(
            Growth(self.stretches(), vectors, self.readings, step=narrow(self.omega())),
            arb(2).sqrt(),
        )

    def stretches(self) -> Iterator[Stretch]:
        """The stretches along which errors grow smoothly: the straight line, and the circle.

        Errors are in scales, (position outward, along the motion; velocity outward, along it), in
        the frame of the capture and then in one that turns with the mass. On the circle an error
        rho outward is constant; sigma along it has the rate u - omega rho, u being the error of the
        speed; the velocity outward that belongs to them is -omega sigma, and any other one the hook
        takes at once (`held`).
        """
        ratio = arb_of(self.scale["x"] / self.scale["vx"])
        scaled_omega = abs(self.omega()) * ratio
        one = arb(1)
        zero = arb(0)

        def straight(t: arb) -> arb_mat:
            """Errors of velocity become errors of position."""
            scaled_t = t / ratio
            return arb_mat(
                [
                    [one, zero, scaled_t, zero],
                    [zero, one, zero, scaled_t],
                    [zero, zero, one, zero],
                    [zero, zero, zero, one],
                ]
            )

        def circle(t: arb) -> arb_mat:
            """sigma = sigma0 + (u - omega rho) t, and -omega sigma for the velocity outward."""
            scaled_t = t / ratio
            row_sigma = [-scaled_omega * scaled_t, one, zero, scaled_t]
            row_outward = [-scaled_omega * value for value in row_sigma]
            row_outward[2] += 1
            return arb_mat(
                [[one, zero, zero, zero], row_sigma, row_outward, [zero, zero, zero, one]]
            )

        held = arb_mat(
            [
                [one, zero, zero, zero],
                [zero, one, zero, zero],
                [zero, -scaled_omega, zero, zero],
                [zero, zero, zero, one],
            ]
        )
        yield smooth(arb(0), arb_of(self.caught), straight, jump=held)
        yield smooth(arb_of(self.caught), None, circle, instant_map=held)

    def readings(self, t: arb) -> arb_mat:
        """The matrix from errors outward and along the motion to those along the axes of space."""
        since = t - arb_of(self.caught)
        if since > 0:
            angle = self.omega() * since
        else:
            angle = arb(0)
        x, y = (arb_of(value) for value in self.place)
        distance = (x * x + y * y).sqrt()
        if self.spin > 0:
            side = 1
        else:
            side = -1
        sine, cosine = angle.sin_cos()
        outward = [(x * cosine - y * sine) / distance, (x * sine + y * cosine) / distance]
        along = [-side * outward[1], side * outward[0]]
        zero = arb(0)
        positions = [[a, b, zero, zero] for a, b in zip(outward, along, strict=True)]
        velocities = [[zero, zero, *row[:2]] for row in positions]
        return arb_mat(positions + velocities)

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
