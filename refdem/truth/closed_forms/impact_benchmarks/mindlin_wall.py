"""A sphere that touches the wall x = 0 under Hertz's law with a tangential spring (lever R),
clipped at Coulomb's limit: closed form.

The spring is k_t sqrt(d) s, s' the slip v_y + R omega, and clipped where it is mu k d^(3/2): at |s|
= g d, g = mu k/k_t. It slides from touch if |slip| > g v_n. While it slides the slip falls by 7/2
mu times the normal impulse per mass, so that the limit, whose rate is g d', is met again where a
linear function of d' is zero; while it sticks the stretch is that of mindlin_spring, and where it
comes to g d is proved by bisection and interval Newton. v_y - 2/5 R omega is kept.

Not certified: a spring that is too near its limit to tell on which side it is.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import partial

from flint import arb

from refdem.truth.balls import UndecidedError, arb_of
from refdem.truth.closed_form import Size, per_precision
from refdem.truth.closed_forms.impact_benchmarks.hertz_wall import STATE, STILL, HertzWallImpact
from refdem.truth.events.crossing import Along, SwitchError, Watched, earliest
from refdem.truth.growth import DIFFERENCE_BITS, FromTheStart, Grows
from refdem.truth.mindlin_spring import INWARD, OUTWARD, MindlinSpring, Stretched, started
from refdem.truth.reals import Number

MOST = 64
"""Phases of a contact."""


@dataclass(frozen=True)
class Sliding:
    """The spring at its limit on one side, at the leg and x where it comes there; slip [m/s]
    there.
    """

    spring: MindlinSpring
    side: int
    leg: int
    x: arb
    slip: arb
    slowing: arb
    """7/2 mu."""

    def caught(self, slack: arb) -> tuple[int, arb] | None:
        """Leg and x where the limit rises faster, or falls more slowly, than the spring at it;

        None if it does not before the end.
        """
        speed = self.spring.contact.speed
        _, rate = self.spring.place(self.leg, self.x)
        gap = self.slowing - slack
        if gap <= 0:
            return None
        u = (self.slowing * speed * rate - self.side * self.slip) / (gap * speed)
        if u < -1:
            return None
        if not u > -1:
            raise UndecidedError("whether the spring is caught before the contact ends")
        depth = (1 - u * u) ** arb_of(Fraction(2, 5))
        return self.spring.coordinate(depth, u)

    def now(self, depth: arb, rate: arb, elapsed: arb) -> tuple[arb, arb]:
        """Slip [m/s] and the way it has gone [m] since the begin."""
        contact = self.spring.contact
        before, first = self.spring.place(self.leg, self.x)
        push = self.side * self.slowing
        way = self.slip * elapsed - push * (
            contact.speed * first * elapsed - contact.depth * (depth - before)
        )
        return self.slip - push * contact.speed * (first - rate), way


@dataclass(frozen=True)
class Phase:
    """From a time [s] since touch on; the way of the slip until then [m], and the stretch [m] at
    the begin.
    """

    begin: arb
    way: arb
    stretch: arb
    motion: Sliding | Stretched

    def now(self, leg: int, x: arb, spring: MindlinSpring) -> tuple[arb, arb]:
        """Slip [m/s] and its way since touch [m]."""
        if isinstance(self.motion, Sliding):
            slip, way = self.motion.now(*spring.place(leg, x), spring.time(leg, x) - self.begin)
            return slip, self.way + way
        stretch, slope, _ = self.motion.at(x)
        return slope * spring.pace(leg, x), self.way + stretch - self.stretch


class MindlinWallImpact(HertzWallImpact):
    """Place [m], velocity [m/s] and angular velocity [rad/s] at t >= 0; friction and
    `stiffness_ratio` = k_t/k are not 0.
    """

    method = (
        "closed form: incomplete beta function along, 2F1 across while it sticks; switches proved"
        " by bisection and interval Newton"
    )
    witness = "Taylor integration in w = sqrt(overlap), switches found anew"

    def __init__(
        self, scale: Mapping[str, Size], *, stiffness_ratio: Fraction, **numbers: Number
    ) -> None:
        super().__init__(scale, **numbers)  # type: ignore[arg-type]
        self.stiffness_ratio = stiffness_ratio

    @per_precision
    def phases(self) -> list[Phase]:
        """Every phase of the contact, with the slip at the start counted as positive."""
        contact, _ = self.contact()
        spring = MindlinSpring(contact, self.stiffness_ratio)
        begin = self.begin[0] + self.radius
        slip = arb_of(self.slip_size())
        nothing = arb(0)
        touch = (arb_of(begin) if begin > 0 else arb(0)) / contact.depth
        rate = spring.place(INWARD, touch)[1] * contact.speed
        slides = slip > self.slack() * rate
        if not slides and not slip < self.slack() * rate:
            raise UndecidedError("whether it slides from touch on")
        motion: Sliding | Stretched = self.sliding(spring, 1, INWARD, touch, slip)
        if not slides:
            motion = started(spring, INWARD, touch, nothing, slip)
        found = [Phase(spring.time(INWARD, touch), nothing, nothing, motion)]
        x = touch
        if not slides and begin <= 0:
            at_limit = 1
        else:
            at_limit = 0
        while len(found) < MOST:
            last = found[-1]
            if isinstance(last.motion, Sliding):
                after = self.caught(last)
            else:
                after = self.left(last, x, at_limit)
            if after is None:
                return found
            found.append(after[0])
            x = after[1]
            at_limit = after[2]
        raise SwitchError("end", "the contact has more phases than are followed", 0.0)

    def slack(self) -> arb:
        """g."""
        return arb_of(self.friction / self.stiffness_ratio)

    def sliding(self, spring: MindlinSpring, side: int, leg: int, x: arb, slip: arb) -> Sliding:
        """At the limit."""
        return Sliding(spring, side, leg, x, slip, arb_of(Fraction(7, 2) * self.friction))

    def caught(self, last: Phase) -> tuple[Phase, arb, int] | None:
        """The stick after a slide, where it begins, and to which order it is at its limit there."""
        assert isinstance(last.motion, Sliding)
        spring = last.motion.spring
        side = last.motion.side
        place = last.motion.caught(self.slack())
        if place is None:
            return None
        leg, x = place
        overlap = spring.overlap(leg, x)[0]
        stretch = side * self.slack() * overlap
        rate = side * self.slack() * spring.contact.speed * spring.place(leg, x)[1]
        begin = spring.time(leg, x)
        way = last.now(leg, x, spring)[1]
        return Phase(begin, way, stretch, started(spring, leg, x, stretch, rate)), x, 2 * side

    def left(self, last: Phase, x: arb, at_limit: int) -> tuple[Phase, arb, int] | None:
        """What follows a stick; a stretch that ends with its leg goes on upon the next.

        `at_limit`: sides that are zero there.
        """
        motion = last.motion
        assert isinstance(motion, Stretched)
        spring = motion.spring
        end = motion.spring.ends(motion.leg)[1]
        if not self.slip():
            return None
        guards = [self.guard(motion, side, x, at_limit) for side in (1, -1)]
        found = earliest(guards, x, end)
        if found is None:
            if motion.leg == OUTWARD:
                raise UndecidedError("where the spring slips before the contact ends")
            far = motion.beyond()
            begin = spring.time(motion.leg, end)
            way = last.now(motion.leg, end, spring)[1]
            return Phase(begin, way, motion.at(end)[0], far), spring.ends(far.leg)[0], 0
        if found[0] == "1":
            side = 1
        else:
            side = -1
        where = found[1]
        begin = spring.time(motion.leg, where)
        (slip, way) = last.now(motion.leg, where, spring)
        slide = self.sliding(spring, side, motion.leg, where, slip)
        return (
            Phase(begin, way, side * self.slack() * spring.overlap(motion.leg, where)[0], slide),
            where,
            0,
        )

    def guard(self, motion: Stretched, side: int, x: arb, at_limit: int) -> Watched:
        """g d - side s; zero at the begin where both are (at touch, to the first order), or that
        side's is (caught, to the second).
        """
        if at_limit == 1:
            touching = 1
        elif at_limit == 2 * side:
            touching = 2
        else:
            touching = 0
        rates: list[Along] = [partial(self.spared, motion, side, order) for order in range(3)]
        return Watched(str(side), rates[: max(2, touching + 1)], touching)

    def spared(self, motion: Stretched, side: int, order: int, x: arb) -> arb:
        """A derivative by x of g d - side s."""
        return (
            self.slack() * motion.spring.overlap(motion.leg, x)[order] - side * motion.at(x)[order]
        )

    def across(self, t: arb) -> tuple[arb, arb]:
        """Slip and its way since the start at t, with the slip at the start counted as positive."""
        contact, touch = self.contact()
        since = t - touch
        slip = arb_of(self.slip_size())
        if touch > 0:
            first = touch
        else:
            first = arb(0)
        if not since > self.phases()[0].begin:
            return slip, slip * t
        if since < 2 * contact.half:
            depth, rate = contact.state(since)
            phase = self.phase(since)
            spring = phase.motion.spring
            if isinstance(phase.motion, Stretched):
                leg = phase.motion.leg
            else:
                leg = None
            leg, x = self.coordinate(spring, leg, depth / contact.depth, rate / contact.speed)
            now, way = phase.now(leg, x, spring)
            return now, slip * first + way
        phase = self.phases()[-1]
        if isinstance(phase.motion, Stretched):  # without slip nothing ever happens
            return slip, slip * t
        now, way = phase.now(OUTWARD, arb(0), phase.motion.spring)
        return now, slip * first + way + now * (since - 2 * contact.half)

    def coordinate(
        self, spring: MindlinSpring, leg: int | None, depth: arb, rate: arb
    ) -> tuple[int, arb]:
        """On the leg that is asked for, which near its ends balls could not tell."""
        if leg is None:
            return spring.coordinate(depth, rate)
        return leg, (depth, -rate, -depth)[leg]

    def phase(self, since: arb) -> Phase:
        """The one at a time."""
        found = None
        for phase in self.phases():
            if since >= phase.begin:
                found = phase
            elif not since < phase.begin:
                raise UndecidedError("whether it sticks or slips")
        if found is None:
            raise UndecidedError("whether it touches yet")
        return found

    def evaluate(self, t: arb) -> dict[str, arb]:
        _, y, _, vy, spin = (arb_of(value) for value in self.begin)
        depth, rate = self.normal(t)
        side = (self.slip() > 0) - (self.slip() < 0)
        radius = arb_of(self.radius)
        slip, way = self.across(t)
        kept = vy - arb_of(Fraction(2, 5)) * radius * spin
        part = arb_of(Fraction(2, 7))
        along = (side * slip * part) + kept * (1 - part)
        now = (
            depth - radius,
            y + side * way * part + kept * (1 - part) * t,
            rate,
            along,
            (side * slip - along) / radius,
        )
        return dict(zip((*STATE, *STILL), (*now, *(arb(0),) * 4), strict=True))

    @per_precision
    def growth(self) -> Grows:
        """From errors of the start alone: what errors that are made later do to a spring that is
        clipped is not bounded yet.
        """
        return FromTheStart(self.jacobian)

    def growth_bits(self) -> Sequence[int]:
        return DIFFERENCE_BITS
