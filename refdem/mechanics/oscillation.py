"""Sampled oscillations: turning points, amplitude, period, and areas in phase space."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def turning_points(t: Array, x: Array, v: Array) -> tuple[Array, Array]:
    """Times (M,) [s] and positions (M,) at which the velocity changes sign, from samples t, x, v
    (T,).

    Between two samples x is the cubic Hermite polynomial of (x, v). Errors are of third order in
    the interval for times, of fourth order for positions.
    """
    moves = v[:-1] != 0
    turns = v[:-1] * v[1:] <= 0
    first = np.flatnonzero(moves & turns)
    h = t[first + 1] - t[first]
    mean_velocity = (x[first + 1] - x[first]) / h
    v_before = v[first]
    v_after = v[first + 1]
    # x'(s) = v0 + b s + a s^2 on 0 <= s <= 1 has x'(1) = v1 and the mean u = (x1 - x0)/h:
    # a = 3 (v0 + v1 - 2 u), b = 2 (3 u - 2 v0 - v1).
    quadratic = 3 * (v_before + v_after - 2 * mean_velocity)
    linear = 2 * (3 * mean_velocity - 2 * v_before - v_after)
    # Its root in the interval, s = -2 v0/(b -+ sqrt(b^2 - 4 a v0)) with the sign - for v0 > 0, does
    # not cancel.
    root = np.sqrt(np.maximum(0.0, linear**2 - 4 * quadratic * v_before))
    sign = np.where(v_before > 0, -1.0, 1.0)
    s = -2 * v_before / (linear + sign * root)
    # x = x0 + h (v0 s + b s^2/2 + a s^3/3).
    position = x[first] + h * s * (v_before + s * (linear / 2 + s * quadratic / 3))
    return t[first] + h * s, position


def amplitude(t: Array, x: Array, v: Array) -> float:
    """Half the distance between the last two turning points."""
    _, places = turning_points(t, x, v)
    # |x_M - x_(M-1)|/2.
    return float(abs(places[-1] - places[-2]) / 2)


def period(t: Array, x: Array, v: Array) -> float:
    """Mean time [s] between every second turning point."""
    times, _ = turning_points(t, x, v)
    # (t_2n - t_0)/n for n whole periods.
    count = (len(times) - 1) // 2
    return float((times[2 * count] - times[0]) / count)


def phase_area(x: Array, v: Array) -> Array:
    """Area (...) of polygons in phase space with corners x, v (..., N), positive if
    counter-clockwise: sum (x_i v_i+1 - x_i+1 v_i)/2.
    """
    x_next = np.roll(x, -1, axis=-1)
    v_next = np.roll(v, -1, axis=-1)
    area: Array = np.sum(x * v_next - x_next * v, axis=-1) / 2
    return area


def carried_area(x: Array, v: Array) -> Array:
    """Area (T - 2,) of the triangle of every three successive samples (T,) of an autonomous motion.

    The flow maps the first triangle to all others, and a linear flow maps straight sides to
    straight ones: its areas obey Liouville's theorem exactly.
    """
    windows = np.lib.stride_tricks.sliding_window_view
    return phase_area(windows(x, 3), windows(v, 3))
