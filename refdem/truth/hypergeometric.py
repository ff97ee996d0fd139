"""Gauss's hypergeometric function of dual balls: its derivatives by the argument and by all three
parameters.

Theorem: with the terms T_0 = 1, T_(n+1) = (a + n)(b + n) z/((c + n)(n + 1)) T_n of the power series
of 2F1(a, b; c; z), |z| < 1, the derivative by z is a b/c 2F1(a + 1, b + 1; c + 1; z), and the one
by a parameter is the sum of the derivatives of the terms. Let r < 1 bound the ratio |T_(n+1)/T_n|
from n = N on, and l the derivative of that ratio. Then |T_(N+k)| <= r^k |T_N|, and
|T'_(N+k)| <= r^k |T'_N| + k r^(k-1) l |T_N|, so that all terms from N on add up to at most

    |T'_N|/(1 - r) + l |T_N|/(1 - r)^2.

Hypotheses, and where each is checked:

* r bounds every ratio from N on: `Ratio.bound`, of factors that fall with n where c + N > 0;
* r < 1, and the remainder is below the working precision: `slope_by`, which takes more terms, at
  most MOST_TERMS, until both hold.
"""

from dataclasses import dataclass
from typing import Literal

from flint import arb, ctx

from refdem.truth.balls import UndecidedError
from refdem.truth.dual import ball, carried, slopes_of

MOST_TERMS = 2**15
"""Terms of a series at which adding more ends: 16384 bits need fewer where |z| <= 2/3."""
Which = Literal["a", "b", "c"]
"""The parameter that a derivative is by."""


def two_f_one(a: arb, b: arb, c: arb, z: arb) -> arb:
    """2F1(a, b; c; z), with the derivatives that its argument and its parameters carry."""
    ratio = Ratio(ball(a), ball(b), ball(c), ball(z))
    value: arb = ratio.z.hypgeom_2f1(ratio.a, ratio.b, ratio.c)
    parts = []
    # d 2F1(a, b; c; z)/dz = (a b/c) 2F1(a + 1, b + 1; c + 1; z)
    if slopes_of(z):
        raised = ratio.z.hypgeom_2f1(ratio.a + 1, ratio.b + 1, ratio.c + 1)
        parts.append((ratio.a * ratio.b / ratio.c * raised, z))
    if slopes_of(a):
        parts.append((slope_by(ratio, "a"), a))
    if slopes_of(b):
        parts.append((slope_by(ratio, "b"), b))
    if slopes_of(c):
        parts.append((slope_by(ratio, "c"), c))
    return carried(value, *parts)


@dataclass(frozen=True)
class Ratio:
    """The ratio (a + n)(b + n) z/((c + n)(n + 1)) of neighbouring terms of the series."""

    a: arb
    b: arb
    c: arb
    z: arb

    def at(self, n: int) -> arb:
        """The ratio of the term n + 1 to the term n."""
        return (self.a + n) * (self.b + n) / ((self.c + n) * (n + 1)) * self.z

    def slope(self, which: Which, n: int) -> arb:
        """The derivative of the ratio by a parameter.

        It is that of one factor, which may be 0 itself.
        """
        below = (self.c + n) * (n + 1)
        if which == "a":
            return (self.b + n) / below * self.z
        if which == "b":
            return (self.a + n) / below * self.z
        # 1/(c + n) has the derivative -1/(c + n)^2.
        return -self.at(n) / (self.c + n)

    def bound(self, which: Which, n: int) -> tuple[arb, arb]:
        """Bounds from n on of the sizes of the ratio and of its derivative by a parameter.

        |a + n|/(c + n) <= 1 + |a - c|/(c + n) and |b + n|/(n + 1) <= 1 + |b - 1|/(n + 1), which
        fall with n, for c + n > 0.
        """
        over_c = 1 + abs_upper(self.a - self.c) / (self.c + n)
        over_one = 1 + abs_upper(self.b - 1) / (n + 1)
        # The derivative is the ratio without its factor a + n or b + n, or the ratio over -(c + n).
        size = abs_upper(self.z)
        if which == "a":
            slope = over_one / (self.c + n)
        elif which == "b":
            slope = over_c / (n + 1)
        else:
            slope = over_c * over_one / (self.c + n)
        return over_c * over_one * size, slope * size


def abs_upper(x: arb) -> arb:
    """An exact number that |x| does not exceed."""
    bound: arb = x.abs_upper()
    return bound


def slope_by(ratio: Ratio, which: Which) -> arb:
    """The derivative of 2F1 by one parameter, the sum of the theorem with its remainder.

    UndecidedError if the remainder after MOST_TERMS terms exceeds the working precision.
    """
    term = arb(1)
    slope = arb(0)
    total = arb(0)
    least = arb(2) ** -ctx.prec
    for n in range(MOST_TERMS):
        # T'_(n+1) = ratio' T_n + ratio T'_n.
        slope = ratio.slope(which, n) * term + ratio.at(n) * slope
        term = ratio.at(n) * term
        if abs_upper(slope) + abs_upper(term) < least:
            rest = remainder(ratio, which, n + 1, term, slope)
            if rest is not None:
                return total + rest
        total += slope
    raise UndecidedError("the derivative of a hypergeometric series by a parameter")


def remainder(ratio: Ratio, which: Which, n: int, term: arb, slope: arb) -> arb | None:
    """A ball of the derivatives of all terms from n on, of which the first is `slope`; None where
    the ratio is not bounded below 1 yet.
    """
    if not ratio.c + n > 0:
        return None
    largest, change = ratio.bound(which, n)
    left = 1 - largest
    if not left > 0:
        return None
    # |T'_n|/(1 - r) + l |T_n|/(1 - r)^2, the bound of the theorem with N = n.
    size = abs_upper(slope) / left + change * abs_upper(term) / (left * left)
    return arb(0, abs_upper(size))
