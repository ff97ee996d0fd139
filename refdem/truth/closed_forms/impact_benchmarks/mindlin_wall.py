"""A sphere that touches the wall x = 0 under Hertz's law with a tangential spring (lever R),
clipped at Coulomb's limit: closed form.

The overlap d obeys m d'' = -k d^(3/2), whatever friction does (power_contact). The tangential force
is k_t sqrt(d) s with the stretch s, s' = slip = v_y + R omega, and is clipped at mu k d^(3/2): |s|
<= g d with g = mu k/k_t (`limit_slope`).

Slide. It slides from touch if |slip| > g d'. The slip falls by 7/2 mu times the normal impulse per
mass, v_n - d'; the spring is caught where the limit g d grows as fast as the slip would stretch it,
at the zero of a linear function of d'.

Stick. The stretch is that of mindlin_spring; where it comes to g d is proved by bisection and
interval Newton.

v_y - 2/5 R omega never changes. Not certified: a spring so near its limit that balls do not decide
on which side it is.

A contact has three legs (INWARD, TURNING, OUTWARD) with a coordinate x each, which grows with time
(mindlin_spring.py). `depth` and `rate` are d and d', scaled by their largest values d_m and v_n
where a leg and x are meant. The slip at the start is counted as positive; `side` has its sign.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from functools import partial

from flint import arb, arb_mat

from refdem.truth.balls import UndecidedError, arb_of
from refdem.truth.closed_form import ClosedForm, displaced_part, per_precision
from refdem.truth.closed_forms.impact_benchmarks.hertz_wall import (
    HERTZ,
    STATE,
    STILL,
    Strike,
    impact_constants,
)
from refdem.truth.events.crossing import Along, SwitchError, Watched, carried_crossing
from refdem.truth.exact import sign_of
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
from refdem.truth.smooth_flow import derivative_by_start

COORDINATES = (*STATE, "stretch")
"""The coordinates of an error that grows. The stretch is one of them, because it is part of the
state.
"""
MOST = 64
"""A contact with more phases is not followed."""


@dataclass(frozen=True)
class Sliding:
    """A slide: the spring at its limit on a side, from `x` on a leg on, with the slip [m/s] there.

    With u = d'/v_n, u0 at the start, slip = slip0 - side 7/2 mu v_n (u0 - u).
    """

    spring: MindlinSpring
    side: int
    leg: int
    x: arb
    slip: arb
    slowing: arb
    """7/2 mu."""

    def caught(self, slack: arb) -> tuple[int, arb] | None:
        """The leg and x where the slide ends, with `slack` = g; None if it lasts to the end.

        It ends where side slip = g d' = g v_n u, that is at u = (7/2 mu v_n u0 - side slip0)/((7/2
        mu - g) v_n), after which the limit grows faster than the slip could stretch the spring.
        Raises UndecidedError if balls do not separate that point from the end of the contact.
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
        # d/d_m = (1 - u^2)^(2/5), by the energy.
        depth = (1 - u * u) ** arb_of(Fraction(2, 5))
        return self.spring.coordinate(depth, u)

    def now(self, depth: arb, rate: arb, elapsed: arb) -> tuple[arb, arb]:
        """The slip [m/s], and its integral over time [m] since the start of the slide.

        `depth` and `rate` are the scaled d and d' now, `elapsed` [s] the time since the start. The
        integral of u0 - u over time is u0 elapsed - (d - d0)/v_n.
        """
        contact = self.spring.contact
        first_depth, first_rate = self.spring.place(self.leg, self.x)
        slowing = self.side * self.slowing
        impulse_integral = contact.speed * first_rate * elapsed - contact.depth * (
            depth - first_depth
        )
        displacement = self.slip * elapsed - slowing * impulse_integral
        slip = self.slip - slowing * contact.speed * (first_rate - rate)
        return slip, displacement


