"""Witness of a body that slides until it rolls: the angular momentum about the line of contact and
the slip as unknowns, in place of v and omega.

Friction has no moment about the line of contact, so that (v - f R omega)' = g sin a in sliding and
in rolling, with J = f m R^2. The second unknown is the slip v + R omega, whose zero is found by
bisection. The position is the integral of v by Simpson's rule, which is exact for a linear v.
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from itertools import pairwise

from flint import arb

from refdem.core.parameters import Exact
from refdem.truth.balls import arb_of
from refdem.truth.exact import number
from refdem.truth.witnesses.cross_check import Claimed, Results, Witness
from refdem.truth.witnesses.rigid_impacts import HALVINGS

METHOD = (
    "the angular momentum about the line of contact, and the slip, whose zero is found by"
    " bisection, unproven (refdem/truth/witnesses/rolling.py)"
)


class Body:
    """A round body on a slope of angle a: f, R, mu, g sin a and g cos a [m/s^2], and its motion."""

    def __init__(self, p: Mapping[str, Exact]) -> None:
        angle = arb_of(number(p, "slope")).atan()
        self.factor = arb_of(number(p, "inertia_factor"))
        self.radius = arb_of(number(p, "radius"))
        self.friction = arb_of(number(p, "friction"))
        self.along = arb_of(number(p, "gravity")) * angle.sin()
        self.pressing = arb_of(number(p, "gravity")) * angle.cos()
        self.mass = arb_of(number(p, "mass"))
        speed = number(p, "speed")
        surface = number(p, "radius") * number(p, "spin")
        # The moment v - f R omega about the line of contact, and the slip v + R omega.
        self.moment = arb_of(speed) - self.factor * arb_of(surface)
        self.slip = speed + surface
        # Rolling needs the friction m g sin a f/(1 + f) <= mu m g cos a: tan a f <= mu (1 + f).
        needed = number(p, "slope") * number(p, "inertia_factor")
        self.grips = needed <= number(p, "friction") * (1 + number(p, "inertia_factor"))
        self.end = self.slip_end()

    def slip_rate(self, side: int) -> arb:
        """The rate s' = g sin a - side mu g cos a (1 + 1/f) of the slip [m/s^2]."""
        rubbing = self.friction * self.pressing
        return self.along - side * (rubbing + rubbing / self.factor)

    def slip_end(self) -> arb | None:
        """The time at which the first slip ends; None if it does not."""
        side = (self.slip > 0) - (self.slip < 0)
        if side == 0 or self.friction == 0 or not self.slip_rate(side) * side < 0:
            return None

        def left(t: arb) -> arb:
            return arb(side * (arb_of(self.slip) + self.slip_rate(side) * t))

        low = arb(0)
        high = arb(1)
        while left(high) > 0:
            high = 2 * high
        for _ in range(HALVINGS):
            middle = ((low + high) / 2).mid()
            if left(middle) > 0:
                low = middle
            else:
                high = middle
        return high

    def slip_at(self, t: arb) -> arb:
        """The slip [m/s] at the time t [s].

        After the end of the first slip it is 0 if the body rolls; otherwise it increases from 0.
        """
        side = (self.slip > 0) - (self.slip < 0)
        if self.end is not None and t > self.end:
            if self.grips:
                return arb(0)
            return self.slip_rate(1) * (t - self.end)
        if side == 0:
            if self.grips:
                return arb(0)
            side = 1
        return arb_of(self.slip) + self.slip_rate(side) * t

    def speeds(self, t: arb) -> tuple[arb, arb]:
        """v [m/s] and omega [rad/s] at the time t [s]."""
        # slip - moment = (v + R omega) - (v - f R omega) = (1 + f) R omega
        moment = self.moment + self.along * t
        slip = self.slip_at(t)
        surface = (slip - moment) / (1 + self.factor)
        return slip - surface, surface / self.radius

    def place(self, t: arb) -> arb:
        """The position x [m]: the integral of v by Simpson's rule, split at the end of the slip."""
        ends = [arb(0), t]
        if self.end is not None and t > self.end:
            ends.insert(1, self.end)
        way = arb(0)
        for begin, end in pairwise(ends):
            middle = (begin + end) / 2
            values = (self.speeds(begin)[0], self.speeds(middle)[0], self.speeds(end)[0])
            # Simpson's rule: (b - a) (v(a) + 4 v((a + b)/2) + v(b))/6.
            way += (end - begin) * (values[0] + 4 * values[1] + values[2]) / 6
        return way


def rolling(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Results:
    """The states at the times, and when and how fast it rolls."""
    body = Body(p)
    for t in times:
        until = arb_of(t)
        speed, spin = body.speeds(until)
        yield (
            t,
            {
                "x": body.place(until),
                "y": body.radius,
                "vx": speed,
                "vy": arb(0),
                "omega": spin,
            },
        )
    if body.end is None:
        return
    if not body.grips:
        yield None, {"reversal_time": body.end}
        return
    speed, spin = body.speeds(body.end)
    # Work of friction = kinetic energy at the start + m g sin a x - kinetic energy at the end.
    before = energy(body, *body.speeds(arb(0)))
    fallen = body.mass * body.along * body.place(body.end)
    work = before + fallen - energy(body, speed, spin)
    yield None, {"roll_time": body.end, "roll_speed": speed, "friction_work": work}


def energy(body: Body, speed: arb, spin: arb) -> arb:
    """The kinetic energy m (v^2 + f R^2 omega^2)/2 [J]."""
    surface = body.radius * spin
    return body.mass * (speed * speed + body.factor * surface * surface) / 2


WITNESSES = {"rolling": Witness(METHOD, rolling)}
