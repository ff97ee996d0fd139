"""Answers of driven oscillators in formulas: linear (1.105), (1.106), harmonic balance (1.115),
(1.121), and hysteresis of sweeps.
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def linear_amplitude(drive: Array, square: float, delta: float, f0: float) -> Array:
    """|A| = f0/sqrt((w0^2 - w^2)^2 + 4 delta^2 w^2) at w = `drive` [rad/s].

    `square` is w0^2 (1.105).
    """
    amplitude: Array = f0 / np.hypot(square - drive**2, 2 * delta * drive)
    return amplitude


def linear_peak(square: float, delta: float, f0: float) -> tuple[float, float]:
    """Frequency and height f0/(2 delta sqrt(w0^2 - delta^2)) of the largest amplitude, for 2
    delta^2 < w0^2 (1.106).
    """
    frequency = float(np.sqrt(square - 2 * delta**2))
    height = float(f0 / (2 * delta * np.sqrt(square - delta**2)))
    return frequency, height


def balanced_frequency(amplitude: Array, alpha: float, beta: float) -> Array:
    """Frequency of free oscillations by harmonic balance, sqrt(alpha + 3 beta A^2/4) (1.115); too
    high by 3/256 (beta A^2/alpha)^2 w0.
    """
    frequency: Array = np.sqrt(alpha + 0.75 * beta * amplitude**2)
    return frequency


def balanced_drives(
    amplitude: Array, alpha: float, beta: float, delta: float, f0: float
) -> tuple[Array, Array]:
    """The lower and the higher frequency at which harmonic balance has that amplitude (1.121); nan
    where it has not.

    W^2 = k - 2 delta^2 -+ sqrt(f0^2/A^2 - 4 delta^2 (k - delta^2)), k = alpha + 3 beta A^2/4.
    """
    stiffness = alpha + 0.75 * beta * amplitude**2
    inside = (f0 / amplitude) ** 2 - 4 * delta**2 * (stiffness - delta**2)
    with np.errstate(invalid="ignore"):
        root = np.sqrt(inside)
        lower = np.sqrt(stiffness - 2 * delta**2 - root)
        higher = np.sqrt(stiffness - 2 * delta**2 + root)
    return lower, higher


def balanced_amplitude(drive: float, alpha: float, beta: float, delta: float, f0: float) -> float:
    """The largest amplitude that harmonic balance has at a drive (1.120), beta != 0.

    S = A^2 solves S ((g + h S)^2 + d) = f0^2, g = alpha - w^2, h = 3 beta/4, d = 4 delta^2 w^2; by
    bisection beyond the last turning point of the cubic.
    """
    gap = alpha - drive**2
    h = 0.75 * beta
    drag = (2 * delta * drive) ** 2

    def excess(s: float) -> float:
        return s * ((gap + h * s) * (gap + h * s) + drag) - f0 * f0

    # The cubic turns at S = (-2 g +- sqrt(g^2 - 3 d))/(3 h).
    root = float(np.sqrt(max(0.0, gap**2 - 3 * drag)))
    last_turning = max(0.0, (-2 * gap + root) / (3 * h), (-2 * gap - root) / (3 * h))
    if excess(last_turning) <= 0:
        low = last_turning
    else:
        low = 0.0
    # For g = d = 0 the solution is (f0/h)^(2/3).
    high = max(low, float((abs(f0) / abs(h)) ** (2 / 3)))
    while excess(high) < 0:
        high *= 2
    for _ in range(60):
        middle = (low + high) / 2
        if excess(middle) < 0:
            low = middle
        else:
            high = middle
    return float(np.sqrt(high))


def fold(amplitude: Array, alpha: float, beta: float, delta: float, f0: float) -> float | None:
    """The frequency from which harmonic balance has three amplitudes: the least of the higher
    branch inside `amplitude`, or None.
    """
    _, higher = balanced_drives(amplitude, alpha, beta, delta, f0)
    higher = higher[np.isfinite(higher)]
    inner = higher[1:-1]
    is_least = (inner < higher[:-2]) & (inner <= higher[2:])
    least = inner[is_least]
    if len(least):
        return float(least[0])
    return None


def hysteresis(
    drive: Array, up: Array, down: Array, *, part: float = 0.05
) -> tuple[float, float] | None:
    """Lowest and highest of the frequencies `drive` (M,) at which the amplitudes of the two sweeps
    differ by more than a part.
    """
    differs = np.abs(up - down) > part * np.maximum(up, down)
    apart = drive[differs]
    if not len(apart):
        return None
    return float(apart[0]), float(apart[-1])
