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
    """A number and its derivatives."""

    value: arb
    slopes: tuple[arb, ...]

    def along(self, value: arb, slope: arb) -> "Sloped":
        """A function of it, with this value and this derivative."""
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
        value = other / self.value
        return self.along(value, -value / self.value)

    def __pow__(self, power: int) -> "Sloped":
        # python-flint's powers of balls that hold 0 are not numbers.
        below = arb(1)
        for _ in range(power - 1):
            below = below * self.value
        return self.along(below * self.value, power * below)

    def sqrt(self) -> "Sloped":
        """The square root, with its derivatives."""
        value = self.value.sqrt()
        return self.along(value, 1 / (2 * value))

    def asinh(self) -> "Sloped":
        """The inverse of the hyperbolic sine."""
        return self.along(self.value.asinh(), 1 / (1 + self.value * self.value).sqrt())


def parameters(values: Sequence[arb]) -> list[Sloped]:
    """Independent numbers, each with derivatives by all of them."""
    count = len(values)
    found = []
    for i, value in enumerate(values):
        found.append(Sloped(value, tuple(arb(int(i == j)) for j in range(count))))
    return found
