"""Sampled oscillations: turning points, amplitude, period, and how an area of phase space shrinks
or grows.
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def turning_points(t: Array, x: Array, v: Array) -> tuple[Array, Array]:
    """Times (M,) [s] and places (M,) at which the velocity changes its sign, by cubic Hermite
    interpolation of (x, v).

    t, x, v (T,). Times are off by the third power of the interval between samples, places by the
    fourth.
    """
    moves = v[:-1] != 0
    turns = v[:-1] * v[1:] <= 0
    first = np.flatnonzero(moves & turns)
    h = t[first + 1] - t[first]
    rise = (x[first + 1] - x[first]) / h
    before = v[first]
    after = v[first + 1]
    square = 3 * (before + after - 2 * rise)
    linear = 2 * (3 * rise - 2 * before - after)
    # before + linear s + square s^2 = 0, by the form of the root that does not cancel
    root = np.sqrt(np.maximum(0.0, linear**2 - 4 * square * before))
    sign = np.where(before > 0, -1.0, 1.0)
    s = -2 * before / (linear + sign * root)
    place = x[first] + h * s * (before + s * (linear / 2 + s * square / 3))
    return t[first] + h * s, place


def amplitude(t: Array, x: Array, v: Array) -> float:
    """Half the distance between the last two turning points."""
    _, places = turning_points(t, x, v)
    return float(abs(places[-1] - places[-2]) / 2)


def period(t: Array, x: Array, v: Array) -> float:
    """Mean time [s] from a turning point to the next but one."""
    times, _ = turning_points(t, x, v)
    count = (len(times) - 1) // 2
    return float((times[2 * count] - times[0]) / count)


def phase_area(x: Array, v: Array) -> Array:
    """Area (...) of polygons in phase space with corners x, v (..., N) in turn, positive if they go
    round against the clock.
    """
    x_next = np.roll(x, -1, axis=-1)
    v_next = np.roll(v, -1, axis=-1)
    area: Array = np.sum(x * v_next - x_next * v, axis=-1) / 2
    return area


def carried_area(x: Array, v: Array) -> Array:
    """Area (T - 2,) of the triangle of every three neighbouring samples (T,) of an autonomous
    motion.

    The flow carries the first triangle through all the others; one that is linear carries areas
    exactly.
    """
    corners = np.lib.stride_tricks.sliding_window_view
    return phase_area(corners(x, 3), corners(v, 3))
