"""A contact whose force is a power of the overlap, m d'' = -k d^n, from touch at speed v to the
turn and back, in closed form.

With a = 1/(n+1), d_m = ((n+1) m v^2/(2k))^a, y = d/d_m and s = d'/v the energy is y^(n+1) + s^2 =
1, so that time in units of d_m/v is

    y 2F1(1/2, a; 1+a; y^(n+1)) since touch,   2a s 2F1(1-a, 1/2; 3/2; s^2) before the turn,   a
    B(a, 1/2) in all up to there.

Each is solved for y or s where its argument is well below 1. The slopes, (1 - y^(n+1))^(-1/2) >= 1
and 2a (1 - s^2)^(a-1) >= 2a, make the residue of a root divided by the least slope a bound of its
error (mean value theorem). Hertz 1882: n = 3/2.
"""

from collections.abc import Callable
from fractions import Fraction

from flint import arb

from refdem.truth.balls import UndecidedError, arb_of
from refdem.truth.reals import Number

NEAR_TOUCH = Fraction(4, 5)
"""Up to this time, in units of d_m/v, the root is looked for in y: there y^(n+1) is below 0.6, and
beyond it s^2 below 0.55.
"""


class PowerContact:
    """The contact at the current precision; `speed` is that at touch."""

    def __init__(self, mass: Number, stiffness: Number, exponent: Fraction, speed: arb) -> None:
        self.part = 1 / (exponent + 1)
        self.a, self.power = arb_of(self.part), arb_of(exponent + 1)
        self.speed, self.ease = speed, arb_of((exponent + 1) * mass / (2 * stiffness))
        self.depth = (self.ease * speed * speed) ** self.a
        self.unit = self.depth / speed
        self.half = (
            self.unit
            * arb.pi().sqrt()
            * (1 + self.a).gamma()
            / (self.a + arb_of(Fraction(1, 2))).gamma()
        )

    def since_touch(self, y: arb) -> arb:
        """Time since touch [d_m/v] on the way in."""
        found: arb = y * (y**self.power).hypgeom_2f1(arb_of(Fraction(1, 2)), self.a, 1 + self.a)
        return found

    def before_turn(self, s: arb) -> arb:
        """Time to the turn [d_m/v] on the way in."""
        found: arb = (
            2
            * self.a
            * s
            * (s * s).hypgeom_2f1(1 - self.a, arb_of(Fraction(1, 2)), arb_of(Fraction(3, 2)))
        )
        return found

    def state(self, t: arb) -> tuple[arb, arb]:
        """Overlap [m] and its rate [m/s] at t since touch, while it lasts."""
        left = self.half - t
        if not (left >= 0 or left <= 0):
            return self.near_turn(left)
        inward, outward = (t, 1) if left >= 0 else (2 * self.half - t, -1)
        if inward > 0 or inward == 0:
            if inward / self.unit < arb_of(NEAR_TOUCH):
                return self.near_touch(inward, outward)
            return self.near_turn(left)
        raise UndecidedError(f"whether the spheres still touch at {t}")

    def near_touch(self, t: arb, sense: int) -> tuple[arb, arb]:
        """The state near touch, by y; `sense` is -1 on the way out."""
        if t == 0:
            return arb(0), sense * self.speed
        y = root(self.since_touch, lambda y: (1 - y**self.power).rsqrt(), t / self.unit, arb(1))
        return self.depth * y, sense * self.speed * (1 - y**self.power).sqrt()

    def near_turn(self, left: arb) -> tuple[arb, arb]:
        """The state near the turn, by s of either sign; `left` is the time to the turn."""
        s = root(
            self.before_turn,
            lambda s: 2 * self.a * (1 - s * s) ** (self.a - 1),
            left / self.unit,
            2 * self.a,
        )
        return self.depth * (1 - s * s) ** self.a, self.speed * s

    def elapsed(self, overlap: arb) -> arb:
        """Time since touch at an overlap on the way in, well before the turn."""
        return self.unit * self.since_touch(overlap / self.depth)


def touching(
    mass: Number, stiffness: Number, exponent: Fraction, overlap: Number, speed: Number
) -> tuple[PowerContact, arb]:
    """The contact of a start with this overlap (none, or a little of either sign) and speed, and
    the time of touch [s].
    """
    closing = arb_of(speed)
    if overlap <= 0:
        return PowerContact(mass, stiffness, exponent, closing), arb_of(-overlap / speed)
    power = arb_of(exponent + 1)
    energy = closing * closing + arb_of(2 * stiffness / mass) / power * arb_of(overlap) ** power
    contact = PowerContact(mass, stiffness, exponent, energy.sqrt())
    return contact, -contact.elapsed(arb_of(overlap))


def root(value: Callable[[arb], arb], slope: Callable[[arb], arb], goal: arb, least: arb) -> arb:
    """The x with value(x) = goal.

    `slope` >= `least` everywhere. Newton on midpoints, from a slope of 1; then the bound.
    """
    x = goal.mid() * 0
    apart = goal
    for _ in range(60):
        step = (apart / slope(x)).mid()
        x = (x + step).mid()
        before = apart
        apart = (goal - value(x)).mid()
        if apart == 0 or (abs(step) <= abs(x) * arb(2) ** -20 and abs(apart) >= abs(before)):
            break
    return x + arb(0, ((goal - value(x)) / least).abs_upper())
