"""Sections of trajectories by a plane of phase space, and Lyapunov exponents with error bars that
tell periodic from chaotic.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

SIGMAS = 3.0
"""Standard errors by which an exponent must differ from zero to count as positive or negative."""


class Exponent(NamedTuple):
    """Largest Lyapunov exponents [1/s] with their standard errors, each (M,)."""

    value: Array
    error: Array

    def regimes(self) -> NDArray[np.str_]:
        """`chaotic` and `periodic` where the exponent is above or below zero by three standard
        errors, else `quasi-periodic` (M,).
        """
        # -1, 0 or 1: below zero, within the errors of it, above zero.
        is_clear = np.abs(self.value) > SIGMAS * self.error
        side = (np.sign(self.value) * is_clear).astype(int)
        kinds: NDArray[np.str_] = np.array(["periodic", "quasi-periodic", "chaotic"])[side + 1]
        return kinds


def exponent(growth: Array, seconds: Array) -> Exponent:
    """Exponents (M,) from the growth of the logarithm of a tangent over blocks (M, B) of equal
    parts of `seconds` (M,).

    The error is that of the mean of the blocks, and not less than 1/seconds: a tangent may differ
    by a factor e between begin and end of what does not grow.
    """
    blocks = growth.shape[1]
    rates = growth * (blocks / seconds[:, None])
    spread = rates.std(axis=1, ddof=1) / np.sqrt(blocks)
    return Exponent(rates.mean(axis=1), np.maximum(spread, 1.0 / seconds))


def section(t: Array, x: Array, v: Array, level: float = 0.0) -> tuple[Array, Array]:
    """Times [s] and places (K,) at which the velocity passes `level`, from samples x (T,) [m] and v
    (T,) [m/s] of x' = v.

    v is interpolated linearly, x by Hermite's cubic: errors are of second order in the samples'
    interval in time, and, for level 0, of fourth in place.
    """
    above = v > level
    at = np.flatnonzero(above[1:] != above[:-1])
    h = t[at + 1] - t[at]
    before = v[at]
    after = v[at + 1]
    # The part s of the interval after which the velocity passes.
    s = (level - before) / (after - before)
    # Hermite's cubic: the values at the ends, then the slopes.
    of_begin = x[at] * (1 + 2 * s) * (1 - s) ** 2
    of_end = x[at + 1] * s**2 * (3 - 2 * s)
    of_slopes = h * s * (1 - s) * ((1 - s) * before - s * after)
    place = of_begin + of_end + of_slopes
    return t[at] + s * h, place


def distinct(values: Array, tolerance: float) -> int:
    """How many values there are, counting those as one that lie within `tolerance` of their
    neighbour in size.
    """
    if not len(values):
        return 0
    gaps = np.diff(np.sort(values))
    return 1 + int(np.sum(gaps > tolerance))
