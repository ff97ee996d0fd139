"""Dual numbers: exact numbers and balls that carry their derivatives by a few parameters.

Theorem (chain rule): if numbers and their derivatives are exact, or are held by balls, then what
the rules of sums, products, quotients and elementary functions give is, or holds, the result and
its derivatives.

Hypotheses, and where each is checked:

* a function is differentiable on the whole ball: a quotient by a ball that holds 0, or a root of
  one, gives balls that are not finite, which `ball_of` refuses; |x| is refused there;
* every function of a dual ball has a rule here: one without raises TypeError (`_refused`);
* a branch that is chosen by comparing values is that of a whole neighbourhood: derivatives are
  bracketed by differences of certified values (sensitivities.py).
"""

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from math import isqrt
from typing import Any, NoReturn, Self

from flint import arb

from refdem.core.truth import Ball

Slopes = tuple[Any, ...]
"""Derivatives by the parameters; () for a number that does not depend on them."""


def slopes_of(number: Any) -> Slopes:
    """The derivatives of a number, () for one that carries none."""
    slopes: Slopes = getattr(number, "slopes", ())
    return slopes


def combined(a: Any, slopes_a: Slopes, b: Any, slopes_b: Slopes) -> Slopes:
    """a da + b db for each parameter, with () for derivatives that are all 0."""
    if not slopes_b:
        return tuple(a * slope for slope in slopes_a)
    if not slopes_a:
        return tuple(b * slope for slope in slopes_b)
    return tuple(a * one + b * other for one, other in zip(slopes_a, slopes_b, strict=True))


class ExactDual(Fraction):
    """An exact rational number with its exact derivatives.

    It compares and hashes as its value.
    """

    slopes: tuple[Fraction, ...]

    def __new__(cls, value: Fraction | int, slopes: Sequence[Fraction | int]) -> Self:
        self = super().__new__(cls, value)
        self.slopes = tuple(Fraction(slope) for slope in slopes)
        return self

    def __copy__(self) -> Self:
        return self

    def __deepcopy__(self, memo: Any) -> Self:
        return self

    def __neg__(self) -> Any:
        return ExactDual(-plain(self), [-slope for slope in self.slopes])

    def __pos__(self) -> Any:
        return self

    def __abs__(self) -> Any:
        if self < 0:
            return -self
        return self

    def __add__(self, other: Any) -> Any:
        if not isinstance(other, int | Fraction):
            return NotImplemented
        slopes = combined(1, self.slopes, 1, slopes_of(other))
        return ExactDual(plain(self) + plain(other), slopes)

    __radd__ = __add__

    def __sub__(self, other: Any) -> Any:
        if not isinstance(other, int | Fraction):
            return NotImplemented
        return self + -other

    def __rsub__(self, other: Any) -> Any:
        return -self + other

    def __mul__(self, other: Any) -> Any:
        if not isinstance(other, int | Fraction):
            return NotImplemented
        a = plain(self)
        b = plain(other)
        return ExactDual(a * b, combined(b, self.slopes, a, slopes_of(other)))

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Any:
        if not isinstance(other, int | Fraction):
            return NotImplemented
        return _quotient(self, other)

    def __rtruediv__(self, other: Any) -> Any:
        return _quotient(other, self)

    def __pow__(self, power: Any, modulus: Any = None) -> Any:
        if not isinstance(power, int):
            return NotImplemented
        a = plain(self)
        if power == 0:
            return Fraction(1)
        # (x^n)' = n x^(n-1) x'.
        factor = power * a ** (power - 1)
        return ExactDual(a**power, [factor * slope for slope in self.slopes])


def plain(value: Fraction | int) -> Fraction:
    """The value of an exact number, without derivatives."""
    return Fraction(value.numerator, value.denominator)


def stays_zero(value: Fraction | int) -> bool:
    """True if an exact number is 0 and has no derivative: it is 0 beside the parameters too."""
    return value == 0 and not any(slopes_of(value))


def rational_root(square: Fraction) -> Fraction | None:
    """The root sqrt(square) of an exact number >= 0 if it is rational, with its derivatives
    q'/(2 sqrt q); None if it is not, and for a dual 0, where the root has no derivative.
    """
    above = isqrt(square.numerator)
    below = isqrt(square.denominator)
    if above * above != square.numerator or below * below != square.denominator:
        return None
    root = Fraction(above, below)
    slopes = slopes_of(square)
    if not slopes:
        return root
    if root == 0:
        return None
    return ExactDual(root, [slope / (2 * root) for slope in slopes])


def _quotient(a: Fraction | int, b: Fraction | int) -> ExactDual:
    """The quotient a/b of exact numbers; (a/b)' = a'/b - a b'/b^2."""
    quotient = plain(a) / plain(b)
    inverse = 1 / plain(b)
    return ExactDual(quotient, combined(inverse, slopes_of(a), -quotient * inverse, slopes_of(b)))


