"""Trial run of a motion along a line, by the series of kernels/taylor_oscillator.c on a grid that
does not depend on the samples. It tests whether the motion reaches the last sample without passing
the anchor of its spring.
"""

from math import ceil, sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from refdem.core.problem import Motion
from refdem.scene.elements.spring import Spring
from refdem.solvers._kernel_solver import KernelCall, Struct, samples_from_start
from refdem.solvers._line import Line, line_of

Array = NDArray[np.float64]
FAMILY = "taylor_oscillator"
POINTS_PER_RADIAN = 8
"""Points of the grid per radian of the fastest component of the motion. Hermite's cubic between two
points has a relative error of at most h^4/384 = 6e-7 of that component, h = 1/8.
"""
MOST_POINTS = 2**20
"""Largest number of points of a grid (8 MB a column); longer motions get a coarser grid."""


def series_call(line: Line, t: Array) -> KernelCall:
    """The kernel's call for x [m], v [m/s] and work [J] (T, 3) at the times t (T,) [s]."""
    law = _powers(line.spring) | {
        "mass": line.mass,
        "damping": line.damping,
        "van_der_pol": line.van_der_pol,
        "offset": line.offset,
        "weight": line.weight,
        "drives": len(line.drives),
        "drive": line.drives,
    }
    return KernelCall(
        function="refdem_taylor_oscillator",
        inputs=(Struct(FAMILY, "refdem_oscillator", law), line.x0, line.v0),
        clock=samples_from_start(t),
        outputs=(np.empty((len(t), 3)),),
    )


def unsupported_times(problem: Motion) -> str | None:
    """None if the motion reaches the last sample on its side of the spring's anchor, else the
    reason.

    The force of a spring of natural length l > 0 changes its direction behind the anchor, where x <
    -l. A series of the force in front of the anchor does not describe this.
    """
    line = line_of(problem.scene)
    t = problem.times
    status = _made(line, t)[0]
    if status:
        return f"the motion goes to infinity before t = {t[status - 1]:.6g} s"
    if not line.spring.length > 0:
        return None
    grid = _grid(line, t)
    _, rows = _made(line, grid)
    x, v, _ = rows.T
    lowest = lowest_between(grid, x, v)
    behind = np.flatnonzero(lowest <= -line.spring.length)
    if behind.size == 0:
        return None
    return (
        f"the point passes the anchor of its spring before t = {grid[behind[0] + 1]:.6g} s: the"
        " force turns round there, which no series shows"
    )


def lowest_between(t: Array, x: Array, v: Array) -> Array:
    """The lowest value (T - 1,) between each two times of the cubic through both ends with their
    rates v.
    """
    h = np.diff(t)
    start = x[:-1]
    # Hermite's cubic x(s) = x0 + b s + c s^2 + d s^3, 0 <= s <= 1, has x(1) = x1, x'(0) = b = h v0
    # and x'(1) = h v1: c = 3 (x1 - x0) - 2 h v0 - h v1, d = h v0 + h v1 - 2 (x1 - x0).
    gain = np.diff(x)
    b = v[:-1] * h
    end_rate = v[1:] * h
    c = 3.0 * gain - 2.0 * b - end_rate
    d = b + end_rate - 2.0 * gain
    lowest = np.minimum(start, x[1:])
    # Roots of x'(s) = b + 2 c s + 3 d s^2 without cancellation: with q = -(c + sgn(c) sqrt(c^2 - 3
    # b d)) they are q/(3 d) and b/q.
    root = np.sqrt(np.maximum(c * c - 3.0 * b * d, 0.0))
    half = -(c + np.copysign(root, c))
    with np.errstate(divide="ignore", invalid="ignore"):
        candidates = (half / (3.0 * d), b / half)
    for s in candidates:
        inside = np.isfinite(s) & (s > 0.0) & (s < 1.0)
        place = np.where(inside, s, 0.0)
        value = start + place * (b + place * (c + place * d))
        lowest = np.minimum(lowest, value)
    return lowest


def _made(line: Line, t: Array) -> tuple[int, Array]:
    """The kernel's status, and its rows (T, 3), at the times t."""
    call = series_call(line, t)
    status = call.made(FAMILY)
    rows: Array = call.outputs[0]
    return status, rows


def _grid(line: Line, t: Array) -> Array:
    """Times from the first sample to the last, dense enough for cubics between them."""
    spring = line.spring
    # Estimate of the fastest rate: the larger of sqrt(K/m) + D/m and of the frequencies of the
    # drives. At the stretch s = max(|x0|, l), with the spring k s^n + q s^2 + c s^3,
    #   K = |k| s^(n-1) + 2 |q| s + 3 |c| s^2,   D = |d| + |e| (s + |r|)^2.
    # K is the stiffness dF/ds but for its first term, which lacks the factor n: it is F/s.
    stretch = max(abs(line.x0), spring.length)
    stiffness = (
        abs(spring.stiffness) * stretch ** (spring.exponent - 1.0)
        + 2.0 * abs(spring.quadratic) * stretch
        + 3.0 * abs(spring.cubic) * stretch**2
    )
    damping = abs(line.damping) + abs(line.van_der_pol) * (stretch + abs(line.offset)) ** 2
    rate = sqrt(stiffness / line.mass) + damping / line.mass
    if len(line.drives):
        rate = max(rate, float(np.abs(line.drives[:, 1]).max()))
    # POINTS_PER_RADIAN points in each time 1/rate.
    span = abs(t[-1] - t[0])
    points = ceil(POINTS_PER_RADIAN * rate * span) + len(t)
    return np.linspace(t[0], t[-1], min(points, MOST_POINTS))


def _powers(spring: Spring) -> dict[str, Any]:
    """Coefficients of the first, second and third power of the stretch in the spring's force."""
    powers = {"linear": 0.0, "quadratic": spring.quadratic, "cubic": spring.cubic}
    if spring.exponent == 1:
        powers["linear"] += spring.stiffness
    else:
        powers["cubic"] += spring.stiffness
    return powers
