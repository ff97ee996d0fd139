"""Poincare sections of trajectories, and Lyapunov exponents with standard errors that distinguish
periodic from chaotic motion.
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
        """`chaotic` or `periodic` (M,) where the exponent is above or below zero by three standard
        errors, else `quasi-periodic`.
        """
        # -1, 0 or 1: below zero, within the errors of it, above zero.
        is_clear = np.abs(self.value) > SIGMAS * self.error
        side = (np.sign(self.value) * is_clear).astype(int)
        kinds: NDArray[np.str_] = np.array(["periodic", "quasi-periodic", "chaotic"])[side + 1]
        return kinds


def exponent(growth: Array, seconds: Array) -> Exponent:
    """Exponents (M,) from the logarithmic growth of a tangent vector over blocks (M, B) of equal
    parts of `seconds` (M,).

    The error is the standard error of the blocks' mean, but at least 1/seconds: a tangent vector
    that does not grow in the mean may still differ by a factor e between begin and end.
    """
    blocks = growth.shape[1]
    # Rate of a block: its growth over its duration seconds/B.
    rates = growth * (blocks / seconds[:, None])
    spread = rates.std(axis=1, ddof=1) / np.sqrt(blocks)
    return Exponent(rates.mean(axis=1), np.maximum(spread, 1.0 / seconds))


def section(t: Array, x: Array, v: Array, level: float = 0.0) -> tuple[Array, Array]:
    """Times [s] and positions (K,) at which the velocity passes `level`, from samples x (T,) [m]
    and v (T,) [m/s] of x' = v.

    v is interpolated linearly, x by Hermite's cubic: errors are of second order in the sampling
    interval for times, and, at level 0, of fourth order for positions.
    """
    above = v > level
    index = np.flatnonzero(above[1:] != above[:-1])
    h = t[index + 1] - t[index]
    v_before = v[index]
    v_after = v[index + 1]
    # Linear in s = (t - t_0)/h: v_before + s (v_after - v_before) = level.
    s = (level - v_before) / (v_after - v_before)
    # Hermite's cubic: x = x0 (1 + 2 s)(1 - s)^2 + x1 s^2 (3 - 2 s) + h s (1 - s)((1 - s) v0 - s
    # v1).
    from_begin = x[index] * (1 + 2 * s) * (1 - s) ** 2
    from_end = x[index + 1] * s**2 * (3 - 2 * s)
    from_slopes = h * s * (1 - s) * ((1 - s) * v_before - s * v_after)
    position = from_begin + from_end + from_slopes
    return t[index] + s * h, position


def distinct(values: Array, tolerance: float) -> int:
    """The number of distinct values; neighbours in size that differ by at most `tolerance` count as
    one.
    """
    if not len(values):
        return 0
    gaps = np.diff(np.sort(values))
    return 1 + int(np.sum(gaps > tolerance))
