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

REACH = 12
"""Most of |J| at the start times the outer radius: sums whose terms grow as exp of that lose its
bits.
"""
HALVINGS = 32
"""Of the disc whose Jacobian makes the weights."""


def quickest(slopes: Sequence[arb | acb]) -> float:
    """About the largest |eigenvalue| of a matrix whose rows come one after another, and
    positive.
    """
    matrix = np.array([float(outward(entry)) for entry in slopes])
    if not np.isfinite(matrix).all():
        return inf
    return max(
        float(np.abs(np.linalg.eigvals(matrix.reshape(isqrt(len(matrix)), -1))).max()), 1e-300
    )


def typical(jacobian: Callable[[float], list[Any]], radius: float) -> list[Any] | None:
    """J, a function of the radius, on a disc at most so large on which its motion is no wilder than
    REACH; None if there is none.
    """
    for _ in range(HALVINGS):
        slopes = jacobian(radius)
        if quickest(slopes) * radius < REACH:
            return slopes
        radius /= 2
    return None


def weighted(
    speeds: Sequence[arb], slopes: Sequence[arb | acb], slowest: float, least: Sequence[arb]
) -> list[arb]:
    """Weights w = (1 - |J|/r)^-1 b, r a little more than the spectral radius of |J|, b = max(|f|,
    least): |J| w <= r w and |f| <= w.

    A coordinate whose rate has died out while others go on (a spin that has settled about an axis)
    would without `least` have a weight so small beside theirs that the remainder of the flow
    Jacobian, which is in parts of w_i/w_j, swells the set.
    """
    rates = np.maximum(doubles(speeds), doubles(least))
    matrix = doubles(slopes).reshape(len(rates), -1)
    if not (np.isfinite(rates).all() and np.isfinite(matrix).all()):
        return [arb(1)] * len(rates)
    r = 1.25 * max(slowest, *np.abs(np.linalg.eigvals(matrix)))
    found = np.linalg.solve(np.eye(len(rates)) - matrix / r, rates if rates.any() else rates + 1)
    return [arb(float(weight)) for weight in np.maximum(found, found[found > 0].min() / 1024)]


def doubles(values: Sequence[arb | acb]) -> NDArray[np.float64]:
    """Upper bounds of absolute values, to rounding."""
    return np.array([float(outward(value)) for value in values])
