"""Tangential slip against a wall in Hertz's contact with a Mindlin spring, whose stiffness is
proportional to sqrt(d), d the overlap: Taylor series in a time variable that makes the motion
analytic.

Units: the greatest overlap and the speed at first contact. With w = sqrt(d), v = d' and dt = w ds,
Hertz's contact reads

  w' = v/2,   v' = -5/4 w^4              (' is d/ds)

analytic from first contact to release. p is the slip velocity and q the slip distance, q' = w p:

  sticking   p' = -35/8 (k_t/k) w^2 (q - q0)      q0 is where the spring is relaxed
  sliding    p' = -+35/8 mu w^4                   the spring is stretched by +-g d, g = mu k/k_t

35/8 is 5/4 times 7/2, the factor by which a force at the contact point accelerates the slip of a
solid sphere. The contact is a sequence of pieces; each ends where the spring reaches its limit or
is released from it.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from math import sqrt

import numpy as np
from numpy.polynomial import polynomial
from numpy.typing import NDArray

Array = NDArray[np.float64]
Value = Callable[[float], float]
ORDER = 20
"""Order of the Taylor series."""
STEP = 0.125
"""Longest step in s."""
LOOKS = 8
"""Points in a step at which the signs of the event functions are tested."""
STICKS = 0
"""The mode in which the spring sticks; +1 and -1 are sliding in either direction."""
W, V, P, Q = range(4)


@dataclass(frozen=True)
class Spring:
    """A tangential spring with `ratio` k_t/k and friction coefficient `friction` mu."""

    ratio: float
    friction: float

    @property
    def slack(self) -> float:
        """g = mu k/k_t: the largest stretch over the overlap."""
        return self.friction / self.ratio

    def series(self, start: Sequence[float], side: int, relaxed_at: float) -> Array:
        """Taylor coefficients (4, ORDER + 1) in s of the solution w, v, p, q (rows W, V, P, Q) from
        `start`.

        `side` is the mode. While the spring sticks (0), its stretch is q - `relaxed_at`; else it
        slides with the sign of `side`.
        """
        c = np.zeros((4, ORDER + 1))
        c[:, 0] = start
        w2, w4, pull = np.zeros((3, ORDER + 1))
        for n in range(ORDER):
            # Coefficient n of a product is the sum over k of a_k b_(n-k): the first n + 1
            # coefficients of one factor times those of the other in reverse.
            first_n = slice(0, n + 1)
            if n:
                first_n_reversed = slice(n, None, -1)
            else:
                first_n_reversed = slice(0, 1)
            w2[n] = c[W, first_n] @ c[W, first_n_reversed]
            w4[n] = w2[first_n] @ w2[first_n_reversed]
            if side == STICKS:
                stretch = c[Q, first_n] - np.eye(1, n + 1)[0] * relaxed_at
                pull[n] = self.ratio * (w2[first_n] @ stretch[::-1])
            else:
                pull[n] = side * self.friction * w4[n]
            # w' = v/2, v' = -5/4 w^4, p' = -35/8 pull, q' = w p; the pull is (k_t/k) w^2 stretch
            # or +-mu w^4. Coefficient n + 1 of a function is coefficient n of its derivative over
            # n + 1.
            w_rate = c[V, n] / 2
            v_rate = -1.25 * w4[n]
            p_rate = -4.375 * pull[n]
            q_rate = c[W, first_n] @ c[P, first_n_reversed]
            c[:, n + 1] = np.array([w_rate, v_rate, p_rate, q_rate]) / (n + 1)
        return c

    def ends(self, c: Array, side: int, relaxed_at: float) -> list[tuple[Value, int | None]]:
        """Functions of s that are positive as long as the mode lasts, each with the mode that
        follows it; None is release.

        Sticking lasts while g d -+ (q - q0) > 0, with d = w^2. Sliding in the direction of `side`
        lasts while side p > g d', where g d' is the rate of the limit g d of the stretch. The
        contact lasts while w > 0.
        """

        def limit(sign: int, s: float) -> float:
            return self.slack * _at(c[W], s) ** 2 - sign * (_at(c[Q], s) - relaxed_at)

        def slip(s: float) -> float:
            return side * _at(c[P], s) - self.slack * _at(c[V], s)

        release: tuple[Value, int | None] = (partial(_at, c[W]), None)
        if side == STICKS:
            return [(partial(limit, 1), 1), (partial(limit, -1), -1), release]
        return [(slip, STICKS), release]


@dataclass(frozen=True)
class Course:
    """The contact as a sequence of series (4, ORDER + 1), each with its length in s."""

    pieces: list[tuple[Array, float]]

    def at(self, overlap: float, rate: float) -> tuple[float, float]:
        """Slip velocity and slip distance at the moment with the given overlap and rate d'.

        s is found by Newton's method: for w(s) = sqrt(d) where |d'| > 0.7, else for v(s) = d'. The
        derivative of the chosen function, v/2 or -5/4 w^4, is at least 0.35 in size there.
        """
        if abs(rate) > 0.7:
            variable = W
            target = sqrt(overlap)
        else:
            variable = V
            target = rate
        # d' decreases throughout the contact (d'' < 0), so that the moment is in the first piece at
        # the end of which d' is at most the rate.
        for c, length in self.pieces:
            if _at(c[V], length) <= rate:
                break
        s = length / 2
        derivative = polynomial.polyder(c[variable])
        for _ in range(50):
            # s <- s + (target - y(s))/y'(s).
            correction = (target - _at(c[variable], s)) / _at(derivative, s)
            s = min(max(s + correction, 0.0), length)
            if abs(correction) <= 1e-16:
                break
        return _at(c[P], s), _at(c[Q], s)

    def end(self) -> tuple[float, float]:
        """Slip velocity and slip distance at release."""
        c, length = self.pieces[-1]
        return _at(c[P], length), _at(c[Q], length)


def course(spring: Spring, slip: float) -> Course:
    """The contact from first contact to release, with initial slip velocity `slip` > 0 in units of
    the speed.
    """
    state = [0.0, 1.0, slip, 0.0]
    relaxed_at = 0.0
    # At first contact d' = 1, so that the limit of the stretch grows at the rate g. A slip faster
    # than g slides from the start.
    if slip > spring.slack:
        mode: int | None = 1
    else:
        mode = STICKS
    pieces: list[tuple[Array, float]] = []
    while mode is not None:
        c = spring.series(state, mode, relaxed_at)
        length, next_mode = _first(spring.ends(c, mode, relaxed_at), mode)
        pieces.append((c, length))
        state = [_at(row, length) for row in c]
        if mode != STICKS and next_mode == STICKS:
            # When sliding ends the spring is at its limit: q - q0 = +-g d with d = w^2.
            relaxed_at = state[Q] - mode * spring.slack * state[W] ** 2
        mode = next_mode
    return Course(pieces)


def _at(row: Array, s: float) -> float:
    """The polynomial with coefficients `row` at s."""
    return float(polynomial.polyval(s, row))


def _first(ends: Sequence[tuple[Value, int | None]], mode: int) -> tuple[float, int | None]:
    """Length of a piece and the mode after it: the first zero of any function, by bisection; STEP
    and the same mode without one.
    """
    for interval in range(LOOKS):
        low = STEP * interval / LOOKS
        high = STEP * (interval + 1) / LOOKS
        zeros = []
        for index, (value, _) in enumerate(ends):
            if value(high) < 0:
                zeros.append((_zero(value, low, high), index))
        if zeros:
            length, ended = min(zeros)
            _, next_mode = ends[ended]
            return length, next_mode
    return STEP, mode


def _zero(value: Value, low: float, high: float) -> float:
    """The point where a function that is positive at `low` and negative at `high` is zero, by 60
    bisections.
    """
    for _ in range(60):
        middle = (low + high) / 2
        if value(middle) > 0:
            low = middle
        else:
            high = middle
    return high
