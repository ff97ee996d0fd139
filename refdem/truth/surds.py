"""Numbers a + b sqrt(q) of one square root: the field Q(sqrt(q)), in which order is exact.

Two spheres on straight lines meet at a root of a quadratic with rational coefficients, so that the
place where they touch, the normal there, and whatever is polynomial in these, are such numbers.
"""

from dataclasses import dataclass
from fractions import Fraction
from typing import Union

from flint import arb

from refdem.truth.balls import Enclosed, UndecidedError, arb_of
from refdem.truth.dual import rational_root
from refdem.truth.exact import sign_of

Rational = Fraction | int


@dataclass(frozen=True)
class Surd(Enclosed):
    """rational + factor sqrt(square), square >= 0; + - * / with rationals and surds of one square.

    Comparison with 0 (`sign`) is exact: no precision is involved.
    """

    rational: Fraction
    factor: Fraction
    square: Fraction

    def ball(self) -> arb:
        """A ball that contains the number, at the current precision."""
        return arb_of(self.rational) + arb_of(self.factor) * arb_of(self.square).sqrt()

    def sign(self) -> int:
        """The sign -1, 0 or 1, which is exact.

        a + b sqrt(q) has the sign that a and b share; where they differ, that of the larger of a^2
        and b^2 q.
        """
        first = sign_of(self.rational)
        second = sign_of(self.factor) * sign_of(self.square)
        if first * second >= 0:
            return sign_of(first + second)
        # a^2 - b^2 q
        larger = self.rational**2 - self.factor**2 * self.square
        return first * sign_of(larger)

    def __add__(self, other: Union["Surd", Rational]) -> "Surd":
        if not isinstance(other, Surd):
            return Surd(self.rational + other, self.factor, self.square)
        return Surd(self.rational + other.rational, self.factor + other.factor, self.square)

    def __mul__(self, other: Union["Surd", Rational]) -> "Surd":
        if not isinstance(other, Surd):
            return Surd(self.rational * other, self.factor * other, self.square)
        # (a + b s) (c + d s) = a c + b d q + (a d + b c) s with s = sqrt(q).
        rational = self.rational * other.rational + self.factor * other.factor * self.square
        factor = self.rational * other.factor + self.factor * other.rational
        return Surd(rational, factor, self.square)

    def __neg__(self) -> "Surd":
        return self * -1

    def __sub__(self, other: Union["Surd", Rational]) -> "Surd":
        return self + -other

    def __rsub__(self, other: Rational) -> "Surd":
        return -self + other

    def __truediv__(self, other: Union["Surd", Rational]) -> "Surd":
        if not isinstance(other, Surd):
            return self * (Fraction(1) / other)
        # 1/(c + d s) = (c - d s)/(c^2 - d^2 q).
        conjugate = Surd(other.rational, -other.factor, other.square)
        norm = other.rational**2 - other.factor**2 * other.square
        return self * conjugate * (1 / norm)

    __radd__ = __add__
    __rmul__ = __mul__


Number = Fraction | Surd
"""An exact number: a rational, or one of a field with one square root."""


def sign(value: Number | arb) -> int:
    """The sign -1, 0 or 1 of an exact number, or of all numbers of a ball.

    UndecidedError for a ball that contains 0 and other numbers.
    """
    if isinstance(value, Surd):
        return value.sign()
    if isinstance(value, arb) and not (value > 0 or value < 0 or value == 0):
        raise UndecidedError(f"the sign of {value.str(8)} is not decided")
    return sign_of(value)


def surd(rational: Fraction, factor: Fraction, square: Fraction) -> Surd:
    """rational + factor sqrt(square); the root of a square of a rational is taken."""
    root = rational_root(square)
    if root is None:
        return Surd(rational, factor, square)
    return Surd(rational + factor * root, Fraction(0), square)
