"""Arrays of doubles in midpoint-radius form: each approximates a number with a bound of its error.

Theorem (midpoint and radius): let |a - A| <= r and |b - B| <= s, entry by entry. A product of
matrices of n inner rows, each of its n products and n sums rounded to doubles in any order, is

    |a b - fl(A B)| <= r (|B| + s) + |A| s + (n + 1) 2^-52 |A| |B| + n 2^-1022,

and a sum |a + b - fl(A + B)| <= r + s + 2^-52 |fl(A + B)|. (Rump, Verification methods, 2010.)

The bounds are sums of numbers that are not negative, so that their own rounding is covered by the
factor UPWARDS (growth.py), by which every reader of a bound multiplies it.

Hypotheses, and where each is checked:

* the balls from which an array is made are finite: `near` raises UndecidedError otherwise;
* the rounding of numbers below the normal doubles is counted: TINIEST;
* doubles do not overflow: with an infinite bound S is BOUNDLESS (`bounded`, growth.py).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from flint import arb
from numpy.typing import NDArray

from refdem.truth.balls import UndecidedError

Array = NDArray[np.float64]
UNIT = 2.0**-52
"""A bound of the relative error of a double: twice that of rounding to nearest, since the midpoint
of a ball is truncated.
"""
TINIEST = 2.0**-1022
"""A bound of the rounding error of a number below the normal doubles."""


@dataclass(frozen=True)
class Near:
    """Numbers at a distance of at most `off` from `middle`, two arrays of one shape."""

    middle: Array
    off: Array

    @property
    def size(self) -> Array:
        """The absolute values of the doubles."""
        magnitudes: Array = np.abs(self.middle)
        return magnitudes

    def __getitem__(self, key: Any) -> "Near":
        return Near(self.middle[key], self.off[key])

    def __matmul__(self, other: "Near") -> "Near":
        """The matrix product, with the bound of the theorem: r (|B| + s) + |A| s and rounding."""
        # r (|B| + s) + |A| s + (n + 1) 2^-52 |A| |B| + n 2^-1022, with A, B the midpoints and r, s
        # the radii of both factors.
        count = self.middle.shape[-1]
        middle = self.middle @ other.middle
        inexact = self.off @ (other.size + other.off) + self.size @ other.off
        rounding = (count + 1) * UNIT * (self.size @ other.size)
        return Near(middle, inexact + rounding + count * TINIEST)

    def __mul__(self, other: "Near") -> "Near":
        """The product entry by entry, with the bound r (|B| + s) + |A| s and its rounding."""
        middle = self.middle * other.middle
        inexact = self.off * (other.size + other.off) + self.size * other.off
        return Near(middle, inexact + UNIT * np.abs(middle) + TINIEST)

    def __add__(self, other: "Near") -> "Near":
        # r + s + 2^-52 |fl(A + B)|.
        middle = self.middle + other.middle
        return Near(middle, self.off + other.off + UNIT * np.abs(middle))

    def __neg__(self) -> "Near":
        return Near(-self.middle, self.off)


def near(values: Sequence[Any]) -> Near:
    """The doubles near balls, which are given in nested lists of one shape; UndecidedError where a
    ball is not finite.
    """
    balls = np.array(values, dtype=object)
    flat: list[arb] = balls.ravel().tolist()
    if not all(ball.is_finite() for ball in flat):
        raise UndecidedError("the motion is not known at this precision", code="precision")
    middle = np.array([float(ball.mid()) for ball in flat])
    radius = np.array([float(ball.rad()) for ball in flat])
    off = radius + UNIT * np.abs(middle) + TINIEST
    return Near(middle.reshape(balls.shape), off.reshape(balls.shape))


def exact(values: Array) -> Near:
    """Doubles that are the numbers themselves, without error."""
    return Near(values, np.zeros_like(values))


def together(parts: Sequence[Near]) -> Near:
    """Arrays of one shape along a new first axis."""
    return Near(np.array([one.middle for one in parts]), np.array([one.off for one in parts]))
