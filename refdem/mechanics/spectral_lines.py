"""Lines of a sampled motion at known frequencies, by least squares: a linear map of the samples.

    x(t_j)  =  sum over lines of Re(c_k exp(i w_k t_j))  +  free motion  +  residual

The free motion of a damped oscillator, x'' + 2 delta x' + w0^2 x = 0, is fitted together with the
lines, so that the lines are those of the forced motion. The map from samples to c_k is linear: for
two motions at the same times c_k(x) - c_k(y) = c_k(x - y), for any residual.
"""

from collections.abc import Sequence
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

SAME = 1e-9
"""Relative distance below which two frequencies are one line."""
REPRODUCED = 1e-6
"""Largest error with which a map reproduces the amplitudes of lines that it can distinguish."""
FARTHEST = 0.1
"""Largest shift of the frequency of a cycle by a drive that is searched, relative to it."""
GOLDEN = (5**0.5 - 1) / 2
"""Ratio of the lengths of an interval after and before a golden section."""
GOLDEN_SECTIONS = 30
"""Golden sections of the interval of a frequency, which reduce it to a millionth. A minimum cannot
be located more closely, because the square of a smaller distance is lost in rounding.
"""


class Line(NamedTuple):
    """A line by its name, such as `w1+w2`, and its frequency [rad/s], 0 or more."""

    name: str
    frequency: float


def mixed_lines(
    drives: Sequence[float], order: int, *, odd: bool = False, names: Sequence[str] = ()
) -> tuple[Line, ...]:
    """The lines of a polynomial of the given order in cosines of the `drives` [rad/s]: the shift,
    and sums and differences of at most `order` drives. Drives are called w1, w2 ... or by `names`.

    (A cos w1 t + B cos w2 t)^2 has lines at 0, 2 w1, 2 w2, w1 + w2 and |w1 - w2| (1.123). A
    polynomial of `odd` powers has only those of an odd number of drives. The shift is always
    included, though it may be 0. Of two lines at the same frequency the simpler one is kept.
    """
    counts = [
        given
        for given in product(range(-order, order + 1), repeat=len(drives))
        if 0 < sum(map(abs, given)) <= order and not (odd and sum(given) % 2 == 0)
    ]
    # Fewer drives first, and of those positive ones before negative ones.
    counts.sort(key=lambda given: (sum(map(abs, given)), [-n for n in given]))
    lines = [Line("shift", 0.0)]
    for given in counts:
        frequency = float(sum(n * w for n, w in zip(given, drives, strict=True)))
        is_new = all(
            abs(frequency - line.frequency) > SAME * max(*drives, frequency) for line in lines
        )
        if frequency > 0 and is_new:
            lines.append(Line(_name(given, names), frequency))
    return tuple(lines)


def _name(given: Sequence[int], names: Sequence[str] = ()) -> str:
    """The name of the sum of n_i w_i with the factors `given`: `w1+w2`, `2w2-w1`, or `2w`."""
    if not names:
        names = ["w"]
        if len(given) > 1:
            names = [f"w{number}" for number in range(1, len(given) + 1)]
    terms = [(n, name) for n, name in zip(given, names, strict=True) if n]
    # Positive terms come before negative ones.
    terms.sort(key=lambda term: term[0] < 0)
    text = ""
    for n, name in terms:
        sign = "-" if n < 0 else "+"
        factor = "" if abs(n) == 1 else str(abs(n))
        text += f"{sign}{factor}{name}"
    return text.removeprefix("+")


def free_motions(t: Array, square: float, delta: float) -> Array:
    """Two independent motions (2, T) of x'' + 2 delta x' + w0^2 x = 0 at t (T,) [s], `square` being
    w0^2; the larger of them is 1 at the start.
    """
    since = t - t[0]
    discriminant = delta**2 - square
    if discriminant < 0:
        # exp(-delta t) cos(w t) and exp(-delta t) sin(w t) with w^2 = w0^2 - delta^2.
        decay = np.exp(-delta * since)
        phase = np.sqrt(-discriminant) * since
        return np.stack([decay * np.cos(phase), decay * np.sin(phase)])
    # Both roots are real: -delta +- sqrt(delta^2 - w0^2), or -delta twice.
    gap = float(np.sqrt(discriminant))
    if gap == 0:
        # exp(-delta t) and delta t exp(-delta t).
        decay = np.exp(-delta * since)
        return np.stack([decay, delta * since * decay])
    return np.stack([np.exp((gap - delta) * since), np.exp(-(gap + delta) * since)])


def line_map(t: Array, lines: Sequence[Line], others: Array) -> Complex | None:
    """The rows (K, T) that give the complex amplitudes c = a - i b of the `lines` of a signal (T,)
    at t (T,) [s], with a cos(w t) + b sin(w t); `others` (M, T) are fitted together with them.

    None if the samples do not determine all amplitudes.
    """
    columns = []
    for _, w in lines:
        columns.append(np.cos(w * t))
        if w > 0:
            columns.append(np.sin(w * t))
    fitted = np.concatenate([np.array(columns), others])
    count = len(columns)
    if len(t) < len(fitted):
        return None
    rows = np.linalg.pinv(fitted.T)[:count]
    # rows @ fitted^T must be the identity: a signal equal to one column has its amplitude only.
    given_back = rows @ fitted.T
    if np.max(np.abs(given_back - np.eye(count, len(fitted)))) > REPRODUCED:
        return None
    # c = a - i b, so that Re(c exp(i w t)) = a cos(w t) + b sin(w t).
    complex_rows = []
    at = 0
    for _, w in lines:
        if w > 0:
            complex_rows.append(rows[at] - 1j * rows[at + 1])
            at += 2
        else:
            complex_rows.append(rows[at].astype(np.complex128))
            at += 1
    return np.array(complex_rows)


def cycle_lines(cycle: float, drive: float, order: int) -> tuple[Line, ...]:
    """The lines of a cycle at w = `cycle` [rad/s] that mixes with a drive wd = `drive` [rad/s] in
    odd powers up to `order`: 2w-wd, 3w-2wd and the others.
    """
    return mixed_lines((cycle, drive), order, odd=True, names=("w", "wd"))


def cycle_frequency(t: Array, x: Array, near: float, drive: float, order: int) -> float:
    """The frequency w [rad/s] near `near` of a cycle for which its lines with a drive fit the
    signal x (T,) at t (T,) [s] best, in the sense of least squares.

    A drive shifts the frequency of the cycle, for which there is no formula. It is searched up to
    half way to the drive, first on a grid whose steps change the phase by at most 1 rad, then by
    golden sections.
    """

    def left(w: float) -> float:
        """The mean square residual of the fit with lines at w."""
        columns = []
        for _, frequency in cycle_lines(w, drive, order):
            columns += [np.cos(frequency * t), np.sin(frequency * t)]
        fitted = np.array(columns).T
        amplitudes = np.linalg.lstsq(fitted, x, rcond=None)[0]
        return float(np.mean((fitted @ amplitudes - x) ** 2))

    reach = min(FARTHEST * near, abs(drive - near) / 2)
    count = 2 * int(np.ceil(reach * (t[-1] - t[0]))) + 1
    tried = np.linspace(near - reach, near + reach, count)
    best = int(np.argmin([left(w) for w in tried.tolist()]))
    low = float(tried[max(best - 1, 0)])
    high = float(tried[min(best + 1, count - 1)])
    for _ in range(GOLDEN_SECTIONS):
        below = high - GOLDEN * (high - low)
        above = low + GOLDEN * (high - low)
        if left(below) < left(above):
            high = above
        else:
            low = below
    return (low + high) / 2
