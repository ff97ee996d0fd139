"""Response of driven oscillators in formulas: linear resonance (1.105), (1.106), harmonic balance
(1.115), (1.121), and hysteresis of sweeps.

The oscillator is x'' + 2 delta x' + alpha x + beta x^3 = f0 cos(w t); the linear one has alpha =
w0^2, beta = 0. Harmonic balance keeps only the terms at w of x = A cos(w t + phase).
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

HALVINGS = 120
"""Bisections after which an interval has no double inside, if the ratio of its ends is at most
2^60.
"""


class Folds(NamedTuple):
    """Drive [rad/s] and amplitude [m] at the two folds of the response curve: `lower` at the lowest
    and `upper` at the highest drive that has three amplitudes.
    """

    lower: tuple[float, float]
    upper: tuple[float, float]


def linear_amplitude(drive: Array, square: float, delta: float, f0: float) -> Array:
    """Steady amplitude f0/sqrt((w0^2 - w^2)^2 + 4 delta^2 w^2) at w = `drive` [rad/s] (1.105);
    `square` is w0^2.
    """
    amplitude: Array = f0 / np.hypot(square - drive**2, 2 * delta * drive)
    return amplitude


def linear_peak(square: float, delta: float, f0: float) -> tuple[float, float]:
    """Frequency sqrt(w0^2 - 2 delta^2) and height f0/(2 delta sqrt(w0^2 - delta^2)) of the
    resonance peak, for 2 delta^2 < w0^2 (1.106).
    """
    # d/dw of the radicand of (1.105) is 0 at w^2 = w0^2 - 2 delta^2.
    frequency = float(np.sqrt(square - 2 * delta**2))
    height = float(f0 / (2 * delta * np.sqrt(square - delta**2)))
    return frequency, height


def balanced_frequency(amplitude: Array, alpha: float, beta: float) -> Array:
    """Frequency sqrt(alpha + 3 beta A^2/4) of free oscillations by harmonic balance (1.115); too
    high by 3/256 (beta A^2/alpha)^2 w0.
    """
    frequency: Array = np.sqrt(alpha + 0.75 * beta * amplitude**2)
    return frequency


def balanced_drives(
    amplitude: Array, alpha: float, beta: float, delta: float, f0: float
) -> tuple[Array, Array]:
    """The lower and the higher drive frequency at which harmonic balance has the amplitude A
    (1.121); nan where there is none.

    W^2 = k - 2 delta^2 -+ sqrt(f0^2/A^2 - 4 delta^2 (k - delta^2)), with k = alpha + 3 beta A^2/4.
    """
    # k = alpha + 3 beta A^2/4, the square of the free frequency at the amplitude A.
    k = alpha + 0.75 * beta * amplitude**2
    # (k - W^2)^2 + 4 delta^2 W^2 = f0^2/A^2 is a quadratic equation in W^2.
    discriminant = (f0 / amplitude) ** 2 - 4 * delta**2 * (k - delta**2)
    with np.errstate(invalid="ignore"):
        root = np.sqrt(discriminant)
        lower = np.sqrt(k - 2 * delta**2 - root)
        higher = np.sqrt(k - 2 * delta**2 + root)
    return lower, higher


def balanced_amplitude(drive: float, alpha: float, beta: float, delta: float, f0: float) -> float:
    """The largest amplitude A of harmonic balance at a drive frequency w (1.120), for beta != 0.

    S = A^2 solves S ((g + h S)^2 + d) = f0^2 with g = alpha - w^2, h = 3 beta/4, d = 4 delta^2 w^2.
    The left side grows beyond its last turning point, so the largest solution is found by bisection
    there.
    """
    g = alpha - drive**2
    h = 0.75 * beta
    d = (2 * delta * drive) ** 2

    def excess(s: float) -> float:
        """S ((g + h S)^2 + d) - f0^2."""
        return s * ((g + h * s) * (g + h * s) + d) - f0 * f0

    # The derivative 3 h^2 S^2 + 4 g h S + g^2 + d of the cubic is 0 at
    # S = (-2 g +- sqrt(g^2 - 3 d))/(3 h).
    root = float(np.sqrt(max(0.0, g**2 - 3 * d)))
    last_turning = max(0.0, (-2 * g + root) / (3 * h), (-2 * g - root) / (3 * h))
    if excess(last_turning) <= 0:
        low = last_turning
    else:
        low = 0.0
    # For g = d = 0 the solution is S = (f0/h)^(2/3); double it until the cubic exceeds f0^2.
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
    """The frequency from which harmonic balance has three amplitudes, or None.

    It is the first local minimum, inside the range of `amplitude`, of the higher drive frequency as
    a function of amplitude.
    """
    _, higher = balanced_drives(amplitude, alpha, beta, delta, f0)
    higher = higher[np.isfinite(higher)]
    # Local minima of the higher branch, the end points left out.
    inner = higher[1:-1]
    is_minimum = (inner < higher[:-2]) & (inner <= higher[2:])
    minima = inner[is_minimum]
    if len(minima):
        return float(minima[0])
    return None


def balanced_force(
    amplitude: float, drive: float, alpha: float, beta: float, delta: float
) -> float:
    """The force f0 that harmonic balance needs for the amplitude A at a drive frequency w (1.120).

    f0^2 = A^2 ((k - w^2)^2 + 4 delta^2 w^2), with k = alpha + 3 beta A^2/4.
    """
    k = alpha + 0.75 * beta * amplitude**2
    return float(amplitude * np.hypot(k - drive**2, 2 * delta * drive))


class _Balance(NamedTuple):
    """The balance (1.120) at a fold, where two of its solutions merge: S = A^2 solves `excess` = 0.

    With h = 3 beta/4 and u = alpha + h S - w^2 the balance is S (u^2 + 4 delta^2 w^2) = f0^2. At a
    fold its derivative by S vanishes too, which gives u = -f0^2/(2 h S^2) and

        16 delta^2 h^2 (h S^2 + alpha S) + 8 delta^2 h f0^2/S + f0^4/S^3 = 4 h^2 f0^2.

    `damping` is 4 delta^2, `square` f0^2.
    """

    alpha: float
    h: float
    damping: float
    square: float

    @property
    def undamped(self) -> float:
        """The square S of the amplitude of the only fold without damping, S^3 = f0^2/(4 h^2)."""
        return float(np.cbrt(self.square / (4 * self.h * self.h)))

    def excess(self, s: float) -> float:
        """The left side of the equation of the folds minus its right side."""
        # 4 d h^2 (h S^2 + alpha S) + 2 d h f0^2/S + f0^4/S^3 - 4 h^2 f0^2, with d = 4 delta^2.
        h = self.h
        stiff = 4 * self.damping * h * h * (h * s + self.alpha) * s
        driven = 2 * self.damping * h * self.square / s + self.square * self.square / s**3
        return stiff + driven - 4 * h * h * self.square

    def slope(self, s: float) -> float:
        """The derivative of `excess` by S."""
        # 4 d h^2 (2 h S + alpha) - 2 d h f0^2/S^2 - 3 f0^4/S^4, with d = 4 delta^2.
        h = self.h
        stiff = 4 * self.damping * h * h * (2 * h * s + self.alpha)
        driven = 2 * self.damping * h * self.square / s**2 + 3 * self.square * self.square / s**4
        return stiff - driven

    def drive_square(self, s: float) -> float:
        """The square of the drive of a fold, from u: w^2 = alpha + h S + f0^2/(2 h S^2)."""
        return self.alpha + self.h * s + self.square / (2 * self.h * s * s)

    def fold_at(self, s: float) -> tuple[float, float]:
        """Drive [rad/s] and amplitude of the fold at S = A^2."""
        return float(np.sqrt(self.drive_square(s))), float(np.sqrt(s))


def folds(alpha: float, beta: float, delta: float, f0: float) -> Folds | None:
    """Both folds of harmonic balance (1.120), or None if every drive has only one amplitude; for
    alpha, delta > 0, beta != 0 and f0 != 0.

    The resonance of a hardening spring, beta > 0, bends to higher drives, and that of a softening
    spring to lower ones. The fold of larger amplitude is the upper one for beta > 0 and the lower
    one for beta < 0. The result is also None for a softening spring if the branches of the
    resonance do not meet below the potential barrier, or if w^2 < 0 at the lower fold.
    """
    balance = _Balance(alpha, 0.75 * beta, 4 * delta * delta, f0 * f0)
    if beta > 0:
        return _hardening_folds(balance)
    return _softening_folds(balance, delta)


def _hardening_folds(balance: _Balance) -> Folds | None:
    """The folds for h > 0: each term of the left side is convex for S > 0, so that there are two
    solutions or none.
    """
    # At the undamped fold f0^4/S^3 = 4 h^2 f0^2, so that the excess is >= 0. Both solutions lie at
    # larger S, one on each side of the minimum of the excess.
    undamped = balance.undamped
    if balance.slope(undamped) >= 0:
        return None
    beyond = undamped
    while balance.slope(beyond) < 0:
        beyond *= 2
    least = _change_of_sign(balance.slope, undamped, beyond)
    if balance.excess(least) >= 0:
        return None
    while balance.excess(beyond) < 0:
        beyond *= 2
    lower = _change_of_sign(balance.excess, least, undamped)
    upper = _change_of_sign(balance.excess, least, beyond)
    return Folds(lower=balance.fold_at(lower), upper=balance.fold_at(upper))


def _softening_folds(balance: _Balance, delta: float) -> Folds | None:
    """The folds for h < 0, below the tip of the resonance.

    Both branches w^2 = alpha + h S - 2 delta^2 -+ sqrt(f0^2/S - 4 delta^2 (alpha + h S - delta^2))
    meet where the root vanishes: 4 delta^2 (-h) S^2 - 4 delta^2 (alpha - delta^2) S + f0^2 = 0. The
    smaller solution is the tip; a third fold lies beyond the larger one, at the barrier.
    """
    # The smaller root of a S^2 - b S + f0^2 = 0, with a = -4 delta^2 h and b = 4 delta^2 (alpha -
    # delta^2), is 2 f0^2/(b + sqrt(b^2 - 4 a f0^2)), without cancellation.
    linear = balance.damping * (balance.alpha - delta * delta)
    discriminant = linear**2 + 4 * balance.damping * balance.h * balance.square
    if linear <= 0 or discriminant <= 0:
        return None
    tip = 2 * balance.square / (linear + float(np.sqrt(discriminant)))
    least = _least_excess(balance)
    is_folded = least < tip and balance.excess(least) < 0 < balance.excess(tip)
    if not is_folded:
        return None
    before = least
    while balance.excess(before) < 0:
        before /= 2
    upper = _change_of_sign(balance.excess, least, before)
    lower = _change_of_sign(balance.excess, least, tip)
    if balance.drive_square(lower) <= 0:
        return None
    return Folds(lower=balance.fold_at(lower), upper=balance.fold_at(upper))


def _least_excess(balance: _Balance) -> float:
    """The smallest S > 0 at which the slope of the excess changes its sign; infinite if nowhere.

    S^4 times the slope is a polynomial, 8 d h^3 S^5 + 4 d h^2 alpha S^4 - 2 d h f0^2 S^2 - 3 f0^4
    with d = 4 delta^2, here of S in units of the undamped fold.
    """
    unit = balance.undamped
    h = balance.h
    d = balance.damping
    force_square = balance.square
    # With S = s S_0: 8 d h^3 S_0^5 s^5 + 4 d h^2 alpha S_0^4 s^4 - 2 d h f0^2 S_0^2 s^2 - 3 f0^4,
    # where S_0 is the undamped fold.
    fifth = 8 * d * h**3 * unit**5
    fourth = 4 * d * h**2 * balance.alpha * unit**4
    second = -2 * d * h * force_square * unit**2
    constant = -3 * force_square**2
    roots = np.roots([fifth, fourth, 0.0, second, 0.0, constant])
    positive = roots.real[(roots.imag == 0) & (roots.real > 0)]
    return float(unit * np.min(positive, initial=np.inf))


def _change_of_sign(value: Callable[[float], float], below: float, above: float) -> float:
    """The zero of a function that is negative at `below` and positive at `above`, by bisection."""
    for _ in range(HALVINGS):
        middle = (below + above) / 2
        if value(middle) < 0:
            below = middle
        else:
            above = middle
    return (below + above) / 2


def hysteresis(
    drive: Array, up: Array, down: Array, *, part: float = 0.05
) -> tuple[float, float] | None:
    """Lowest and highest of the drive frequencies (M,) at which the amplitudes of an upward and a
    downward sweep differ by more than a `part`; None if none do.
    """
    differs = np.abs(up - down) > part * np.maximum(up, down)
    bistable = drive[differs]
    if not len(bistable):
        return None
    return float(bistable[0]), float(bistable[-1])


def linear_line(force: float, frequency: float, square: float, delta: float) -> complex:
    """Complex amplitude A = f/D(w) of the steady motion Re(A exp(i w t)) under f cos(w t), with
    D(w) = w0^2 - w^2 + 2 i delta w; `square` is w0^2. Its modulus is (1.105).
    """
    # A = f/(w0^2 - w^2 + 2 i delta w).
    return force / complex(square - frequency**2, 2 * delta * frequency)


def mixed_line(
    a: complex, b: complex, frequency: float, square: float, delta: float, eps: float
) -> complex:
    """Complex amplitude -eps a b/D(w) of the line that the quadratic force -eps x^2 generates from
    two lines a, b, at the sum w = `frequency` [rad/s] of their frequencies. It is half of this if a
    line is mixed with itself.

    2 Re(a exp(i u t)) Re(b exp(i v t)) = Re(a b exp(i (u + v) t)) + Re(a b* exp(i (u - v) t)). For
    the line at the difference of the frequencies b is replaced by its conjugate, and each drive
    contributes half of the amplitude at its own difference, 0, to the shift (1.123). The formula is
    of first order in eps. These lines are odd in eps, because x -> -x, eps -> -eps, f -> -f is a
    symmetry; the relative error is therefore of order eps^2.
    """
    return -linear_line(eps, frequency, square, delta) * a * b
