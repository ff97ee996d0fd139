"""Arrays of doubles in midpoint-radius form: each approximates a number with a bound of its error.

Theorem (midpoint and radius): let |a - A| <= r and |b - B| <= s, entry by entry. A product of
matrices of n inner rows, each of its n products and n sums rounded to doubles in any order, is

    |a b - fl(A B)| <= r (|B| + s) + |A| s + (n + 1) 2^-52 |A| |B| + n 2^-1022,

and a sum |a + b - fl(A + B)| <= r + s + 2^-52 |fl(A + B)|. (Rump, Verification methods, 2010.)

The bounds are sums of numbers that are not negative, so that their own rounding is covered by the
factor UPWARDS (growth.py), by which every reader of a bound multiplies it.

Hypotheses, and where each is checked:

* the balls from which an array is made are finite: `from_balls` raises UndecidedError otherwise;
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
class MidpointRadius:
    """Numbers at a distance of at most `radius` from `midpoint`, two arrays of one shape."""

    midpoint: Array
    radius: Array

    @property
    def size(self) -> Array:
        """The absolute values of the doubles."""
        magnitudes: Array = np.abs(self.midpoint)
        return magnitudes

    def __getitem__(self, key: Any) -> "MidpointRadius":
        return MidpointRadius(self.midpoint[key], self.radius[key])

    def __matmul__(self, other: "MidpointRadius") -> "MidpointRadius":
        """The matrix product, with the bound of the theorem: r (|B| + s) + |A| s and rounding."""
        # r (|B| + s) + |A| s + (n + 1) 2^-52 |A| |B| + n 2^-1022, with A, B the midpoints and r, s
        # the radii of both factors.
        count = self.midpoint.shape[-1]
        middle = self.midpoint @ other.midpoint
        inexact = self.radius @ (other.size + other.radius) + self.size @ other.radius
        rounding = (count + 1) * UNIT * (self.size @ other.size)
        return MidpointRadius(middle, inexact + rounding + count * TINIEST)

    def __mul__(self, other: "MidpointRadius") -> "MidpointRadius":
        """The product entry by entry, with the bound r (|B| + s) + |A| s and its rounding."""
        # r (|B| + s) + |A| s + 2^-52 |fl(A B)| + 2^-1022, entry by entry.
        middle = self.midpoint * other.midpoint
        inexact = self.radius * (other.size + other.radius) + self.size * other.radius
        return MidpointRadius(middle, inexact + UNIT * np.abs(middle) + TINIEST)

    def __add__(self, other: "MidpointRadius") -> "MidpointRadius":
        # r + s + 2^-52 |fl(A + B)|.
        middle = self.midpoint + other.midpoint
        return MidpointRadius(middle, self.radius + other.radius + UNIT * np.abs(middle))

    def __neg__(self) -> "MidpointRadius":
        return MidpointRadius(-self.midpoint, self.radius)


def from_balls(values: Sequence[Any]) -> MidpointRadius:
    """The array of balls that are given in nested lists of one shape; UndecidedError where a
    ball is not finite.
    """
    balls = np.array(values, dtype=object)
    flat: list[arb] = balls.ravel().tolist()
    if not all(ball.is_finite() for ball in flat):
        raise UndecidedError("the motion is not known at this precision", code="precision")
    middle = np.array([float(ball.mid()) for ball in flat])
    radius = np.array([float(ball.rad()) for ball in flat])
    bound = radius + UNIT * np.abs(middle) + TINIEST
    return MidpointRadius(middle.reshape(balls.shape), bound.reshape(balls.shape))


def exact(values: Array) -> MidpointRadius:
    """Doubles that are the numbers themselves, without error."""
    return MidpointRadius(values, np.zeros_like(values))


def together(parts: Sequence[MidpointRadius]) -> MidpointRadius:
    """Arrays of one shape along a new first axis."""
    return MidpointRadius(
        np.array([one.midpoint for one in parts]), np.array([one.radius for one in parts])
    )
