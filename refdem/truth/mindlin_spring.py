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

from refdem.truth.balls import UndecidedError, arb_of
from refdem.truth.dual import slopes_of
from refdem.truth.hypergeometric import two_f_one
from refdem.truth.power_contact import PowerContact

NEAR = Fraction(3, 4)
"""The scaled overlap D at which legs meet."""
INWARD = 0
"""Number of the leg on which the sphere approaches the wall."""
TURNING = 1
"""Number of the leg about the largest overlap, where the rate changes its sign."""
OUTWARD = 2
"""The legs of a contact in order of time; x is D, -u and -D on them."""


def _ratio(numerator: int, denominator: int) -> arb:
    """The ball of a quotient of whole numbers."""
    return arb_of(Fraction(numerator, denominator))


class MindlinSpring:
    """Stretches [m] and their derivatives by the coordinate x of a leg, in a contact at the current
    precision.

    `ratio` is k_t/k, so that `q` = 7/10 of it; `a` and `b` are the roots of x^2 - x/10 - q.
    `turns_at` is |u| where D = NEAR.
    """

    def __init__(self, contact: PowerContact, ratio: Fraction) -> None:
        self.contact = contact
        self.q = arb_of(Fraction(7, 10) * ratio)
        # x = 1/20 +- sqrt(1/400 + q).
        half_difference = (_ratio(1, 400) + self.q).sqrt()
        self.a = _ratio(1, 20) + half_difference
        self.b = _ratio(1, 20) - half_difference
        self.turns_at = (1 - power_five_halves(arb_of(NEAR))).sqrt()

    def ends(self, leg: int) -> tuple[arb, arb]:
        """The first and the last x of a leg of the contact."""
        near = arb_of(NEAR)
        if leg == INWARD:
            return arb(0), near
        if leg == TURNING:
            return -self.turns_at, self.turns_at
        return -near, arb(0)

    def place(self, leg: int, x: arb) -> tuple[arb, arb]:
        """The scaled overlap D and its rate u at x of a leg: D^(5/2) + u^2 = 1."""
        if leg == TURNING:
            return (1 - x * x) ** _ratio(2, 5), -x
        depth, sense = depth_of(leg, x)
        return depth, (1 - power_five_halves(depth)).sqrt() * sense

    def coordinate(self, depth: arb, rate: arb) -> tuple[int, arb]:
        """The leg and x of a scaled overlap D and its rate u; either leg where two meet."""
        if depth <= arb_of(NEAR):
            if rate > 0:
                return (INWARD, depth)
            return (OUTWARD, -depth)
        return TURNING, -rate

    def time(self, leg: int, x: arb) -> arb:
        """The time [s] since touch at x of a leg."""
        if leg == TURNING:
            return self.contact.half + self.contact.unit * self.contact.before_turn(x)
        depth, _ = depth_of(leg, x)
        since = arb(0)
        if depth != 0:
            since = self.contact.unit * self.contact.since_touch(depth)
        if leg == INWARD:
            return since
        # The way out mirrors the way in.
        return 2 * self.contact.half - since

    def pace(self, leg: int, x: arb) -> arb:
        """The rate dx/dt [1/s] at x of a leg: u on the way in, -u on the way out, and -u' = 5/4
        D^(3/2) about the turn, each in units of 1/`unit`.
        """
        depth, rate = self.place(leg, x)
        if leg == TURNING:
            return _ratio(5, 4) / self.contact.unit * depth * depth.sqrt()
        if leg == INWARD:
            return rate / self.contact.unit
        return -rate / self.contact.unit

    def basis(self, leg: int, x: arb) -> tuple[arb, arb, arb, arb]:
        """Two independent solutions f and g of the stretch's equation at x of a leg, and their
        derivatives by x: (f, g, f', g').

        They are the hypergeometric functions of the module.
        """
        a = self.a
        b = self.b
        if leg == TURNING:
            # f = 2F1(a, b; 1/2; u^2), g = u 2F1(3/5 - a, 3/5 - b; 3/2; u^2), with u^2 = x^2.
            u_squared = x * x
            c = _ratio(3, 5) - a
            d = _ratio(3, 5) - b
            even = two_f_one(a, b, _ratio(1, 2), u_squared)
            odd = x * two_f_one(c, d, _ratio(3, 2), u_squared)
            # f' = a b/(1/2) 2F1(a + 1, b + 1; 3/2; u^2) 2 x, with a b = -q.
            even_slope = -4 * self.q * x * two_f_one(a + 1, b + 1, _ratio(3, 2), u_squared)
            # (x 2F1(c, d; 3/2; x^2))' = 2F1(c, d; 1/2; x^2).
            odd_slope = two_f_one(c, d, _ratio(1, 2), u_squared)
            return even, odd, even_slope, odd_slope
        # f = 2F1(a, b; 3/5; z), g = D 2F1(a + 2/5, b + 2/5; 7/5; z), with z = D^(5/2).
        depth, sense = depth_of(leg, x)
        z = power_five_halves(depth)
        c = a + _ratio(2, 5)
        d = b + _ratio(2, 5)
        first = two_f_one(a, b, _ratio(3, 5), z)
        second = depth * two_f_one(c, d, _ratio(7, 5), z)
        # d 2F1(a, b; 3/5; z)/dD = a b/(3/5) 2F1(a + 1, b + 1; 8/5; z) dz/dD, with a b = -q.
        derivative = two_f_one(a + 1, b + 1, _ratio(8, 5), z)
        first_by_depth = -_ratio(25, 6) * self.q * depth * root(depth) * derivative
        # d (D 2F1(c, d; 7/5; z))/dD = 2F1(c, d; 2/5; z).
        second_by_depth = two_f_one(c, d, _ratio(2, 5), z)
        return first, second, sense * first_by_depth, sense * second_by_depth

    def bent(self, leg: int, x: arb, s: arb, slope: arb) -> arb:
        """The second derivative of the stretch s [m] by x, from s and its `slope`, by the equations
        of the module.
        """
        if leg == TURNING:
            # (1 - u^2) s_uu = 6/5 u s_u - 4 q s.
            return (_ratio(6, 5) * x * slope - 4 * self.q * s) / (1 - x * x)
        # (1 - z) s_DD = 5/4 D^(3/2) s_D - 25/4 q D^(1/2) s.
        depth, sense = depth_of(leg, x)
        by_slope = _ratio(5, 4) * depth * root(depth) * slope * sense
        by_stretch = _ratio(25, 4) * self.q * root(depth) * s
        return (by_slope - by_stretch) / (1 - power_five_halves(depth))

    def overlap(self, leg: int, x: arb) -> tuple[arb, arb, arb]:
        """The overlap d [m] and its first and second derivative by x."""
        largest = self.contact.depth
        if leg == INWARD:
            return (largest * x, largest, arb(0))
        if leg == OUTWARD:
            return (-largest * x, -largest, arb(0))
        # d = d_m w^(2/5) with w = 1 - x^2.
        w = 1 - x * x
        overlap = largest * w ** _ratio(2, 5)
        # d' = -4/5 x d/w, d'' = -4/5 (d/w) (1 + 6/5 x^2/w)
        first = -_ratio(4, 5) * x * overlap / w
        second = -_ratio(4, 5) * overlap / w * (1 + _ratio(6, 5) * x * x / w)
        return overlap, first, second


