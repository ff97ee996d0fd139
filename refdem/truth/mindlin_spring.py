"""A tangential spring whose stiffness grows as the root of the overlap, while a sphere sticks in
Hertz's contact: closed form.

The stretch obeys s'' = -(7 k_t/(2 m)) sqrt(d) s, as m d'' = -k d^(3/2) with d from touch (speed v)
to d_m and back. With D = d/d_m, u = d'/v, z = D^(5/2) = 1 - u^2, q = 7 k_t/(10 k) and a, b the
roots of x^2 - x/10 - q it is a hypergeometric equation,

    (1 - z) s_DD = 5/4 D^(3/2) s_D - 25/4 q D^(1/2) s,   (1 - u^2) s_uu = 6/5 u s_u - 4 q s,

    s = A 2F1(a, b; 3/5; z) + B D 2F1(a + 2/5, b + 2/5; 7/5; z) = A' 2F1(a, b; 1/2; u^2) + B' u
    2F1(3/5 - a, 3/5 - b; 3/2; u^2).

Each form is used where its argument is about 1/2 or less: D up to NEAR on the way in, u until D is
NEAR again, then D. On each of these legs the coordinate x = D, -u, -D grows with time, and
everything is analytic in it but for the root at D = 0.
"""

from dataclasses import dataclass
from fractions import Fraction

from flint import arb

from refdem.truth.balls import arb_of
from refdem.truth.power_contact import PowerContact

NEAR = Fraction(3, 4)
INWARD = 0
TURNING = 1
OUTWARD = 2


def _part(numerator: int, denominator: int) -> arb:
    return arb_of(Fraction(numerator, denominator))


class MindlinSpring:
    """Stretches [m] and their derivatives by the coordinate x of a leg, in a contact at the current
    precision.
    """

    def __init__(self, contact: PowerContact, ratio: Fraction) -> None:
        self.contact = contact
        self.q = arb_of(Fraction(7, 10) * ratio)
        root = (_part(1, 400) + self.q).sqrt()
        self.a, self.b = _part(1, 20) + root, _part(1, 20) - root
        self.turns_at = (1 - power_five_halves(arb_of(NEAR))).sqrt()

    def ends(self, leg: int) -> tuple[arb, arb]:
        """The first and the last x of a leg of the contact."""
        near = arb_of(NEAR)
        return ((arb(0), near), (-self.turns_at, self.turns_at), (-near, arb(0)))[leg]

    def place(self, leg: int, x: arb) -> tuple[arb, arb]:
        """The scaled overlap D and its rate u at x of a leg."""
        if leg == TURNING:
            return (1 - x * x) ** _part(2, 5), -x
        if leg == INWARD:
            depth = x
        else:
            depth = -x
        return depth, (1 - power_five_halves(depth)).sqrt() * (1 if leg == INWARD else -1)

    def coordinate(self, depth: arb, rate: arb) -> tuple[int, arb]:
        """Leg and x of a place, of either leg where two meet."""
        if depth <= arb_of(NEAR):
            if rate > 0:
                return (INWARD, depth)
            return (OUTWARD, -depth)
        return TURNING, -rate

    def time(self, leg: int, x: arb) -> arb:
        """The time [s] since touch at x of a leg."""
        if leg == TURNING:
            return self.contact.half + self.contact.unit * self.contact.before_turn(x)
        if leg == INWARD:
            depth = x
        else:
            depth = -x
        since = arb(0)
        if depth != 0:
            since = self.contact.unit * self.contact.since_touch(depth)
        if leg == INWARD:
            return since
        return 2 * self.contact.half - since

    def pace(self, leg: int, x: arb) -> arb:
        """The rate dx/dt [1/s] at x of a leg."""
        depth, rate = self.place(leg, x)
        if leg == TURNING:
            return _part(5, 4) / self.contact.unit * depth * depth.sqrt()
        return (rate if leg == INWARD else -rate) / self.contact.unit

    def basis(self, leg: int, x: arb) -> tuple[arb, arb, arb, arb]:
        """Two solutions, and their derivatives by x."""
        a = self.a
        b = self.b
        if leg == TURNING:
            w = x * x
            c = _part(3, 5) - a
            d = _part(3, 5) - b
            even = two_f_one(a, b, _part(1, 2), w)
            odd = x * two_f_one(c, d, _part(3, 2), w)
            even_slope = -4 * self.q * x * two_f_one(a + 1, b + 1, _part(3, 2), w)
            odd_slope = two_f_one(c, d, _part(1, 2), w)
            return even, odd, even_slope, odd_slope
        depth, sense = (x, 1) if leg == INWARD else (-x, -1)
        z = power_five_halves(depth)
        c = a + _part(2, 5)
        d = b + _part(2, 5)
        # d 2F1(a, b; 3/5; z)/dD = a b/(3/5) 2F1(a + 1, b + 1; 8/5; z) dz/dD, with a b = -q.
        steep = (
            -_part(25, 6) * self.q * depth * root(depth) * two_f_one(a + 1, b + 1, _part(8, 5), z)
        )
        return (
            two_f_one(a, b, _part(3, 5), z),
            depth * two_f_one(c, d, _part(7, 5), z),
            sense * steep,
            sense * two_f_one(c, d, _part(2, 5), z),
        )

    def bent(self, leg: int, x: arb, s: arb, slope: arb) -> arb:
        """The second derivative of the stretch s by x."""
        if leg == TURNING:
            return (_part(6, 5) * x * slope - 4 * self.q * s) / (1 - x * x)
        depth, sense = (x, 1) if leg == INWARD else (-x, -1)
        push = (
            _part(5, 4) * depth * root(depth) * slope * sense
            - _part(25, 4) * self.q * root(depth) * s
        )
        return push / (1 - power_five_halves(depth))

    def overlap(self, leg: int, x: arb) -> tuple[arb, arb, arb]:
        """d [m] and its derivatives by x."""
        size = self.contact.depth
        if leg != TURNING:
            if leg == INWARD:
                return (size * x, size, arb(0))
            return (-size * x, -size, arb(0))
        w = 1 - x * x
        depth = size * w ** _part(2, 5)
        return (
            depth,
            -_part(4, 5) * x * depth / w,
            -_part(4, 5) * depth / w * (1 + _part(6, 5) * x * x / w),
        )