class DualBall(arb):
    """A ball of a number with balls of its derivatives.

    It compares as its ball does. Raises TypeError for a function of balls that has no rule here.
    """

    slopes: tuple[arb, ...]

    def __new__(cls, value: arb, slopes: Sequence[arb]) -> Self:
        self = super().__new__(cls)
        self.slopes = tuple(slopes)
        return self

    def __init__(self, value: arb, slopes: Sequence[arb]) -> None:
        super().__init__(value)

    @property
    def value(self) -> arb:
        """The ball without derivatives."""
        return arb.__pos__(self)

    def along(self, value: arb, slope: arb) -> "DualBall":
        """The number f(self), from its `value` and the derivative f' (`slope`) there."""
        return DualBall(value, [slope * one for one in self.slopes])

    def __neg__(self) -> "DualBall":
        return DualBall(-self.value, [-slope for slope in self.slopes])

    def __pos__(self) -> "DualBall":
        return self

    def __abs__(self) -> "DualBall":
        if self > 0:
            return self
        if self < 0:
            return -self
        raise TypeError("the derivative of |x| where the ball of x holds 0")

    def __add__(self, other: Any) -> Any:
        if not isinstance(other, int | arb):
            return NotImplemented
        slopes = combined(1, self.slopes, 1, slopes_of(other))
        return DualBall(self.value + ball(other), slopes)

    __radd__ = __add__

    def __sub__(self, other: Any) -> Any:
        if not isinstance(other, int | arb):
            return NotImplemented
        slopes = combined(1, self.slopes, -1, slopes_of(other))
        return DualBall(self.value - ball(other), slopes)

    def __rsub__(self, other: Any) -> Any:
        return -self + other

    def __mul__(self, other: Any) -> Any:
        if not isinstance(other, int | arb):
            return NotImplemented
        b = ball(other)
        slopes = combined(b, self.slopes, self.value, slopes_of(other))
        return DualBall(self.value * b, slopes)

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Any:
        if not isinstance(other, int | arb):
            return NotImplemented
        # An int would be divided by in binary64.
        b = arb(ball(other))
        quotient = self.value / b
        return DualBall(quotient, combined(1 / b, self.slopes, -quotient / b, slopes_of(other)))

    def __rtruediv__(self, other: Any) -> Any:
        if not isinstance(other, int | arb):
            return NotImplemented
        # (c/x)' = -c/x^2.
        quotient = ball(other) / self.value
        return self.along(quotient, -quotient / self.value)

    def __pow__(self, power: Any, modulus: Any = None) -> Any:
        if not isinstance(power, int):
            # x^y = exp(y log x).
            return (self.log() * power).exp()
        if power < 0:
            return 1 / self**-power
        # Powers of balls that hold 0 are not numbers in python-flint: x^(n-1) by products.
        below = arb(1)
        for _ in range(power - 1):
            below = below * self.value
        return self.along(below * self.value, power * below)

    def sqrt(self) -> "DualBall":
        """The square root; its derivative is 1/(2 sqrt x)."""
        root = self.value.sqrt()
        return self.along(root, 1 / (2 * root))

    def rsqrt(self) -> "DualBall":
        """The inverse 1/sqrt(x) of the square root."""
        inverse: DualBall = 1 / self.sqrt()
        return inverse

    def exp(self) -> "DualBall":
        """The exponential function, which is its own derivative."""
        value = self.value.exp()
        return self.along(value, value)

    def log(self) -> "DualBall":
        """The natural logarithm; its derivative is 1/x."""
        return self.along(self.value.log(), 1 / self.value)

    def sin_cos(self) -> "tuple[DualBall, DualBall]":
        """The sine and the cosine, with cos x and -sin x as their derivatives."""
        sine, cosine = self.value.sin_cos()
        return self.along(sine, cosine), self.along(cosine, -sine)

    def sin(self) -> "DualBall":
        """The sine; its derivative is cos x."""
        return self.sin_cos()[0]

    def cos(self) -> "DualBall":
        """The cosine; its derivative is -sin x."""
        return self.sin_cos()[1]

    def tan(self) -> "DualBall":
        """The tangent; its derivative is 1 + tan^2 x."""
        value = self.value.tan()
        return self.along(value, 1 + value * value)

    def sinh(self) -> "DualBall":
        """The hyperbolic sine; its derivative is cosh x."""
        return self.along(self.value.sinh(), self.value.cosh())

    def cosh(self) -> "DualBall":
        """The hyperbolic cosine; its derivative is sinh x."""
        return self.along(self.value.cosh(), self.value.sinh())

    def tanh(self) -> "DualBall":
        """The hyperbolic tangent; its derivative is 1 - tanh^2 x."""
        value = self.value.tanh()
        return self.along(value, 1 - value * value)

    def atan(self) -> "DualBall":
        """The arc tangent; its derivative is 1/(1 + x^2)."""
        return self.along(self.value.atan(), 1 / (1 + self.value * self.value))

    def asin(self) -> "DualBall":
        """The arc sine; its derivative is 1/sqrt(1 - x^2)."""
        return self.along(self.value.asin(), (1 - self.value * self.value).rsqrt())

    def acos(self) -> "DualBall":
        """The arc cosine; its derivative is -1/sqrt(1 - x^2)."""
        return self.along(self.value.acos(), -(1 - self.value * self.value).rsqrt())

    def asinh(self) -> "DualBall":
        """The inverse hyperbolic sine; its derivative is 1/sqrt(1 + x^2)."""
        return self.along(self.value.asinh(), (1 + self.value * self.value).rsqrt())

    def min(self, other: Any) -> arb:
        """The smaller of two numbers; raises TypeError where balls do not tell which that is."""
        return self._chosen(other, self < other, self > other)

    def max(self, other: Any) -> arb:
        """The larger of two numbers; raises TypeError where balls do not tell which that is."""
        return self._chosen(other, self > other, self < other)

    def _chosen(self, other: Any, is_self: bool, is_other: bool) -> arb:
        """This number or the other one."""
        if is_self:
            return self
        if is_other:
            chosen: arb = other
            return chosen
        raise TypeError("the derivative of the smaller or larger of two balls that overlap")

    def union(self, other: Any) -> "DualBall":
        """A ball that holds both numbers, with balls that hold both derivatives."""
        pairs = zip(self.slopes, slopes_of(other), strict=True)
        return DualBall(self.value.union(ball(other)), [one.union(two) for one, two in pairs])