@dataclass(frozen=True)
class Phase:
    """A slide or a stick (on one leg), from the time `begin` [s] since touch on.

    `displacement` [m] is the integral of the slip from touch until then, `stretch` [m] that of the
    spring then: the two differ once the spring has slid.
    """

    begin: arb
    displacement: arb
    stretch: arb
    motion: Sliding | Stretched

    def now(self, leg: int, x: arb, spring: MindlinSpring) -> tuple[arb, arb]:
        """The slip [m/s], and its integral over time since touch [m], at x of a leg."""
        if isinstance(self.motion, Sliding):
            depth, rate = spring.place(leg, x)
            elapsed = spring.time(leg, x) - self.begin
            slip, displacement = self.motion.now(depth, rate, elapsed)
            return slip, self.displacement + displacement
        # While it sticks the slip stretches the spring: s' = ds/dx dx/dt.
        stretch, slope, _ = self.motion.at(x)
        return slope * spring.pace(leg, x), self.displacement + stretch - self.stretch


@dataclass(frozen=True)
class MindlinWallImpact(ClosedForm):
    """The truth of an impact: position [m], velocity [m/s], angular velocity [rad/s] at t >= 0.

    `friction` mu and `stiffness_ratio` k_t/k are not 0. At t = 0 the sphere touches the wall with
    the velocity (`normal`, `across`, 0) and the spin about z.
    """

    state = STATE
    method = (
        "closed form: incomplete beta function along, 2F1 across while it sticks; switches proved"
        " by bisection and interval Newton"
    )
    witness = "Taylor integration in w = sqrt(overlap), switches found anew"

    strike: Strike
    stiffness_ratio: Fraction

    displaced = displaced_part("strike")
    jacobian = derivative_by_start

    @per_precision
    def phases(self) -> list[Phase]:
        """Every phase of the contact in order of time, a stick by its legs.

        Raises UndecidedError if balls do not separate the slip from the rate of the limit at touch,
        SwitchError for a contact of more than MOST phases.
        """
        contact, _ = self.strike.contact()
        spring = MindlinSpring(contact, self.stiffness_ratio)
        # A displaced start may overlap already; its spring is not stretched then either.
        overlap = self.strike.begin[0] + self.strike.radius
        slip = arb_of(self.strike.slip_size())
        zero = arb(0)
        if overlap > 0:
            x = arb_of(overlap) / contact.depth
        else:
            # Touch is at D = 0 for all parameters.
            x = zero
        rate = spring.place(INWARD, x)[1] * contact.speed
        slides = slip > self.limit_slope() * rate
        if not slides and not slip < self.limit_slope() * rate:
            raise UndecidedError("whether it slides from touch on")
        motion: Sliding | Stretched
        if slides:
            motion = self.sliding(spring, 1, INWARD, x, slip)
        else:
            motion = started(spring, INWARD, x, zero, slip)
        phases = [Phase(spring.time(INWARD, x), zero, zero, motion)]
        # `at_limit` selects the margins that are 0 where a stick begins; see `guard`.
        if not slides and overlap <= 0:
            at_limit = 1
        else:
            at_limit = 0
        while len(phases) < MOST:
            last = phases[-1]
            if isinstance(last.motion, Sliding):
                after = self.after_slide(last)
            else:
                after = self.after_stick(last, x, at_limit)
            if after is None:
                return phases
            phase, x, at_limit = after
            phases.append(phase)
        raise SwitchError("end", "the contact has more phases than are phases_and_legs", 0.0)

    def limit_slope(self) -> arb:
        """g = mu k/k_t: the stretch at Coulomb's limit is g d."""
        return arb_of(self.strike.friction / self.stiffness_ratio)

    def sliding(self, spring: MindlinSpring, side: int, leg: int, x: arb, slip: arb) -> Sliding:
        """The slide to a side that begins at x of a leg with this slip [m/s]."""
        return Sliding(spring, side, leg, x, slip, arb_of(Fraction(7, 2) * self.strike.friction))

    def after_slide(self, last: Phase) -> tuple[Phase, arb, int] | None:
        """The stick after a slide, the x where it begins, and `at_limit`; None if there is none.

        It begins with the stretch side g d and its rate side g d'.
        """
        assert isinstance(last.motion, Sliding)
        spring = last.motion.spring
        side = last.motion.side
        place = last.motion.caught(self.limit_slope())
        if place is None:
            return None
        leg, x = place
        overlap = spring.overlap(leg, x)[0]
        stretch = side * self.limit_slope() * overlap
        rate = side * self.limit_slope() * spring.contact.speed * spring.place(leg, x)[1]
        begin = spring.time(leg, x)
        displacement = last.now(leg, x, spring)[1]
        stick = started(spring, leg, x, stretch, rate)
        return Phase(begin, displacement, stretch, stick), x, 2 * side

    def after_stick(self, last: Phase, x: arb, at_limit: int) -> tuple[Phase, arb, int] | None:
        """The phase after a stick that begins at x, the x where that begins, and its `at_limit`.

        It is a slide where the stretch comes to its limit; a stick that lasts to the end of its leg
        continues on the next leg. None without slip, where no phase follows. At the end of the
        contact the limit is 0 and the stretch is not: the last phase is a slide.
        """
        motion = last.motion
        assert isinstance(motion, Stretched)
        spring = motion.spring
        end = motion.spring.ends(motion.leg)[1]
        if not self.strike.slip():
            return None
        guards = [self.guard(motion, side, x, at_limit) for side in (1, -1)]
        crossing = carried_crossing(guards, x, end)
        if crossing is None:
            if motion.leg == OUTWARD:
                raise UndecidedError("where the spring slips before the contact ends")
            next_leg = motion.beyond()
            begin = spring.time(motion.leg, end)
            displacement = last.now(motion.leg, end, spring)[1]
            stick = Phase(begin, displacement, motion.at(end)[0], next_leg)
            return stick, spring.ends(next_leg.leg)[0], 0
        name, x_slide = crossing
        side = int(name)
        begin = spring.time(motion.leg, x_slide)
        slip, displacement = last.now(motion.leg, x_slide, spring)
        stretch = side * self.limit_slope() * spring.overlap(motion.leg, x_slide)[0]
        slide = self.sliding(spring, side, motion.leg, x_slide, slip)
        return Phase(begin, displacement, stretch, slide), x_slide, 0

    def guard(self, motion: Stretched, side: int, x: arb, at_limit: int) -> Watched:
        """The margin g d - side s of a stick as a switching function, with its zero at the start.

        `at_limit` is 1 for a stick from touch on, where both margins have a simple zero; 2 side for
        one that follows a slide to that side, whose margin has a double zero there; else 0.
        """
        if at_limit == 1:
            zero_order = 1
        elif at_limit == 2 * side:
            zero_order = 2
        else:
            zero_order = 0
        margins: list[Along] = [partial(self.margin, motion, side, order) for order in range(3)]
        return Watched(str(side), margins[: max(2, zero_order + 1)], zero_order)

    def margin(self, motion: Stretched, side: int, order: int, x: arb) -> arb:
        """The margin g d - side s, or its derivative by x of an order up to 2."""
        overlap = motion.spring.overlap(motion.leg, x)[order]
        stretch = motion.at(x)[order]
        return self.limit_slope() * overlap - side * stretch

    def across(self, t: arb) -> tuple[arb, arb]:
        """The slip [m/s] at t, and its integral over time [m] since the start.

        Both with the slip at the start counted as positive. Before and after the contact the slip
        is constant.
        """
        contact, touch = self.strike.contact()
        since = t - touch
        first_slip = arb_of(self.strike.slip_size())
        if touch > 0:
            free_time = touch
        else:
            free_time = arb(0)
        if not since > self.phases()[0].begin:
            return first_slip, first_slip * t
        if since < 2 * contact.half:
            depth, rate = contact.state(since)
            phase = self.phase(since)
            spring = phase.motion.spring
            if isinstance(phase.motion, Stretched):
                leg = phase.motion.leg
            else:
                leg = None
            leg, x = self.coordinate(spring, leg, depth / contact.depth, rate / contact.speed)
            slip, displacement = phase.now(leg, x, spring)
            return slip, first_slip * free_time + displacement
        phase = self.phases()[-1]
        # Without slip the spring is never stretched.
        if isinstance(phase.motion, Stretched):
            return first_slip, first_slip * t
        slip, displacement = phase.now(OUTWARD, arb(0), phase.motion.spring)
        parted_for = since - 2 * contact.half
        return slip, first_slip * free_time + displacement + slip * parted_for

    def coordinate(
        self, spring: MindlinSpring, leg: int | None, depth: arb, rate: arb
    ) -> tuple[int, arb]:
        """The leg and its coordinate x of a scaled overlap and rate.

        A given `leg` is returned unchanged: near its ends balls would not decide between two legs.
        """
        if leg is None:
            return spring.coordinate(depth, rate)
        return leg, (depth, -rate, -depth)[leg]

    def phase(self, since: arb) -> Phase:
        """The phase that is under way at a time [s] since touch; UndecidedError if balls do not
        decide which one it is.
        """
        current = None
        for phase in self.phases():
            if since >= phase.begin:
                current = phase
            elif not since < phase.begin:
                raise UndecidedError("whether it sticks or slips")
        if current is None:
            raise UndecidedError("whether it touches yet")
        return current

    def evaluate(self, t: arb) -> dict[str, arb]:
        """STATE at time t, and zeros for the other components.

        v_y = 2/7 slip + 5/7 w with slip = v_y + R omega, and w = v_y - 2/5 R omega constant; y is
        the integral of that.
        """
        _, y, _, vy, spin = (arb_of(value) for value in self.strike.begin)
        depth, rate = self.strike.normal(t)
        side = sign_of(self.strike.slip())
        radius = arb_of(self.strike.radius)
        slip, displacement = self.across(t)
        w = vy - arb_of(Fraction(2, 5)) * radius * spin
        two_sevenths = arb_of(Fraction(2, 7))
        velocity_y = (side * slip * two_sevenths) + w * (1 - two_sevenths)
        position_y = y + side * displacement * two_sevenths + w * (1 - two_sevenths) * t
        omega = (side * slip - velocity_y) / radius
        state = (depth - radius, position_y, rate, velocity_y, omega)
        return dict(zip((*STATE, *STILL), (*state, *(arb(0),) * 4), strict=True))

    def constants(self) -> dict[str, arb]:
        """The scalars of an impact (hertz_wall.impact_constants)."""
        return impact_constants(self)

    @per_precision
    def growth(self) -> Grows:
        """How errors of STATE grow, at all times; the spring takes part in it."""
        rows = Norm([1] * len(COORDINATES), [1] * len(STATE))
        count = len(COORDINATES)
        read = len(STATE)
        readings = arb_mat([[int(i == j) for j in range(count)] for i in range(read)])
        return Growth(
            self.stretches(),
            rows,
            lambda t: readings,
            error_coordinates=range(read),
            step=narrow(1 / self.strike.contact()[0].half),
        )

    def stretches(self) -> Iterator[Stretch]:
        """The stretches of time along which errors of COORDINATES grow smoothly, in scales.

        Free flight, every leg of every phase, and free flight again. The force on the sphere is
        continuous at every switch, so that errors of the state jump nowhere. The stretch s of the
        spring begins with 0 where the overlap d does, which an error of d moves by -dd/d' in time,
        and it is side g d where a slide ends; while it slides it has no effect. An error at touch
        itself either changes when the sphere touches or leaves some overlap and no stretch: the
        free motion before the start has the former.
        """
        contact, touch = self.strike.contact()
        if not touch.is_zero():
            raise UndecidedError("a start that does not touch yet, or overlaps")
        # A short flight before touch, of any length.
        flight = arb(2) ** -12 * self.dyadic_half()
        phases = self.phases_and_legs()
        slip = arb_of(self.strike.slip_size())
        # A stick from touch on: ds = s' dt = slip dd/d'.
        if isinstance(phases[0].motion, Stretched):
            stretch_by_overlap = slip / contact.speed
        else:
            stretch_by_overlap = arb(0)
        free = partial(self.sliding_errors, 0)
        at_touch = self.spring_reset(stretch_by_overlap)
        yield self.stretch(free, -flight, arb(0), at_touch, flies=True)
        for phase, after in zip(phases, [*phases[1:], None], strict=True):
            if after is None:
                end = 2 * contact.half
            else:
                end = after.begin
            motion = phase.motion
            if isinstance(motion, Sliding):
                # The stick that follows begins with s = side g d.
                if after is not None:
                    stretch_by_overlap = motion.side * self.limit_slope()
                else:
                    stretch_by_overlap = arb(0)
                errors = partial(self.sliding_errors, motion.side)
                jump = self.spring_reset(stretch_by_overlap)
                yield self.stretch(errors, phase.begin, end, jump)
                continue
            errors = partial(self.sticking_errors, motion)
            if after is not None and isinstance(after.motion, Stretched):
                # The next leg of the same stick: nothing jumps.
                yield self.stretch(errors, phase.begin, end, None)
            else:
                yield self.stretch(errors, phase.begin, end, self.spring_reset(arb(0)))
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
        """The stretch of time from `begin` to `end` [s since touch; None for ever] for S.

        `errors` gives at a time a matrix of independent errors of COORDINATES, as columns; `jump`
        maps an error across the end, None for no jump. `flies`: nothing touches.
        """

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

    def phases_and_legs(self) -> list[Phase]:
        """The phases; without slip, where `phases` has only the first leg, all three legs of a
        spring that is never stretched.
        """
        phases = list(self.phases())
        motion = phases[-1].motion
        while isinstance(motion, Stretched) and motion.leg != OUTWARD:
            # The next leg begins at the time at which this one ends.
            _, leg_end = motion.spring.ends(motion.leg)
            begin = motion.spring.time(motion.leg, leg_end)
            motion = motion.beyond()
            phases.append(Phase(begin, arb(0), arb(0), motion))
        return phases

    def dyadic_half(self) -> arb:
        """An exact number near the time [s] from touch to the largest overlap."""
        return self.strike.contact()[0].half.mid()

    @per_precision
    def sizes(self) -> list[arb]:
        """The scales of COORDINATES; that of the stretch is the one of y."""
        return [arb_of(self.scale[name]) for name in (*STATE, "r.y")]

    def spring_reset(self, slope: arb) -> arb_mat:
        """The jump, in scales, after which the error of the stretch is `slope` times that of x."""
        count = len(COORDINATES)
        rows = [[arb(int(i == j)) for j in range(count)] for i in range(count)]
        sizes = self.sizes()
        rows[-1] = [slope * sizes[0] / sizes[-1], *[arb(0)] * (count - 1)]
        return arb_mat(rows)

    def quick_with_spring(self, begin: arb, times: arb) -> float:
        """A bound of the norm of the field's Jacobian, in scales, in every phase of the contact.

        At a ball of times [s] since `begin`.

        The force per mass across is (k_t/m) sqrt(d) s with |s| <= g d, g k_t = mu k, or mu (k/m)
        d^(3/2): its derivative by d is at most 3/2 mu (k/m) sqrt(d), that by s (k_t/m) sqrt(d). The
        overlap d is at most what it would be at its first speed from touch on, or to the end.
        """
        contact, _ = self.strike.contact()
        since_touch = (begin + times).upper()
        until_end = (2 * contact.half - begin - times).upper()
        nearest_end = arb.max(arb(0), arb.min(since_touch, until_end))
        overlap = arb.min(contact.depth, contact.speed * nearest_end)
        by_root, constant = self.quick_parts()
        return most([constant, by_root * overlap.sqrt()]) * UPWARDS

    @per_precision
    def quick_parts(self) -> tuple[arb, arb]:
        """Row sums of the Jacobian in scales: the largest of the velocities' rows per sqrt(d), and
        the largest of the rows of position and stretch.

        Velocities: (3/2)(k/m) for v_x by x; mu times that by x, and k_t/m by s, for v_y; 5/(2 R) as
        much for omega.
        """
        x, y, vx, vy, spin, stretch = self.sizes()
        k_over_m = arb_of(self.strike.stiffness / self.strike.mass)
        normal = arb_of(HERTZ) * k_over_m * x
        across = (
            arb_of(self.strike.friction) * normal
            + arb_of(self.stiffness_ratio) * k_over_m * stretch
        )
        radius = arb_of(self.strike.radius)
        turning = across * arb_of(Fraction(5, 2)) / (radius * spin)
        by_root = most([normal / vx, across / vy, turning])
        constant = most([vx / x, vy / y, (vy + radius * spin) / stretch])
        return arb(by_root) * arb(UPWARDS), arb(constant) * arb(UPWARDS)

    def quick_in_flight(self, times: arb) -> float:
        """The same where nothing touches, and the stretch stays what it is."""
        x, y, vx, vy, _, _ = self.sizes()
        return most([vx / x, vy / y]) * UPWARDS

    def along_errors(self, t: arb) -> list[tuple[arb, arb]]:
        """Two independent errors (of d, of d') of the normal motion at t [s since touch].

        A shift in time, and a change of the speed at touch v_n per part of it (line_growth.py):
        overlap goes with v_n^(4/5).
        """
        depth, rate = self.strike.normal_at(t)
        acceleration = arb(0)
        if depth > 0:
            acceleration = -arb_of(self.strike.stiffness / self.strike.mass) * depth * depth.sqrt()
        power = arb_of(Fraction(4, 5))
        columns = homogeneous(depth, rate, acceleration, t, power, arb(1)).table()
        (x1, x2), (v1, v2) = columns
        return [(x1, v1), (x2, v2)]

    def sliding_errors(self, side: int, t: arb) -> list[list[arb]]:
        """Six independent errors of COORDINATES, as columns, at a time t [s] since touch.

        While it slides (side 0: flies), v_y' = side mu v_x' and omega' = 5/(2 R) v_y': two of the
        normal motion with what friction makes of them, one each of y, v_y, omega and the stretch.
        """
        mu = arb_of(side * self.strike.friction)
        mu_turn = mu * arb_of(Fraction(5, 2) / self.strike.radius)
        (x1, v1), (x2, v2) = self.along_errors(t)
        zero = arb(0)
        one = arb(1)
        row_x = [x1, x2, zero, zero, zero, zero]
        row_y = [mu * x1, mu * x2, one, t, zero, zero]
        row_vx = [v1, v2, zero, zero, zero, zero]
        row_vy = [mu * v1, mu * v2, zero, one, zero, zero]
        row_omega = [mu_turn * v1, mu_turn * v2, zero, zero, one, zero]
        row_stretch = [zero, zero, zero, zero, zero, one]
        return [row_x, row_y, row_vx, row_vy, row_omega, row_stretch]

    def sticking_errors(self, motion: Stretched, t: arb) -> list[list[arb]]:
        """Six independent errors of COORDINATES, as columns, at t [s since touch], in a stick.

        y = 2/7 s + 5/7 w t + constant, w = v_y - 2/5 R omega. The columns are: a shift in time, by
        which s changes by s' and s' by s''; a change of the speed at touch; the two solutions f, g
        of the spring (mindlin_spring.py); w; and y. As for the second: with l times the overlap and
        time l^(1/4) times as fast both equations hold again, and the speed at touch is l^(5/4)
        times as large; per part of it s changes by t/5 s', and s' by s'/5 + t/5 s''.
        """
        depth, rate = self.strike.normal_at(t)
        contact = self.strike.contact()[0]
        spring = motion.spring
        x = self.coordinate(spring, motion.leg, depth / contact.depth, rate / contact.speed)[1]
        pace = spring.pace(motion.leg, x)
        s, slope, _ = motion.at(x)
        slip = slope * pace
        # s'' = -(7 k_t/(2 m)) sqrt(d) s
        spring_rate = arb_of(
            Fraction(7, 2) * self.stiffness_ratio * self.strike.stiffness / self.strike.mass
        )
        slip_rate = -spring_rate * root(depth) * s
        f, g, df, dg = spring.basis(motion.leg, x)
        t_fifth = t / 5
        stretches = [slip, t_fifth * slip, f, g]
        slips = [slip_rate, slip / 5 + t_fifth * slip_rate, df * pace, dg * pace]
        (x1, v1), (x2, v2) = self.along_errors(t)
        zero = arb(0)
        one = arb(1)
        two_sevenths = arb_of(Fraction(2, 7))
        five_sevenths = arb_of(Fraction(5, 7))
        radius = arb_of(self.strike.radius)
        row_x = [x1, x2, zero, zero, zero, zero]
        row_y = [*(two_sevenths * value for value in stretches), five_sevenths * t, one]
        row_vx = [v1, v2, zero, zero, zero, zero]
        row_vy = [*(two_sevenths * value for value in slips), five_sevenths, zero]
        omegas = [five_sevenths * value / radius for value in slips]
        row_omega = [*omegas, -five_sevenths / radius, zero]
        row_stretch = [*stretches, zero, zero]
        return [row_x, row_y, row_vx, row_vy, row_omega, row_stretch]
