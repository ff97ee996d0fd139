"""Real numbers that follow from exact parameters: pi, roots, sines, and what is computed from them.

A `Real` is not a rounded value. It is the way to a ball that contains the number at whatever
precision a proof works, so that a number derived from parameters (the dashpot of a restitution, a
mass with pi in it) is enclosed anew, and better, each time the precision rises.
"""

from collections.abc import Callable
from fractions import Fraction
from typing import Any, TypeGuard, Union

from flint import arb, ctx

from refdem.truth.balls import Enclosed, UndecidedError, arb_of, precision
from refdem.truth.dual import ball, plain, rational_root, slopes_of, stays_zero

Number = Union[Fraction, "Real"]
"""What a truth takes for a parameter: an exact rational, or a number that follows from exact ones.
"""

DECIDING = (64, 128, 256, 512, 1024, 2048, 4096, 8192, 16384)
"""The working precisions [bit] at which a sign is looked for, one after another."""
NEAR_BITS = 64
"""The bits to which the rounded value of a number is known: a few more than binary64 has."""


class Real(Enclosed):
    """A real number, given by a function `enclosed()` that returns a ball which contains it at the
    current precision.

    Sums, products, quotients and whole powers with exact rationals and other Reals are Reals; a
    comparison is proved, or raises UndecidedError. No precision can prove two such numbers equal,
    so that == means the same object.
    """

    __array_ufunc__ = None
    """None excludes numpy's element-wise operations, which would mix doubles with exact numbers."""

    def __init__(self, enclosed: Callable[[], arb]) -> None:
        self._enclosed = enclosed
        self._balls: dict[int, arb] = {}

    def ball(self) -> arb:
        """A ball that contains the number, at the current precision; kept for the next call."""
        bits = ctx.prec
        if bits not in self._balls:
            self._balls[bits] = self._enclosed()
        return self._balls[bits]

    def sign(self) -> int:
        """The sign -1, 0 or 1, proved; raises UndecidedError where no precision decides it."""
        for bits in DECIDING:
            with precision(bits):
                ball = self.ball()
            if ball > 0:
                return 1
            if ball < 0:
                return -1
            if ball == 0:
                return 0
        raise UndecidedError(f"the sign of a number that {DECIDING[-1]} bits do not tell from 0")

    def near(self) -> Fraction:
        """A rational within 2^-NEAR_BITS of the number, relative to its size; for scenes and step
        sizes, never for a proof.

        If no precision separates the number from 0, it is the midpoint of the last ball.
        """
        for bits in DECIDING[1:]:
            with precision(bits):
                ball = self.ball()
                is_near = ball.is_finite() and ball.rad() * arb(2) ** NEAR_BITS <= abs(ball.mid())
            if is_near:
                break
        mantissa, exponent = ball.mid().man_exp()
        return Fraction(int(mantissa)) * Fraction(2) ** int(exponent)

    def with_derivatives(self) -> "tuple[Real, tuple[Number, ...]]":
        """The number without its derivatives (dual.py), and these, () where it carries none."""

        def slope(k: int) -> Number:
            if self.ball_of_slope(k) == 0:
                return Fraction(0)
            return Real(lambda: self.ball_of_slope(k))

        count = len(slopes_of(self.ball()))
        return Real(lambda: ball(self.ball())), tuple(slope(k) for k in range(count))

    def ball_of_slope(self, k: int) -> arb:
        """A ball of the derivative by the parameter k."""
        slope: arb = slopes_of(self.ball())[k]
        return slope

    def __float__(self) -> float:
        return float(self.near())

    def __bool__(self) -> bool:
        return self.sign() != 0

    def __add__(self, other: Any) -> Any:
        """The sum; with an exact 0 the number itself, so that its kind (Root) stays."""
        if not is_number(other):
            return NotImplemented
        if is_zero(other):
            return self
        return Real(lambda: self.ball() + arb_of(other))

    def __mul__(self, other: Any) -> Any:
        """The product; with an exact 0 an exact 0, which no ball could prove."""
        if not is_number(other):
            return NotImplemented
        if is_zero(other):
            return Fraction(0)
        return Real(lambda: self.ball() * arb_of(other))

    def __truediv__(self, other: Any) -> Any:
        if is_number(other):
            return Real(lambda: self.ball() / arb_of(other))
        return NotImplemented

    def __rtruediv__(self, other: Any) -> Any:
        if not is_number(other):
            return NotImplemented
        if is_zero(other):
            return Fraction(0)
        return Real(lambda: arb_of(other) / self.ball())

    def __neg__(self) -> "Real":
        return Real(lambda: -self.ball())

    def __sub__(self, other: Any) -> Any:
        if is_number(other):
            return self + -other
        return NotImplemented

    def __rsub__(self, other: Any) -> Any:
        if is_number(other):
            return -self + other
        return NotImplemented

    def __pow__(self, power: int) -> Any:
        if isinstance(power, int):
            return Real(lambda: self.ball() ** power)
        return NotImplemented

    def __abs__(self) -> "Real":
        return Real(lambda: abs(self.ball()))

    def __lt__(self, other: Any) -> bool:
        if not is_number(other):
            return NotImplemented
        is_so: bool = (self - other).sign() < 0
        return is_so

    def __gt__(self, other: Any) -> bool:
        if not is_number(other):
            return NotImplemented
        is_so: bool = (self - other).sign() > 0
        return is_so

    def __le__(self, other: Any) -> bool:
        if not is_number(other):
            return NotImplemented
        is_so: bool = (self - other).sign() <= 0
        return is_so

    def __ge__(self, other: Any) -> bool:
        if not is_number(other):
            return NotImplemented
        is_so: bool = (self - other).sign() >= 0
        return is_so

    __radd__ = __add__
    __rmul__ = __mul__


