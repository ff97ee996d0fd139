"""A contact whose force is a power of the overlap, m d'' = -k d^n, in closed form: from touch at
speed v to the turn and back.

Theorem: with a = 1/(n+1), d_m = ((n+1) m v^2/(2k))^a, y = d/d_m and s = d'/v the energy is y^(n+1)
+ s^2 = 1, and time in units of d_m/v is given by the formula below. Hertz 1882: n = 3/2.

Hypotheses, and where each is checked:

* the contact lasts at t: `PowerContact.state`, by balls; UndecidedError if they do not decide;
* a root of the formula is enclosed: its slopes, (1 - y^(n+1))^(-1/2) >= 1 and 2a (1 - s^2)^(a-1) >=
  2a, make the residue of a root divided by the least slope a bound of its error (mean value
  theorem, `root`). It is solved for y or s where its argument is well below 1 (`NEAR_TOUCH`).

Formula:

    y 2F1(1/2, a; 1+a; y^(n+1)) since touch,   2a s 2F1(1-a, 1/2; 3/2; s^2) before the turn,   a
    B(a, 1/2) in all up to there.
"""

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

from flint import arb

from refdem.truth.balls import UndecidedError, arb_of
from refdem.truth.dual import ball, carried, slopes_of
from refdem.truth.reals import Number

NEAR_TOUCH = Fraction(4, 5)
"""Up to this time, in units of d_m/v, the root is looked for in y: there y^(n+1) is below 0.6, and
beyond it s^2 below 0.55.
"""


@dataclass(frozen=True)
class PowerContact:
    """The contact at the current precision.

    `mass` m and `stiffness` k of the law with the exponent n; `speed` v [m/s] is that at touch.
    """

    mass: Number
    stiffness: Number
    exponent: Fraction
    speed: arb

    @cached_property
    def a(self) -> arb:
        """The inverse power a = 1/(n + 1)."""
        return arb_of(1 / (self.exponent + 1))

    @cached_property
    def power(self) -> arb:
        """The power n + 1 of the energy."""
        return arb_of(self.exponent + 1)

    @cached_property
    def depth(self) -> arb:
        """The largest overlap d_m = ((n+1) m v^2/(2k))^a [m], a = 1/(n+1)."""
        ease = arb_of((self.exponent + 1) * self.mass / (2 * self.stiffness))
        return (ease * self.speed * self.speed) ** self.a

    @cached_property
    def unit(self) -> arb:
        """The unit d_m/v [s] of time."""
        return self.depth / self.speed

    @cached_property
    def half(self) -> arb:
        """The time [s] from touch to the turn."""
        # (d_m/v) a B(a, 1/2), and a B(a, 1/2) = sqrt(pi) Gamma(1 + a)/Gamma(a + 1/2).
        gamma = (1 + self.a).gamma()
        half_gamma = (self.a + arb_of(Fraction(1, 2))).gamma()
        return self.unit * arb.pi().sqrt() * gamma / half_gamma

    def since_touch(self, y: arb) -> arb:
        """The time since touch [d_m/v] on the way in: y 2F1(1/2, a; 1 + a; y^(n+1))."""
        half = arb_of(Fraction(1, 2))
        x = ball(y)
        elapsed: arb = x * (x**self.power).hypgeom_2f1(half, self.a, 1 + self.a)
        if not slopes_of(y):
            return elapsed
        return carried(elapsed, (self.slowness(x), y))

    def before_turn(self, s: arb) -> arb:
        """The time to the turn [d_m/v] on the way in: 2 a s 2F1(1 - a, 1/2; 3/2; s^2)."""
        half = arb_of(Fraction(1, 2))
        x = ball(s)
        series: arb = (x * x).hypgeom_2f1(1 - self.a, half, arb_of(Fraction(3, 2)))
        left: arb = 2 * self.a * x * series
        if not slopes_of(s):
            return left
        return carried(left, (self.turning_slowness(x), s))

    def state(self, t: arb) -> tuple[arb, arb]:
        """The overlap [m] and its rate [m/s] at t [s] since touch, while the contact lasts.

        UndecidedError where balls do not decide whether it still lasts.
        """
        before_turn = self.half - t
        if not (before_turn >= 0 or before_turn <= 0):
            # The ball holds the turn.
            return self.near_turn(before_turn)
        # The way out mirrors the way in: the time from touch, or to parting.
        if before_turn >= 0:
            from_touch = t
            sense = 1
        else:
            from_touch = 2 * self.half - t
            sense = -1
        if from_touch > 0 or from_touch == 0:
            if from_touch / self.unit < arb_of(NEAR_TOUCH):
                return self.near_touch(from_touch, sense)
            return self.near_turn(before_turn)
        raise UndecidedError(f"whether the spheres still touch at {t}")

    def near_touch(self, t: arb, sense: int) -> tuple[arb, arb]:
        """The state near touch, by y, `t` [s] after touch; `sense` is -1 on the way out, where `t`
        is the time to parting.
        """
        if t == 0:
            return self.speed * t, sense * self.speed
        # d = d_m y, d' = +-v sqrt(1 - y^(n+1)), with y from the time t v/d_m.
        y = root(self.since_touch, self.slowness, t / self.unit, arb(1))
        return self.depth * y, sense * self.speed * (1 - y**self.power).sqrt()

    def near_turn(self, left: arb) -> tuple[arb, arb]:
        """The state near the turn, by s of either sign; `left` [s] is the time to the turn."""
        # d = d_m (1 - s^2)^a, d' = v s, with s from the time (half - t) v/d_m to the turn.
        s = root(self.before_turn, self.turning_slowness, left / self.unit, 2 * self.a)
        return self.depth * (1 - s * s) ** self.a, self.speed * s

    def elapsed(self, overlap: arb) -> arb:
        """Time since touch at an overlap on the way in, well before the turn."""
        return self.unit * self.since_touch(overlap / self.depth)

    def slowness(self, y: arb) -> arb:
        """The derivative (1 - y^(n+1))^(-1/2) >= 1 of the time since touch by y."""
        return (1 - y**self.power).rsqrt()

    def turning_slowness(self, s: arb) -> arb:
        """The derivative 2 a (1 - s^2)^(a-1) >= 2 a of the time before the turn by s."""
        return 2 * self.a * (1 - s * s) ** (self.a - 1)


