"""Certified capture: r = r0 + v0 t up to closest approach at t_c = -r0.v0/v0^2, then a circle with
omega = (r0 x v0)/d^2.

d^2 = |r0 x v0|^2/v0^2 is the square of the distance there; t_c (`caught`), d^2 and r(t_c) (`place`)
are rational. `spin` is r0 x v0, `speed2` v0^2.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, partial

from flint import arb, arb_mat

from refdem.core.parameters import Parameters
from refdem.core.truth import Truth
from refdem.truth.balls import arb_of
from refdem.truth.closed_form import ClosedForm, displaced_tuple, per_precision
from refdem.truth.exact import numbers
from refdem.truth.growth import Grows, bounded, upper
from refdem.truth.refiner import Refiner
from refdem.truth.swept_growth import Span, largest_growth

RUN_UP = 2
"""The start is this many radii before closest approach."""
Start = tuple[Fraction, Fraction, Fraction, Fraction]


@dataclass(frozen=True)
class CapturedMass(ClosedForm):
    """x, y, vx, vy from an exact start (x, y, vx, vy) that approaches the hook at the origin."""

    method = (
        "straight line up to closest approach, circle after it: exact rationals, sine and cosine in"
        " Arb balls"
    )
    witness = (
        "multiprecision integration of a point held by the force -m v^2 r/r^2"
        " (refdem/truth/witnesses/linked.py)"
    )
    state = ("x", "y", "vx", "vy")

    mass: Fraction
    start: Start

    displaced = displaced_tuple("start")

    @cached_property
    def speed2(self) -> Fraction:
        """The square v0^2 of the speed [m^2/s^2]."""
        _, _, vx, vy = self.start
        return vx * vx + vy * vy

    @cached_property
    def caught(self) -> Fraction:
        """The time t_c [s] of closest approach."""
        x, y, vx, vy = self.start
        # t_c = -r0.v0/v0^2.
        return -(x * vx + y * vy) / self.speed2

    @cached_property
    def place(self) -> tuple[Fraction, Fraction]:
        """The position r(t_c) [m] at closest approach."""
        x, y, vx, vy = self.start
        return (x + vx * self.caught, y + vy * self.caught)

    @cached_property
    def spin(self) -> Fraction:
        """The angular momentum per mass, r0 x v0 [m^2/s]."""
        x, y, vx, vy = self.start
        return x * vy - y * vx

    def omega(self) -> arb:
        """Rate of turning [rad/s], positive from x to y: L/(m d^2), d^2 = spin^2/v^2."""
        # omega = (r0 x v0)/d^2 = v0^2/(r0 x v0).
        return arb_of(self.speed2 / self.spin)

    def evaluate(self, t: arb) -> dict[str, arb]:
        """The state at time t; where the ball t contains the capture, the union of both motions.

        Position and velocity are continuous at the capture.
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
        # r = Rot(omega s) r(t_c),  v = Rot(omega s) v0
        sine, cosine = (self.omega() * since).sin_cos()
        turned = []
        for a, b in (self.place, self.start[2:]):
            turned.append(arb_of(a) * cosine - arb_of(b) * sine)
            turned.append(arb_of(a) * sine + arb_of(b) * cosine)
        return dict(zip(self.state, turned, strict=True))

    @per_precision
    def growth(self) -> Grows:
        ratio = arb_of(self.scale["x"] / self.scale["vx"])
        rate = abs(self.omega())
        # omega in scales: |omega| X/V; a turn takes 2 pi/|omega|.
        return CaptureGrowth(self, ratio, rate * ratio, upper(2 * arb.pi() / rate))

    def frame(self, since: arb) -> arb_mat:
        """The matrix (4 x 4) from errors outward and along the motion to errors along x and y.

        `since` [s] counts from closest approach. The blocks for position and velocity are the same:
        their columns are the unit vectors outward, r/d, and along the motion.
        """
        angle = self.omega() * since
        x, y = (arb_of(value) for value in self.place)
        distance = (x * x + y * y).sqrt()
        if self.spin > 0:
            side = 1
        else:
            side = -1
        sine, cosine = angle.sin_cos()
        # outward = Rot(omega s) r(t_c)/d; along = +-(outward turned by a right angle), by the sense
        # of the motion.
        outward = [(x * cosine - y * sine) / distance, (x * sine + y * cosine) / distance]
        along = [-side * outward[1], side * outward[0]]
        zero = arb(0)
        positions = [[a, b, zero, zero] for a, b in zip(outward, along, strict=True)]
        velocities = [[zero, zero, *row[:2]] for row in positions]
        return arb_mat(positions + velocities)

    def constants(self) -> dict[str, arb]:
        # inertia = m d^2 = m (r0 x v0)^2/v0^2.
        return {"omega": self.omega(), "inertia": arb_of(self.mass * self.spin**2 / self.speed2)}