class Root(Real):
    """The number side sqrt(square), for a rational `square` that is no square and a `side` of 1 or
    -1.

    Products, quotients and whole powers of such numbers are again such, or rational, and stay
    exact.
    """

    square: Fraction
    side: int

    def __mul__(self, other: Any) -> Any:
        """The product: sqrt(a) sqrt(b) = sqrt(a b), and with a rational r sqrt(r^2 a), of its
        sign.
        """
        if isinstance(other, Root):
            return self.side * other.side * root(self.square * other.square)
        if isinstance(other, int | Fraction) and other:
            if other > 0:
                side = self.side
            else:
                side = -self.side
            return signed_root(self.square * other * other, side)
        return super().__mul__(other)

    def inverse(self) -> "Root":
        """1/sqrt(square) = sqrt(1/square)."""
        return signed_root(1 / self.square, self.side)

    def __truediv__(self, other: Any) -> Any:
        """The quotient, as the product with the inverse."""
        if isinstance(other, Root):
            return self * other.inverse()
        if isinstance(other, int | Fraction) and other:
            return self * (Fraction(1) / other)
        return super().__truediv__(other)

    def __rtruediv__(self, other: Any) -> Any:
        if is_number(other):
            return self.inverse() * other
        return NotImplemented

    def __neg__(self) -> "Root":
        return signed_root(self.square, -self.side)

    def __pow__(self, power: int) -> Any:
        """The whole power, which is rational where `power` is even."""
        # (side sqrt(square))^(2 half + odd) = square^half (side sqrt(square))^odd, as side^2 = 1.
        half, odd = divmod(power, 2)
        even_power = self.square**half
        if odd:
            return even_power * self
        return even_power

    __rmul__ = __mul__


def signed_root(square: Fraction, side: int) -> Root:
    """The number side sqrt(square), of a rational that is no square."""
    number = Root(lambda: side * arb_of(square).sqrt())
    number.square = square
    number.side = side
    return number


def is_number(value: object) -> TypeGuard[int | Number]:
    """True if the value is exact: a whole number, a Fraction or a Real; neither a truth value nor
    anything rounded is.
    """
    return isinstance(value, int | Fraction | Real) and not isinstance(value, bool)


def is_zero(value: object) -> bool:
    """True if the value is the rational 0 without derivatives, for certain and without a proof."""
    return isinstance(value, int | Fraction) and stays_zero(value)


def near(value: Number) -> Fraction:
    """The number itself if it is rational, else a rational near it; for step sizes and units, never
    for a proof.
    """
    if isinstance(value, Real):
        return value.near()
    return plain(value)


def with_derivatives(value: Number) -> tuple[Number, tuple[Number, ...]]:
    """A number without its derivatives, and these, () where it carries none."""
    if isinstance(value, Real):
        return value.with_derivatives()
    return plain(value), slopes_of(value)


def pi() -> Real:
    """The number pi, as a real of any precision."""
    return Real(arb.pi)


def root(value: Number) -> Number:
    """The root sqrt(value) of value >= 0; a Fraction where that is one."""
    if isinstance(value, Real):
        return Real(lambda: value.ball().sqrt())
    rational = rational_root(value)
    if rational is None:
        return signed_root(value, 1)
    return rational


def sine(angle: Fraction) -> Number:
    """sin(angle) of a rational angle [rad]; exactly 0 at 0, and nowhere else."""
    if stays_zero(angle):
        return Fraction(0)
    return Real(lambda: arb_of(angle).sin())


def cosine(angle: Fraction) -> Number:
    """cos(angle) of a rational angle [rad]; exactly 1 at 0."""
    if angle:
        return Real(lambda: arb_of(angle).cos())
    return Fraction(1)


def logarithm(value: Fraction) -> Number:
    """ln(value), value > 0; exactly 0 at 1, and nowhere else."""
    if stays_zero(value - 1):
        return Fraction(0)
    return Real(lambda: arb_of(value).log())