def touching(
    mass: Number, stiffness: Number, exponent: Fraction, overlap: Number, speed: Number
) -> tuple[PowerContact, arb]:
    """The contact of a start with this overlap [m] (none, or a little of either sign) and closing
    speed [m/s], and the time [s] of its touch, which is negative if the start overlaps.
    """
    closing = arb_of(speed)
    if overlap <= 0:
        return PowerContact(mass, stiffness, exponent, closing), arb_of(-overlap / speed)
    # The speed at touch: m v^2/2 = m speed^2/2 + k d^(n+1)/(n+1).
    power = arb_of(exponent + 1)
    energy = closing * closing + arb_of(2 * stiffness / mass) / power * arb_of(overlap) ** power
    contact = PowerContact(mass, stiffness, exponent, energy.sqrt())
    return contact, -contact.elapsed(arb_of(overlap))


def root(value: Callable[[arb], arb], slope: Callable[[arb], arb], goal: arb, least: arb) -> arb:
    """A ball of the x with value(x) = goal, for a function whose slope is at least `least`
    everywhere.

    Newton on midpoints, from x = 0, until the residual shrinks no more. Wherever it ends,
    |goal - value(x)|/least bounds the error (mean value theorem). The derivatives of x are those of
    the goal, divided by the slope.
    """
    aim = ball(goal)
    x = aim.mid() * 0
    residual = aim
    for _ in range(60):
        step = (residual / slope(x)).mid()
        # x <- x + (goal - value(x))/slope(x)
        x = (x + step).mid()
        before = residual
        residual = (aim - value(x)).mid()
        is_small = abs(step) <= abs(x) * arb(2) ** -20
        if residual == 0 or (is_small and abs(residual) >= abs(before)):
            break
    # |x - root| <= |goal - value(x)|/least, and d root/d goal = 1/slope(root).
    enclosed = x + arb(0, ((aim - value(x)) / least).abs_upper())
    return carried(enclosed, (1 / slope(enclosed), goal))