@dataclass(frozen=True)
class Stretched:
    """A solution A f + B g on a leg."""

    spring: MindlinSpring
    leg: int
    first: arb
    second: arb

    def at(self, x: arb) -> tuple[arb, arb, arb]:
        """s [m] and its derivatives by x."""
        f, g, df, dg = self.spring.basis(self.leg, x)
        s = self.first * f + self.second * g
        slope = self.first * df + self.second * dg
        return s, slope, self.spring.bent(self.leg, x, s, slope)

    def rate(self, x: arb) -> arb:
        """The rate of stretch s' [m/s] at x."""
        return self.at(x)[1] * self.spring.pace(self.leg, x)

    def beyond(self) -> "Stretched":
        """The stretched spring, continued on the next leg."""
        last = self.spring.ends(self.leg)[1]
        first = self.spring.ends(self.leg + 1)[0]
        return started(self.spring, self.leg + 1, first, self.at(last)[0], self.rate(last))


def started(spring: MindlinSpring, leg: int, x: arb, s: arb, rate: arb) -> Stretched:
    """The solution with this stretch [m] and rate [m/s] at x."""
    f, g, df, dg = spring.basis(leg, x)
    slope = rate / spring.pace(leg, x)
    # Cramer's rule for first f + second g = s, first f' + second g' = slope.
    wronskian = f * dg - g * df
    first = (s * dg - g * slope) / wronskian
    second = (f * slope - s * df) / wronskian
    return Stretched(spring, leg, first, second)


def two_f_one(a: arb, b: arb, c: arb, z: arb) -> arb:
    """Gauss's hypergeometric function 2F1(a, b; c; z)."""
    found: arb = z.hypgeom_2f1(a, b, c)
    return found


def root(x: arb) -> arb:
    """sqrt(x) of a ball of numbers that are not negative, though its lower end may be, by
    rounding.
    """
    if x.lower() > 0 or x == 0:
        return x.sqrt()
    return arb(0).union(arb(x.upper()).sqrt())


def power_five_halves(x: arb) -> arb:
    """The power x^(5/2), where x may touch zero."""
    if x.lower() > 0 or x == 0:
        return x * x * root(x)
    return arb(0).union(arb(x.upper()) ** _part(5, 2))
