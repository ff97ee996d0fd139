"""A rigid sphere, disc or ring that slides on a plane until it rolls: closed form, phase by phase.

x runs down the slope of angle a, gravity is g (sin a, -cos a), and the body turns about z with the
angular velocity omega. The point of contact slips with s = v + R omega. With J = f m R^2, Coulomb's
law gives, while it slides,

    v' = g sin a - mu g cos a sgn s,    R omega' = -(mu/f) g cos a sgn s,
    s' = g sin a - mu k g cos a sgn s,  k = 1 + 1/f = 1 + m R^2/J.

A slip s < 0, up the slope, always ends; a slip s > 0 ends if tan a < mu k. After that the body
rolls for all times if tan a <= mu k, with v' = g sin a/(1 + f); if tan a > mu k it slides down the
slope. All these cases are decided in exact arithmetic.

S: an error ds of the slip moves the end of the slip by -ds/s'. Where rolling begins, this changes
the errors of v and R omega to

    dv -> dv - f/(1 + f) ds,    R domega -> R domega - ds/(1 + f),    ds = dv + R domega,

for either sign of ds: the angular momentum about the line of contact, dv - f R domega, is kept, and
the slip becomes 0. In a body that rolls the same happens to an error at once. Where the friction
changes its sign, the derivative is

    dv -> dv - 2 mu/(tan a + mu k) ds,    R domega -> R domega - (2 mu/f)/(tan a + mu k) ds.

The derivative depends on the sign of the error in two cases. For tan a = mu k a slip s > 0 stays
for all times and a slip s < 0 ends at once. For s = 0 at the start and tan a > mu k the friction
changes its sign only for errors ds < 0. S is then the larger one of the two.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

from flint import arb, arb_mat

from refdem.core.parameters import Parameters
from refdem.core.truth import Truth
from refdem.truth.balls import arb_of
from refdem.truth.closed_form import ClosedForm, displaced_fields, per_precision
from refdem.truth.exact import numbers
from refdem.truth.growth import Grows, Growth, Norm, Stretch, narrow, smooth
from refdem.truth.impact_sequence import Largest
from refdem.truth.reals import Number, root
from refdem.truth.refiner import Refiner, Size

STATE = ("x", "vx", "omega")


@dataclass(frozen=True)
class Phase:
    """A part of the motion at constant accelerations, from `begin` [s] on.

    `place` [m], `speed` [m/s] and `spin` [rad/s] are those at the start, `acceleration` [m/s^2] and
    `spin_up` [rad/s^2] their constant rates. `side` is the sign of the slip, 0 while it rolls.
    """

    begin: Number
    side: int
    place: Number
    speed: Number
    spin: Number
    acceleration: Number
    spin_up: Number

    def after(self, t: Number) -> tuple[Number, Number, Number]:
        """Place [m], speed [m/s] and spin [rad/s] at the time t [s], exactly."""
        # x = x0 + v0 s + v' s^2/2,  v = v0 + v' s,  omega = omega0 + omega' s,  s = t - begin
        since = t - self.begin
        place = self.place + self.speed * since + self.acceleration * (since * since) / 2
        speed = self.speed + self.acceleration * since
        spin = self.spin + self.spin_up * since
        return place, speed, spin

    def at(self, t: arb) -> tuple[arb, arb, arb]:
        """Place [m], speed [m/s] and spin [rad/s] at the time t [s], as Arb balls."""
        since = t - arb_of(self.begin)
        gained = arb_of(self.acceleration) * since
        place = arb_of(self.place) + arb_of(self.speed) * since + gained * since / 2
        return place, arb_of(self.speed) + gained, arb_of(self.spin) + arb_of(self.spin_up) * since


@dataclass(frozen=True)
class Incline:
    """A round body on a plane: J = `inertia_factor` m R^2, and `slope` the tangent of the angle."""

    mass: Fraction
    radius: Fraction
    inertia_factor: Fraction
    friction: Fraction
    slope: Fraction
    gravity: Fraction

    @property
    def pressing(self) -> Number:
        """g cos a [m/s^2], with cos a = 1/sqrt(1 + tan^2 a)."""
        return self.gravity / root(1 + self.slope**2)

    @property
    def limit(self) -> Fraction:
        """mu k = mu (1 + m R^2/J), the tangent of the steepest slope on which it rolls."""
        return self.friction * (1 + 1 / self.inertia_factor)

    def sliding(self, side: int) -> tuple[Number, Number]:
        """The rates of v [m/s^2] and omega [rad/s^2] while the slip has the sign `side`."""
        # v' = g cos a (tan a - mu side),  omega' = -(mu side/(f R)) g cos a
        acceleration = self.pressing * (self.slope - self.friction * side)
        spin_up = self.pressing * (-side * self.friction / (self.inertia_factor * self.radius))
        return acceleration, spin_up

    def rolling(self) -> tuple[Number, Number]:
        """The rates of v and omega while it rolls: v' = g sin a/(1 + f), R omega' = -v'."""
        # g cos a tan a/(1 + f) = g sin a/(1 + f).
        acceleration = self.pressing * (self.slope / (1 + self.inertia_factor))
        return acceleration, acceleration * (-1 / self.radius)

    def rates(self, side: int) -> tuple[Number, Number]:
        """The rates of v and omega for a sign of the slip, 0 for rolling."""
        if side == 0:
            return self.rolling()
        return self.sliding(side)

    def side_after(self, slip: Fraction) -> int:
        """The sign of the slip right after a time at which it is `slip` [m/s]."""
        if slip > 0:
            return 1
        if slip < 0:
            return -1
        if self.slope > self.limit:
            return 1
        return 0

    def lasts(self, slip: Fraction) -> Number | None:
        """The duration [s] of a slip with the initial value `slip` [m/s]; None if it never ends.

        s' = g cos a (tan a - mu k sgn s), so that |s|' = -g cos a (mu k - tan a sgn s).
        """
        if slip > 0:
            closing = self.limit - self.slope
        else:
            closing = self.slope + self.limit
        if slip == 0 or self.friction == 0 or closing <= 0:
            return None
        # |s0|/(-|s|') with closing = mu k - tan a sgn s.
        return abs(slip) / (self.pressing * closing)

    def held(self) -> list[list[Fraction]]:
        """The map (3 x 3) of an error of (x, v, omega) where rolling begins, and in rolling."""
        f = self.inertia_factor
        radius = self.radius
        # ds = dv + R domega; v loses f/(1 + f) ds, and omega ds/((1 + f) R).
        return self.losing(f / (1 + f), 1 / (1 + f) / radius)

    def reversed(self) -> list[list[Fraction]]:
        """The map (3 x 3) of an error of (x, v, omega) where the friction changes its sign."""
        # v loses 2 mu/(tan a + mu k) ds, and omega (2 mu/(f R))/(tan a + mu k) ds.
        v_loss = 2 * self.friction / (self.slope + self.limit)
        return self.losing(v_loss, v_loss / (self.inertia_factor * self.radius))

    def losing(self, speed: Fraction, spin: Fraction) -> list[list[Fraction]]:
        """The matrix dv -> dv - speed ds, domega -> domega - spin ds with ds = dv + R domega."""
        one = Fraction(1)
        nothing = Fraction(0)
        return [
            [one, nothing, nothing],
            [nothing, 1 - speed, -speed * self.radius],
            [nothing, -spin, 1 - spin * self.radius],
        ]


