"""Where a corner that presses on a slope (refdem/truth/tumbling_contact.py) is proved to stop: from
there on its friction has no direction, and the motion no field.

The slip u of the corner has the rate u' = a + N (c - mu K e), where a is what no force at the
corner makes, N (c, K) what its pressure and friction do, and e the direction of u.

Theorem: let an arc of directions hold e, and let B be a box that no motion of a set leaves within
tau as long as e is in the arc. Let no guard of the mode vanish in B, and with a, N, c and K in
balls over B let e turn back from both ends of the arc, and e . u' <= -d < 0 in all of it. Then
neither e leaves the arc nor the motion B, and |u| falls at the rate d at least until it is 0, which
comes within |u|/d, if that is at most tau.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import atan2, hypot, isfinite

from flint import arb

from refdem.truth.balls import arb_of, precision
from refdem.truth.events.system import Guard, State, along
from refdem.truth.traced_field import Program, Trace, slope
from refdem.truth.tumbling_contact import BodyState, Slope, Stops
from refdem.truth.vectors import dot

BITS = 64
"""The working precision of boxes, which bound and need not be sharp."""
SIZE = 14
"""Coordinates of a state, with the clock."""
ARCS = (1 / 32, 1 / 8, 1 / 2, 2.0)
"""Half widths [rad] of the arcs that are tried: a narrow one makes a thin box."""
SECTORS = 16
"""Of an arc, over each of which one ball holds the directions."""
OVERLAP = 1.0001
"""Times the half width of a sector, so that they cover the arc in spite of rounding."""
HORIZON = 1.5
"""tau, in parts of |u| over its rate at the set: the rate changes on the way."""
BOXES = 4
"""Tries of a box that no motion leaves."""
WIDER = 1.25
"""Times the way of a motion within tau at the rates of the box before."""


@dataclass(frozen=True)
class Values:
    """What a corner's slip depends on, in balls over a set of states and the forces on the corner.

    `rates` are those of the state (14), `slip` is u (2), `unforced` is a (2), and `by_force` has
    the two rows of the derivative of u' by the force (3).
    """

    rates: list[arb]
    slip: list[arb]
    unforced: list[arb]
    by_force: list[list[arb]]
    pressure: arb
    guards: list[arb]


@dataclass(frozen=True)
class Arc:
    """The directions within `half_width` [rad] of a heading."""

    heading: float
    half_width: float

    def ends(self) -> list[tuple[int, arb]]:
        """The side (1 is counterclockwise) and the angle [rad] of both ends."""
        return [(side, arb(self.heading) + side * arb(self.half_width)) for side in (1, -1)]

    def sectors(self) -> list[arb]:
        """Balls of angles [rad] that cover the arc."""
        half = self.half_width / SECTORS
        first = self.heading - self.half_width
        return [arb(first + (2 * number + 1) * half, half * OVERLAP) for number in range(SECTORS)]

    def directions(self) -> list[arb]:
        """Balls of the components (2) of all directions."""
        angle = arb(self.heading, self.half_width * OVERLAP)
        return [angle.cos(), angle.sin()]

    def holds(self, slip: Sequence[arb]) -> bool:
        """Whether all vectors in the balls `slip` (2) point into the arc."""
        c, s = arb(self.heading).cos(), arb(self.heading).sin()
        forward = c * slip[0] + s * slip[1]
        across = c * slip[1] - s * slip[0]
        # |across|/forward = |tan(angle to the heading)| < sin(h) <= h, and tan is larger than its
        # argument: so |angle| < h, for h = min(half width, 1) <= half width.
        narrow = min(self.half_width, 1.0)
        return bool(abs(across) < forward * arb(narrow).sin())


class Stop:
    """The stop of one corner in a mode: `by(state)` bounds the time [s] until it.

    `pressing` are the corners that press in the mode, this one among them; `guards` end it.
    """

    def __init__(
        self, system: Slope, corner: int, pressing: frozenset[int], guards: Sequence[Guard]
    ) -> None:
        self.system = system
        self.corner = corner
        self.pressing = pressing
        self.guards = guards

    @cached_property
    def program(self) -> Program:
        """All of `Values` one after another, from the state and the force (3) on the corner."""
        trace = Trace()
        y = [trace.node("in", i) for i in range(SIZE)]
        force = [trace.node("in", SIZE + i) for i in range(3)]
        found = self.system.rates(y, self.pressing, {self.corner: force})
        rates = [trace.constant(rate) for rate in found]
        body = BodyState(self.system, y)
        slip = body.velocity(self.corner)[:2]
        slip_rate = [along(component, rates) for component in slip]
        # u' = a + B f is affine in the force f on the corner: B by differentiation, a = u' - B f.
        by_force = [slope(one, SIZE + i) for one in slip_rate for i in range(3)]
        unforced = []
        for one, row in zip(slip_rate, (by_force[:3], by_force[3:]), strict=True):
            unforced.append(one - dot(row, force))
        guards = [guard.value(y) for guard in self.guards]
        pressure = body.pressure(self.corner)
        return Program([*rates, *slip, *unforced, *by_force, pressure, *guards])

    def values(self, y: State, force: Sequence[arb | int]) -> Values:
        """What the slip depends on, for these balls of states and of the force."""
        found = self.program.run([*y, *(arb(component) for component in force)])
        rates, rest = found[:SIZE], found[SIZE:]
        return Values(rates, rest[:2], rest[2:4], [rest[4:7], rest[7:10]], rest[10], rest[11:])

    def sliding(self, y: State, direction: Sequence[arb]) -> Values:
        """The same where the corner presses, and slips into one of these directions."""
        pressure = self.values(y, (0, 0, 0)).pressure
        # f = N (-mu e, 1), with the direction e of the slip.
        friction = pressure * arb_of(self.system.friction)
        return self.values(y, (-friction * direction[0], -friction * direction[1], pressure))

    def by(self, state: State) -> arb | None:
        """A bound of the time [s] in which every motion from the balls of a state has stopped; None
        where that is not proved.
        """
        with precision(BITS):
            y = [value + 0 for value in state]
            slip = self.values(y, (0, 0, 0)).slip
            heading = atan2(float(slip[1].mid()), float(slip[0].mid()))
            horizon = self.horizon(y, slip, heading)
            # A stop is searched for within the window sqrt(m/k), about a third of a contact.
            if not 0 < horizon < self.system.window:
                return None
            speed = (slip[0] ** 2 + slip[1] ** 2).sqrt()
            for half_width in ARCS:
                arc = Arc(heading, half_width)
                fall = self.least_fall(y, slip, arc, horizon)
                if fall is not None and speed / fall < horizon:
                    return arb((speed / fall).upper())
            return None

    def horizon(self, y: State, slip: Sequence[arb], heading: float) -> float:
        """The time tau [s] within which a stop is looked for, about HORIZON |u|/|u|'; infinite
        where the slip grows, or nothing is known of it.
        """
        speed = hypot(*(float(value.mid()) for value in slip))
        fall = float(self.fall(self.values(y, (0, 0, 0)), arb(heading))[0].mid())
        if not (isfinite(speed) and isfinite(fall) and fall > 0):
            return float("inf")
        return HORIZON * speed / fall

    def fall(self, values: Values, angle: arb) -> tuple[arb, arb]:
        """The rate at which |u| falls while u points along an angle [rad], and that of |u| times
        the angle.
        """
        direction = [angle.cos(), angle.sin()]
        friction = arb_of(self.system.friction)
        # u' = a + N (c - mu K e), with B = (K, c) by columns.
        by_pressure = []
        for row in values.by_force:
            by_pressure.append(row[2] - friction * (row[0] * direction[0] + row[1] * direction[1]))
        rate = [a + values.pressure * c for a, c in zip(values.unforced, by_pressure, strict=True)]
        # With e = (cos(angle), sin(angle)): |u|' = e . u' and |u| angle' = (-e_y, e_x) . u'.
        fall = -(direction[0] * rate[0] + direction[1] * rate[1])
        turn = direction[0] * rate[1] - direction[1] * rate[0]
        return fall, turn

    def least_fall(self, y: State, slip: Sequence[arb], arc: Arc, horizon: float) -> arb | None:
        """A bound d > 0 of the rate at which |u| falls within the horizon [s] in motions from the
        balls y, of slip `slip`; None where it is not proved that it does, in directions of the arc.
        """
        if not arc.holds(slip):
            return None
        box = self.kept_in(y, arc, horizon)
        if box is None:
            return None
        values = self.values(box, (0, 0, 0))
        # e turns back into the arc: angle' < 0 at its counterclockwise end, > 0 at the other one.
        for side, angle in arc.ends():
            if not side * self.fall(values, angle)[1] < 0:
                return None
        # -e . u' >= d > 0 for all directions e of the arc.
        falls = [self.fall(values, angle)[0] for angle in arc.sectors()]
        if all(fall > 0 for fall in falls):
            return min(arb(fall.lower()) for fall in falls)
        return None

    def kept_in(self, y: State, arc: Arc, horizon: float) -> list[arb] | None:
        """A box that no motion from the balls y leaves within the horizon [s] while the slip has
        directions of the arc, and in which no guard vanishes; None if none is found.
        """
        # All times in [0, tau] as one ball.
        passed = arb(horizon / 2, horizon / 2)
        box = list(y)
        for _ in range(BOXES):
            values = self.sliding(box, arc.directions())
            # If y + [0, tau] y'(B) lies in B, no motion from y leaves B within tau.
            reached = [value + passed * rate for value, rate in zip(y, values.rates, strict=True)]
            if not all(value.is_finite() for value in reached):
                return None
            if all(one.contains(other) for one, other in zip(box, reached, strict=True)):
                if values.pressure > 0 and all(value > 0 for value in values.guards):
                    return box
                return None
            # The next box: y and y + [0, tau] WIDER y'(B).
            ways = [passed * rate * WIDER for rate in values.rates]
            box = [value.union(value + way) for value, way in zip(y, ways, strict=True)]
        return None


def first_stop(system: Slope, pressing: frozenset[int], guards: Sequence[Guard]) -> Stops | None:
    """The stop of whichever of the corners that press is proved to; None without friction."""
    if not (system.friction and pressing):
        return None
    stops = [Stop(system, corner, pressing, guards) for corner in sorted(pressing)]

    def by(state: State) -> arb | None:
        """The time [s] by which a corner has stopped; None where none is proved to."""
        bounds = (stop.by(state) for stop in stops)
        return next((bound for bound in bounds if bound is not None), None)

    return by
