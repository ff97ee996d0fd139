"""Balls with their derivatives by a few parameters: formulas for balls give both.

Theorem (chain rule): if balls hold numbers and their derivatives, then the balls that the rules of
sums, products, quotients and elementary functions give hold those of the result.

Hypotheses, and where each is checked: a function is differentiable on the whole ball. A quotient by
a ball that holds 0, or a root of one, gives balls that are not finite, which `ball_of` refuses.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Union

from flint import arb

Real = Union["Sloped", arb]
"""What formulas are written for."""


@dataclass(frozen=True)
class Sloped:
    """A number and its derivatives (`slopes`) by the parameters."""

    value: arb
    slopes: tuple[arb, ...]

    def along(self, value: arb, slope: arb) -> "Sloped":
        """The number f(self), from its `value` and the derivative f' (`slope`) there: chain
        rule.
        """
        return Sloped(value, tuple(slope * one for one in self.slopes))

    def __neg__(self) -> "Sloped":
        return self.along(-self.value, arb(-1))

    def __add__(self, other: Real | int) -> "Sloped":
        if not isinstance(other, Sloped):
            return Sloped(self.value + other, self.slopes)
        slopes = tuple(a + b for a, b in zip(self.slopes, other.slopes, strict=True))
        return Sloped(self.value + other.value, slopes)

    __radd__ = __add__

    def __sub__(self, other: Real | int) -> "Sloped":
        return self + -other

    def __rsub__(self, other: arb | int) -> "Sloped":
        return -self + other

    def __mul__(self, other: Real | int) -> "Sloped":
        if not isinstance(other, Sloped):
            return Sloped(self.value * other, tuple(one * other for one in self.slopes))
        slopes = tuple(
            a * other.value + self.value * b for a, b in zip(self.slopes, other.slopes, strict=True)
        )
        return Sloped(self.value * other.value, slopes)

    __rmul__ = __mul__

    def __truediv__(self, other: Real | int) -> "Sloped":
        if not isinstance(other, Sloped):
            return Sloped(self.value / other, tuple(one / other for one in self.slopes))
        return self * (1 / other)

    def __rtruediv__(self, other: arb | int) -> "Sloped":
        # (c/x)' = -c/x^2.
        value = other / self.value
        return self.along(value, -value / self.value)

    def __pow__(self, power: int) -> "Sloped":
        # python-flint's powers of balls that hold 0 are not numbers: x^(n-1) by products.
        power_below = arb(1)
        for _ in range(power - 1):
            power_below = power_below * self.value
        return self.along(power_below * self.value, power * power_below)

    def sqrt(self) -> "Sloped":
        """The square root, with its derivatives."""
        value = self.value.sqrt()
        return self.along(value, 1 / (2 * value))

    def asinh(self) -> "Sloped":
        """The inverse of the hyperbolic sine."""
        return self.along(self.value.asinh(), 1 / (1 + self.value * self.value).sqrt())


def parameters(values: Sequence[arb]) -> list[Sloped]:
    """Independent parameters with these values: the derivative of each by itself is 1, by the
    others 0.
    """
    count = len(values)
    numbers = []
    for i, value in enumerate(values):
        unit = tuple(arb(int(i == j)) for j in range(count))
        numbers.append(Sloped(value, unit))
    return numbers