def ball(number: arb | int) -> Any:
    """The ball of a number without its derivatives; an int stays what it is."""
    if isinstance(number, DualBall):
        return number.value
    return number


def atan2(s: arb, t: arb) -> arb:
    """The angle of the point (t, s); its derivative is (t s' - s t')/(s^2 + t^2)."""
    a = ball(s)
    b = ball(t)
    if not slopes_of(s) and not slopes_of(t):
        return arb.atan2(a, b)
    square = a * a + b * b
    return carried(arb.atan2(a, b), (b / square, s), (-a / square, t))


def carried(value: arb, *parts: tuple[arb, arb]) -> arb:
    """The number `value`, whose derivatives are the sum of those of other numbers, each given as
    (factor, number); `value` itself where none of them is dual.
    """
    slopes: Slopes = ()
    for factor, number in parts:
        slopes = combined(1, slopes, factor, slopes_of(number))
    if not slopes:
        return value
    return DualBall(value, slopes)


TELLING = frozenset(
    (
        *("abs_lower", "abs_upper", "bits", "ceil", "contains", "contains_integer", "floor"),
        *("contains_interior", "is_exact", "is_finite", "is_integer", "is_nan", "is_zero"),
        *("lower", "man_exp", "mid", "mid_rad_10exp", "overlaps", "rad", "rel_accuracy_bits"),
        *("rel_one_accuracy_bits", "repr", "sgn", "str", "unique_fmpz", "upper"),
    )
)
"""Functions of balls that tell of the ball itself, or are constant between jumps: they have no
derivative to carry.
"""


def _refused(name: str) -> Callable[..., NoReturn]:
    """A function that raises TypeError: there is no rule for its derivative."""

    def refused(*_: Any, **__: Any) -> NoReturn:
        raise TypeError(f"no rule for the derivative of {name}")

    return refused


for _name in dir(arb):
    _is_own = _name.startswith("_") or _name in vars(DualBall) or _name in TELLING
    if not _is_own and not isinstance(vars(arb).get(_name), staticmethod | property):
        setattr(DualBall, _name, _refused(_name))


Derivatives = dict[str, tuple[Ball, ...]]
"""The derivatives of each quantity, by name, by the parameters."""


def flattened(values: Mapping[str, arb], count: int) -> dict[str, arb]:
    """The derivatives of some values by `count` parameters, each under a name of its own."""
    flat = {}
    for name, value in values.items():
        slopes = slopes_of(value) or (arb(0),) * count
        for k, slope in enumerate(slopes):
            flat[f"{name} by {k}"] = slope
    return flat


def unflattened(flat: Mapping[str, Ball], count: int) -> Derivatives:
    """The derivatives of each value, from those that `flattened` has named."""
    names = dict.fromkeys(name.rpartition(" by ")[0] for name in flat)
    return {name: tuple(flat[f"{name} by {k}"] for k in range(count)) for name in names}


def parameters(values: Sequence[arb]) -> list[DualBall]:
    """Independent parameters with these values: the derivative of each by itself is 1, by the
    others 0.
    """
    count = len(values)
    numbers = []
    for i, value in enumerate(values):
        unit = tuple(arb(int(i == j)) for j in range(count))
        numbers.append(DualBall(value, unit))
    return numbers