def depth_of(leg: int, x: arb) -> tuple[arb, int]:
    """The scaled overlap D at x of the way in or out, and dD/dx: 1 or -1."""
    if leg == INWARD:
        return x, 1
    return -x, -1


@dataclass(frozen=True)
class Stretched:
    """A stretch A f + B g of the `spring` on a leg; `first` is A, `second` B."""

    spring: MindlinSpring
    leg: int
    first: arb
    second: arb

    def at(self, x: arb) -> tuple[arb, arb, arb]:
        """The stretch s [m] and its first and second derivative by x."""
        f, g, df, dg = self.spring.basis(self.leg, x)
        s = self.first * f + self.second * g
        slope = self.first * df + self.second * dg
        return s, slope, self.spring.bent(self.leg, x, s, slope)

    def rate(self, x: arb) -> arb:
        """The rate ds/dt [m/s] at x."""
        _, slope, _ = self.at(x)
        return slope * self.spring.pace(self.leg, x)

    def beyond(self) -> "Stretched":
        """The same stretch on the next leg: s and its rate are continuous where the legs meet."""
        _, last = self.spring.ends(self.leg)
        first, _ = self.spring.ends(self.leg + 1)
        stretch, _, _ = self.at(last)
        return started(self.spring, self.leg + 1, first, stretch, self.rate(last))


def started(spring: MindlinSpring, leg: int, x: arb, s: arb, rate: arb) -> Stretched:
    """The solution on a leg with the stretch `s` [m] and its `rate` [m/s] at x."""
    f, g, df, dg = spring.basis(leg, x)
    # ds/dx = (ds/dt)/(dx/dt)
    slope = rate / spring.pace(leg, x)
    # Cramer's rule for first f + second g = s, first f' + second g' = slope.
    wronskian = f * dg - g * df
    first = (s * dg - g * slope) / wronskian
    second = (f * slope - s * df) / wronskian
    return Stretched(spring, leg, first, second)


def root(x: arb) -> arb:
    """The root sqrt(x) of numbers that are not negative, though the lower end of their ball may be,
    by rounding. UndecidedError where the derivatives that x carries are not bounded.
    """
    if x.lower() > 0:
        return x.sqrt()
    if slopes_of(x):
        raise UndecidedError("the derivative of a root at 0")
    if x == 0:
        return x.sqrt()
    return arb(0).union(arb(x.upper()).sqrt())


def power_five_halves(x: arb) -> arb:
    """The power x^(5/2) of numbers that are not negative, though the lower end of their ball may
    be. UndecidedError where that leaves out derivatives that x carries.
    """
    if x.lower() > 0 or x == 0:
        return x * x * root(x)
    if slopes_of(x):
        raise UndecidedError("the derivative of a power at 0")
    return arb(0).union(arb(x.upper()) ** _ratio(5, 2))
