"""A sphere that touches the wall x = 0 under Hertz's law with a tangential spring (lever R),
clipped at Coulomb's limit: closed form.

The spring is k_t sqrt(d) s, s' the slip v_y + R omega, and clipped where it is mu k d^(3/2): at |s|
= g d, g = mu k/k_t. It slides from touch if |slip| > g v_n. While it slides the slip falls by 7/2
mu times the normal impulse per mass, so that the limit, whose rate is g d', is met again where a
linear function of d' is zero; while it sticks the stretch is that of mindlin_spring, and where it
comes to g d is proved by bisection and interval Newton. v_y - 2/5 R omega is kept.

Not certified: a spring that is too near its limit to tell on which side it is.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import partial

from flint import arb, arb_mat

from refdem.truth.balls import UndecidedError, arb_of
from refdem.truth.closed_form import ClosedForm, per_precision
from refdem.truth.closed_forms.impact_benchmarks.hertz_wall import (
    HERTZ,
    STATE,
    STILL,
    AgainstWall,
    impact_constants,
)
from refdem.truth.events.crossing import Along, SwitchError, Watched, earliest
from refdem.truth.growth import (
    UPWARDS,
    Grows,
    Growth,
    Norm,
    Stretch,
    most,
    narrow,
    smooth,
)
from refdem.truth.line_growth import homogeneous
from refdem.truth.mindlin_spring import INWARD, OUTWARD, MindlinSpring, Stretched, root, started
from refdem.truth.reals import Number
from refdem.truth.refiner import Refiner, Size
from refdem.truth.smooth_flow import SmoothFlow

COORDINATES = (*STATE, "stretch")
"""What errors grow in: the spring remembers them."""
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
        """Leg and x where the limit rises faster, or falls more slowly, than the spring at it.

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
    """A phase from a time [s] since touch on; the way of the slip until then [m], and the stretch
    [m] at the begin.
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


class MindlinWallImpact(AgainstWall, ClosedForm, SmoothFlow):
    """Place [m], velocity [m/s] and angular velocity [rad/s] at t >= 0; friction and
    `stiffness_ratio` = k_t/k are not 0.
    """

    state = STATE
    method = (
        "closed form: incomplete beta function along, 2F1 across while it sticks; switches proved"
        " by bisection and interval Newton"
    )
    witness = "Taylor integration in w = sqrt(overlap), switches found anew"

    def __init__(
        self,
        scale: Mapping[str, Size],
        *,
        mass: Number,
        radius: Fraction,
        stiffness: Number,
        stiffness_ratio: Fraction,
        friction: Fraction,
        normal: Number,
        across: Number,
        spin: Fraction,
    ) -> None:
        self.refiner = Refiner.of(scale)
        self.strike(
            mass=mass,
            radius=radius,
            stiffness=stiffness,
            friction=friction,
            normal=normal,
            across=across,
            spin=spin,
        )
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
        """The ratio g of friction to the stiffness ratio."""
        return arb_of(self.friction / self.stiffness_ratio)

    def sliding(self, spring: MindlinSpring, side: int, leg: int, x: arb, slip: arb) -> Sliding:
        """A sliding phase, in which friction is at Coulomb's limit."""
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
        """The coordinate on the leg that is asked for, which near its ends balls could not tell."""
        if leg is None:
            return spring.coordinate(depth, rate)
        return leg, (depth, -rate, -depth)[leg]

    def phase(self, since: arb) -> Phase:
        """The phase of the contact that is under way at a time."""
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
        # v_y = 2/7 (v_y + R omega) + 5/7 (v_y - 2/5 R omega), the latter of which is kept.
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

    def constants(self) -> dict[str, arb]:
        return impact_constants(self)

    @per_precision
    def growth(self) -> Grows:
        """Proved for errors of STATE at all times; the spring takes part in how they grow."""
        rows = Norm([1] * len(COORDINATES), [1] * len(STATE))
        count = len(COORDINATES)
        read = len(STATE)
        readings = arb_mat([[int(i == j) for j in range(count)] for i in range(read)])
        return Growth(
            self.stretches(),
            rows,
            lambda t: readings,
            made=range(read),
            step=narrow(1 / self.contact()[0].half),
        )

    def stretches(self) -> Iterator[Stretch]:
        """Free, then every leg of every phase, free again; errors of COORDINATES in scales.

        The force on the sphere is continuous at every switch, so that errors of the state jump
        nowhere. The stretch s of the spring begins with 0 where the overlap d does, which an error
        of d moves by -dd/d' in time, and it is side g d where a slide ends; while it slides it is
        of no use. An error at touch itself either changes when the sphere touches or leaves some
        overlap and no stretch: the free motion before the start has the former.
        """
        contact, touch = self.contact()
        if not touch.is_zero():
            raise UndecidedError("a start that does not touch yet, or overlaps")
        before = arb(2) ** -12 * self.dyadic_half()
        phases = self.followed()
        slip = arb_of(self.slip_size())
        if isinstance(phases[0].motion, Stretched):
            begun = slip / contact.speed
        else:
            begun = arb(0)
        free = partial(self.sliding_errors, 0)
        yield self.stretch(free, -before, arb(0), self.spring_reset(begun), flies=True)
        ends = [phase.begin for phase in phases[1:]]
        for phase, after, end in zip(phases, [*phases[1:], None], [*ends, None], strict=True):
            if end is None:
                last = 2 * contact.half
            else:
                last = end
            motion = phase.motion
            if isinstance(motion, Sliding):
                if after is not None:
                    held = motion.side * self.slack()
                else:
                    held = arb(0)
                errors = partial(self.sliding_errors, motion.side)
                yield self.stretch(errors, phase.begin, last, self.spring_reset(held))
                continue
            errors = partial(self.sticking_errors, motion)
            goes_on = after is not None and isinstance(after.motion, Stretched)
            if goes_on:
                jump = None
            else:
                jump = self.spring_reset(arb(0))
            yield self.stretch(errors, phase.begin, last, jump)
        yield self.stretch(free, 2 * contact.half, None, None, flies=True)

    def stretch(
        self,
        errors: Callable[[arb], list[list[arb]]],
        begin: arb,
        end: arb | None,
        jump: arb_mat | None,
        *,
        flies: bool = False,
    ) -> Stretch:
        """The stretch between two times [s] along which errors have these columns."""

        def fundamental(since: arb) -> arb_mat:
            rows = errors(begin + since)
            sizes = self.sizes()
            return arb_mat(
                [[entry / size for entry in row] for row, size in zip(rows, sizes, strict=True)]
            )

        if flies:
            quickness = self.quick_in_flight
        else:
            quickness = partial(self.quick_with_spring, begin)
        if end is None:
            length = None
        else:
            length = end - begin
        joins = jump is None and end is not None
        return smooth(begin, length, fundamental, jump=jump, joins=joins, quickness=quickness)

    def followed(self) -> list[Phase]:
        """The phases, and without slip, where none is told but the first, the legs of a spring that
        is never stretched.
        """
        found = list(self.phases())
        last = found[-1].motion
        nothing = arb(0)
        while isinstance(last, Stretched) and last.leg != OUTWARD:
            begin = last.spring.time(last.leg, last.spring.ends(last.leg)[1])
            last = last.beyond()
            found.append(Phase(begin, nothing, nothing, last))
        return found

    def dyadic_half(self) -> arb:
        """About the time from touch to the turn [s], exactly."""
        return self.contact()[0].half.mid()

    @per_precision
    def sizes(self) -> list[arb]:
        """The scales of COORDINATES; that of the stretch is the one of y."""
        return [arb_of(self.scale[name]) for name in (*STATE, "r.y")]

    def spring_reset(self, slope: arb) -> arb_mat:
        """A jump, in scales, after which the error of the stretch is this part of that of x."""
        count = len(COORDINATES)
        rows = [[arb(int(i == j)) for j in range(count)] for i in range(count)]
        sizes = self.sizes()
        rows[-1] = [slope * sizes[0] / sizes[-1], *[arb(0)] * (count - 1)]
        return arb_mat(rows)

    def quick_with_spring(self, begin: arb, times: arb) -> float:
        """Bound of the norm of the field's Jacobian in scales at times [s] since `begin`, in every
        phase.

        The force per mass across is (k_t/m) sqrt(d) s with |s| <= g d, g k_t = mu k, or mu (k/m)
        d^(3/2): its derivative by d is at most 3/2 mu (k/m) sqrt(d), that by s (k_t/m) sqrt(d). The
        overlap d is at most what it would be at its first speed from touch on, or to the end.
        """
        contact, _ = self.contact()
        since = (begin + times).upper()
        left = (2 * contact.half - begin - times).upper()
        deepest = arb.min(contact.depth, contact.speed * arb.max(arb(0), arb.min(since, left)))
        growing, kept = self.quick_parts()
        return most([kept, growing * deepest.sqrt()]) * UPWARDS

    @per_precision
    def quick_parts(self) -> tuple[arb, arb]:
        """The largest rate by which the forces change velocities, per root of the overlap, and that
        by which velocities change places.
        """
        x, y, vx, vy, spin, stretch = self.sizes()
        steep = arb_of(self.stiffness / self.mass)
        along = arb_of(HERTZ) * steep * x
        across = arb_of(self.friction) * along + arb_of(self.stiffness_ratio) * steep * stretch
        radius = arb_of(self.radius)
        turning = across * arb_of(Fraction(5, 2)) / (radius * spin)
        growing = most([along / vx, across / vy, turning])
        kept = most([vx / x, vy / y, (vy + radius * spin) / stretch])
        return arb(growing) * arb(UPWARDS), arb(kept) * arb(UPWARDS)

    def quick_in_flight(self, times: arb) -> float:
        """The same where nothing touches, and the stretch stays what it is."""
        x, y, vx, vy, _, _ = self.sizes()
        return most([vx / x, vy / y]) * UPWARDS

    def along_errors(self, t: arb) -> list[tuple[arb, arb]]:
        """Two errors of the overlap and its rate: a shift in time, and a change of the speed at
        touch in parts of itself.
        """
        depth, rate = self.normal_at(t)
        force = arb(0)
        if depth > 0:
            force = -arb_of(self.stiffness / self.mass) * depth * depth.sqrt()
        (x1, x2), (v1, v2) = homogeneous(
            depth, rate, force, t, arb_of(Fraction(4, 5)), arb(1)
        ).table()
        return [(x1, v1), (x2, v2)]

    def sliding_errors(self, side: int, t: arb) -> list[list[arb]]:
        """Six independent errors of COORDINATES, as columns, at a time since touch: mu times what
        the normal motion has comes across; of no use is the last, that of the stretch.
        """
        push = arb_of(side * self.friction)
        turn = push * arb_of(Fraction(5, 2) / self.radius)
        (x1, v1), (x2, v2) = self.along_errors(t)
        none = arb(0)
        one = arb(1)
        row_x = [x1, x2, none, none, none, none]
        row_y = [push * x1, push * x2, one, t, none, none]
        row_vx = [v1, v2, none, none, none, none]
        row_vy = [push * v1, push * v2, none, one, none, none]
        row_omega = [turn * v1, turn * v2, none, none, one, none]
        row_stretch = [none, none, none, none, none, one]
        return [row_x, row_y, row_vx, row_vy, row_omega, row_stretch]

    def sticking_errors(self, motion: Stretched, t: arb) -> list[list[arb]]:
        """The same while it sticks, where y is 2/7 s + 5/7 (v_y - 2/5 R omega) t and a constant.

        A shift in time changes s by s' and s' by s''. With l times the overlap and time l^(1/4)
        times as fast both equations hold again, and the speed at touch is l^(5/4) times as large:
        per part of it s changes by t/5 s', and s' by s'/5 + t/5 s''.
        """
        depth, rate = self.normal_at(t)
        contact = self.contact()[0]
        spring = motion.spring
        x = self.coordinate(spring, motion.leg, depth / contact.depth, rate / contact.speed)[1]
        pace = spring.pace(motion.leg, x)
        s, slope, _ = motion.at(x)
        slip = slope * pace
        stiff = arb_of(Fraction(7, 2) * self.stiffness_ratio * self.stiffness / self.mass)
        slowing = -stiff * root(depth) * s
        f, g, df, dg = spring.basis(motion.leg, x)
        fifth = t / 5
        stretches = [slip, fifth * slip, f, g]
        slips = [slowing, slip / 5 + fifth * slowing, df * pace, dg * pace]
        (x1, v1), (x2, v2) = self.along_errors(t)
        none = arb(0)
        one = arb(1)
        part = arb_of(Fraction(2, 7))
        kept = arb_of(Fraction(5, 7))
        radius = arb_of(self.radius)
        row_x = [x1, x2, none, none, none, none]
        row_y = [*(part * value for value in stretches), kept * t, one]
        row_vx = [v1, v2, none, none, none, none]
        row_vy = [*(part * value for value in slips), kept, none]
        row_omega = [*(kept * value / radius for value in slips), -kept / radius, none]
        row_stretch = [*stretches, none, none]
        return [row_x, row_y, row_vx, row_vy, row_omega, row_stretch]