@dataclass(frozen=True)
class CaptureGrowth:
    """S of (x, y, vx, vy), by branch and bound over the times at which errors are made
    (swept_growth.py).

    Errors are in scales, (position outward, along the motion; velocity outward, along it), in the
    frame of the capture and then in one that turns with the mass. With F(s) this frame and C(tau)
    what errors become on the circle, an error made there at s has at t the answers F(t) C(t - s)
    F(s)^T.

    Of the times s at which the mass is at one place F(s) is the same, and C is affine: the sum of
    absolute values of a row of answers is convex in s, and largest for the first or the last of
    them. These lie in the first and in the last turn.

    `ratio` is the scale of the position over that of the velocity [s], `scaled_omega` the rate of
    turning in scales, `turn` the time of a whole turn [s], or a little more.
    """

    motion: CapturedMass
    ratio: arb
    scaled_omega: arb
    turn: Fraction

    def at(self, t: Fraction) -> float:
        """The bound S(t) >= 1 on the growth of an error."""
        caught = self.motion.caught
        if t <= caught:
            # An error of velocity made at the start grows to t V/X errors of position: 1 + t V/X.
            return bounded(float((1 + arb_of(t) / self.ratio).upper()))
        since = t - caught
        frame = self.motion.frame(arb_of(since))
        # An error made at s < t_c has at t the answers F(t) C(t - t_c) L(t_c - s) F(t_c)^T, with L
        # of the straight line; these are the first two factors, `of_flight` adds the others.
        after_capture = frame * self.circle(arb_of(since))
        # Errors before the capture.
        spans = [Span(Fraction(0), caught, partial(grown, partial(self.of_flight, after_capture)))]
        # Errors after it, at all times or in the first and in the last turn (see the class).
        answers = partial(grown, partial(self.of_circle, frame, arb_of(since)))
        if since <= 2 * self.turn:
            spans.append(Span(Fraction(0), since, answers))
        else:
            spans.append(Span(Fraction(0), self.turn, answers))
            spans.append(Span(since - self.turn, since, answers))
        return largest_growth(spans)

    def of_flight(self, after_capture: arb_mat, made: arb) -> arb_mat:
        """The answers to an error made before closest approach, `made` [s] after the start."""
        left = arb_of(self.motion.caught) - made
        return after_capture * self.straight(left) * self.motion.frame(arb(0)).transpose()

    def of_circle(self, frame: arb_mat, since: arb, made: arb) -> arb_mat:
        """The answers, `since` [s] after closest approach, to an error `made` [s] after it."""
        return frame * self.circle(since - made) * self.motion.frame(made).transpose()

    def straight(self, t: arb) -> arb_mat:
        """Errors of velocity become errors of position in the time t [s]."""
        # t V/X, the scale of velocities V over that of positions X.
        scaled_t = t / self.ratio
        one = arb(1)
        zero = arb(0)
        return arb_mat(
            [
                [one, zero, scaled_t, zero],
                [zero, one, zero, scaled_t],
                [zero, zero, one, zero],
                [zero, zero, zero, one],
            ]
        )

    def circle(self, t: arb) -> arb_mat:
        """What errors become on the circle in the time t [s].

        With the errors (rho, sigma) of the position outward and along the circle and u of the
        speed: rho' = 0, sigma' = u - omega rho, u' = 0, and the error of the outward velocity is
        -omega sigma. Its initial value has no effect, as the hook removes it at once.
        """
        scaled_t = t / self.ratio
        one = arb(1)
        zero = arb(0)
        # sigma = sigma0 + (u - omega rho) t; the error of the outward velocity is -omega sigma.
        row_sigma = [-self.scaled_omega * scaled_t, one, zero, scaled_t]
        row_outward = [-self.scaled_omega * value for value in row_sigma]
        return arb_mat([[one, zero, zero, zero], row_sigma, row_outward, [zero, zero, zero, one]])


def grown(
    answers: Callable[[arb], arb_mat], middle: Fraction, half: Fraction
) -> tuple[list[arb], list[arb]]:
    """The growth of each quantity for errors made at `middle`, and a bound within `half` of it [s].

    Growth is the sum of |answer| over unit errors of all coordinates.
    """
    # A ball of all times within `half` of `middle`.
    times = arb_of(middle - half).union(arb_of(middle + half))
    return sums_of_rows(answers(arb_of(middle))), sums_of_rows(answers(times))


def sums_of_rows(matrix: arb_mat) -> list[arb]:
    """The sum of absolute values in each row of a matrix."""
    return [sum((abs(entry) for entry in row), arb(0)) for row in matrix.table()]


def truth(p: Parameters, scale: Mapping[str, float]) -> Truth:
    """The truth at these parameters (mass, speed, radius)."""
    exact = numbers(p, "mass", "speed", "radius")
    # r0 = (-2 R, -R), v0 = (v, 0): the line passes the hook at the distance R.
    start = (-RUN_UP * exact["radius"], -exact["radius"], exact["speed"], Fraction(0))
    return CapturedMass(Refiner.of(scale), exact["mass"], start)
