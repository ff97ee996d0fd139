"""Weights of the norm in which discs are proved: a choice that makes them large; no proof depends
on it (any positive ones do).
"""

from collections.abc import Callable, Sequence
from math import inf, isqrt
from typing import Any

import numpy as np
from flint import acb, arb
from numpy.typing import NDArray

from refdem.truth.balls import outward

MAX_DISC_EXPONENT = 12
"""The most that |J| at the start times the outer radius may be: sums whose terms grow as exp of
that lose its bits.
"""
ABOVE_QUICKEST = 1.25
"""The ratio of r, in the weights of the norm, to the largest eigenvalue of the absolute values of
the Jacobian: |J| is at most r.
"""
HALVINGS = 32
"""The most halvings of the disc whose Jacobian makes the weights."""


def quickest(slopes: Sequence[arb | acb]) -> float:
    """The largest |eigenvalue| [1/s], about, of the absolute values of a matrix whose rows come one
    after another; at least 1e-300, so that it may divide.
    """
    matrix = doubles(slopes)
    if not np.isfinite(matrix).all():
        return inf
    eigenvalues = np.linalg.eigvals(matrix.reshape(isqrt(len(matrix)), -1))
    return max(float(np.abs(eigenvalues).max()), 1e-300)


def typical(jacobian: Callable[[float], list[Any]], radius: float) -> list[Any] | None:
    """The Jacobian J on a disc of at most this radius, halved until |J| times the radius is below
    MAX_DISC_EXPONENT; None if it never is.

    `jacobian(radius)` gives balls of J on the disc, its rows one after another.
    """
    for _ in range(HALVINGS):
        slopes = jacobian(radius)
        if quickest(slopes) * radius < MAX_DISC_EXPONENT:
            return slopes
        radius /= 2
    return None


def weighted(
    speeds: Sequence[arb | acb],
    slopes: Sequence[arb | acb],
    slowest: float,
    least: Sequence[arb],
) -> list[arb]:
    """Weights w = (1 - |J|/r)^-1 b, with b = max(|f|, least): |J| w <= r w and |f| <= w.

    r is 5/4 of the spectral radius of |J|, or of `slowest` [1/s] if that is larger; `speeds` are f,
    `slopes` J with its rows one after another. All weights are 1 where these are not finite.

    Without `least` a coordinate whose rate has decayed while others have not (a spin that has
    settled about an axis) would have a weight so small beside theirs that the remainder of the flow
    Jacobian, which is in parts of w_i/w_j, swells the set.
    """
    b = np.maximum(doubles(speeds), doubles(least))
    matrix = doubles(slopes).reshape(len(b), -1)
    if not (np.isfinite(b).all() and np.isfinite(matrix).all()):
        return [arb(1)] * len(b)
    if not b.any():
        # The motion rests at 0: all coordinates count alike.
        b = b + 1
    r = ABOVE_QUICKEST * max(slowest, *np.abs(np.linalg.eigvals(matrix)))
    # (1 - |J|/r) w = b
    weights = np.linalg.solve(np.eye(len(b)) - matrix / r, b)
    # Rounding may make a weight that should be tiny 0 or negative.
    smallest = weights[weights > 0].min() / 1024
    return [arb(float(weight)) for weight in np.maximum(weights, smallest)]


def doubles(values: Sequence[arb | acb]) -> NDArray[np.float64]:
    """The upper bounds of absolute values as doubles, rounded to nearest."""
    return np.array([float(outward(value)) for value in values])