@dataclass(frozen=True, kw_only=True)
class Rolling(ClosedForm):
    """x and y [m], vx and vy [m/s] of the centre and omega [rad/s] at t >= 0.

    Scalars: roll_time [s], roll_speed [m/s] and friction_work [J] where a slip ends and it rolls;
    reversal_time [s] where friction turns round.
    """

    method = "closed form in phases: uniform accelerations, decided exactly at their ends"
    witness = (
        "the angular momentum about the line of contact and the slip, whose zero is found by"
        " bisection (refdem/truth/witnesses/rolling.py)"
    )
    state = STATE

    incline: Incline
    place: Fraction = Fraction(0)
    speed: Fraction
    spin: Fraction

    displaced = displaced_fields("place", "speed", "spin")

    @property
    def slip(self) -> Fraction:
        """The slip s = v + R omega [m/s] at the start."""
        return self.speed + self.incline.radius * self.spin

    @cached_property
    def phases(self) -> list[Phase]:
        """The first phase and, if its slip ends, the second one, which has no end."""
        incline = self.incline
        side = incline.side_after(self.slip)
        start = (self.place, self.speed, self.spin)
        first = Phase(Fraction(0), side, *start, *incline.rates(side))
        ended = incline.lasts(self.slip)
        if ended is None:
            return [first]
        side_after = incline.side_after(Fraction(0))
        # The second phase begins in the state in which the first one ends, with the slip 0.
        second = Phase(ended, side_after, *first.after(ended), *incline.rates(side_after))
        return [first, second]

    def evaluate(self, t: arb) -> dict[str, arb]:
        """The state at t; where the ball t contains the end of a phase, the union of both."""
        first, *later = self.phases
        state: Sequence[arb] = first.at(t)
        for phase in later:
            begin = arb_of(phase.begin)
            if t <= begin:
                break
            after: Sequence[arb] = phase.at(t)
            if not t > begin:
                # The ball t contains the end of the phase: the state is in the union of both.
                after = tuple(a.union(b) for a, b in zip(state, after, strict=True))
            state = after
        place, speed, spin = state
        height = arb_of(self.incline.radius)
        return {"x": place, "y": height, "vx": speed, "vy": arb(0), "omega": spin}

    def constants(self) -> dict[str, arb]:
        """The time at which the slip ends, and the speed then; empty if the slip never ends."""
        if len(self.phases) == 1:
            return {}
        phase = self.phases[1]
        time = arb_of(phase.begin)
        if phase.side:
            return {"reversal_time": time}
        # Work of friction: mu N |s0| t/2 with N = m g cos a; |s0| t/2 is the path of the slip.
        force = arb_of(self.incline.mass * self.incline.friction) * arb_of(self.incline.pressing)
        work = force * arb_of(abs(self.slip)) * time / 2
        return {"roll_time": time, "roll_speed": arb_of(phase.speed), "friction_work": work}

    @per_precision
    def growth(self) -> Grows:
        """How errors of STATE grow; the larger growth if it depends on the sign of the error."""
        incline = self.incline
        held = self.scaled(incline.held())
        last = self.phases[-1].side
        if incline.friction == 0:
            return self.along(None)
        if last == 0:
            if incline.slope == incline.limit:
                return Largest([self.along(held), self.along(None)])
            return self.along(held)
        if self.slip == 0:
            # Errors ds < 0 at the start: the friction changes its sign at once.
            return Largest([self.along(None), self.along(self.scaled(incline.reversed()))])
        return self.along(None)

    def along(self, instant_map: arb_mat | None) -> Grows:
        """S along the phases; an error made in the last one undergoes `instant_map` at once."""
        # The scale of x over that of v [s].
        rate = 1 / self.ratio(0, 1)
        return Growth(self.stretches(instant_map), Norm([1] * len(STATE)), step=narrow(rate))

    def ratio(self, row: int, column: int) -> arb:
        """The scale of coordinate `column` over that of coordinate `row`.

        A matrix M between errors is M_ij scale_j/scale_i between errors in units of their scales.
        """
        return arb_of(self.scale[STATE[column]] / self.scale[STATE[row]])

    def scaled(self, rows: list[list[Fraction]]) -> arb_mat:
        """The matrix between errors of STATE, in units of their scales."""
        scaled = []
        for i, row in enumerate(rows):
            scaled.append([arb_of(entry) * self.ratio(i, j) for j, entry in enumerate(row)])
        return arb_mat(scaled)

    def stretches(self, instant_map: arb_mat | None) -> Iterator[Stretch]:
        """The phases, with the growth of errors in each and the matrix at the end of the first."""
        # Within a phase the accelerations are constant: dx(t) = dx + dv t, dv and domega constant.
        drift = self.ratio(0, 1)

        def uniform(t: arb) -> arb_mat:
            return arb_mat([[1, t * drift, 0], [0, 1, 0], [0, 0, 1]])

        if len(self.phases) == 1:
            yield smooth(arb(0), None, uniform, instant_map=instant_map, affine=True)
            return
        phase = self.phases[1]
        if phase.side == 0:
            jump = self.incline.held()
        else:
            jump = self.incline.reversed()
        begin = arb_of(phase.begin)
        yield smooth(arb(0), begin, uniform, jump=self.scaled(jump), affine=True)
        yield smooth(begin, None, uniform, instant_map=instant_map, affine=True)


def incline_of(p: Mapping[str, object]) -> Incline:
    """The body and the plane of the parameters."""
    names = ("mass", "radius", "inertia_factor", "friction", "slope", "gravity")
    return Incline(**numbers(p, *names))  # type: ignore[arg-type]


def truth(p: Parameters, scale: Mapping[str, Size]) -> Truth:
    """The truth of case rolling; `scale` of x, y, vx, vy and omega."""
    start = numbers(p, "speed", "spin")
    return Rolling(refiner=Refiner.of(scale), incline=incline_of(p), **start)
