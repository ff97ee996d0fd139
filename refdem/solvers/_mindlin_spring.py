"""Slip against a wall under a tangential spring that stiffens as the root of the overlap: Taylor
series in a time that makes it smooth.

In units of the greatest overlap and the speed at touch, with w = sqrt(d) and dt = w ds, Hertz's
contact is w' = v/2, v' = -5/4 w^4 in s, analytic from touch to release. The slip p has the way q,
q' = w p; while the spring sticks p' = -35/8 (k_t/k) w^2 stretch, while it slides p' = -+35/8 mu w^4
and its stretch is +-g d, g = mu k/k_t. Pieces end where the spring comes to its limit, is caught,
or is let go.
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
STEP = 0.125
LOOKS = 8
STICKS = 0
"""The mode; +1 and -1 slide."""
W, V, P, Q = range(4)


@dataclass(frozen=True)
class Spring:
    """A tangential spring: `ratio` = k_t/k of the stiffnesses, and `friction` = mu."""

    ratio: float
    friction: float

    @property
    def slack(self) -> float:
        """g = mu k/k_t: the longest stretch over the overlap."""
        return self.friction / self.ratio

    def series(self, start: Sequence[float], side: int, hangs: float) -> Array:
        """Taylor coefficients (4, ORDER + 1) of w, v, p, q in s; the stretch is q - hangs while it
        sticks (side 0).
        """
        c = np.zeros((4, ORDER + 1))
        c[:, 0] = start
        square, fourth, pull = np.zeros((3, ORDER + 1))
        for n in range(ORDER):
            # A product's coefficient n is the sum over k of a_k b_(n-k).
            upto = slice(0, n + 1)
            if n:
                back = slice(n, None, -1)
            else:
                back = slice(0, 1)
            square[n] = c[W, upto] @ c[W, back]
            fourth[n] = square[upto] @ square[back]
            if side == STICKS:
                stretch = c[Q, upto] - np.eye(1, n + 1)[0] * hangs
                pull[n] = self.ratio * (square[upto] @ stretch[::-1])
            else:
                pull[n] = side * self.friction * fourth[n]
            # w' = v/2, v' = -5/4 w^4, p' = -35/8 pull, q' = w p.
            w_rate = c[V, n] / 2
            v_rate = -1.25 * fourth[n]
            p_rate = -4.375 * pull[n]
            q_rate = c[W, upto] @ c[P, back]
            c[:, n + 1] = np.array([w_rate, v_rate, p_rate, q_rate]) / (n + 1)
        return c

    def ends(self, c: Array, side: int, hangs: float) -> list[tuple[Value, int | None]]:
        """What is positive in a mode, and the mode that follows it, None after release."""

        def limit(to: int, s: float) -> float:
            return self.slack * _at(c[W], s) ** 2 - to * (_at(c[Q], s) - hangs)

        def slip(s: float) -> float:
            return side * _at(c[P], s) - self.slack * _at(c[V], s)

        apart: tuple[Value, int | None] = (partial(_at, c[W]), None)
        if side == STICKS:
            return [(partial(limit, 1), 1), (partial(limit, -1), -1), apart]
        return [(slip, STICKS), apart]


@dataclass(frozen=True)
class Course:
    """Series and lengths, one after another."""

    pieces: list[tuple[Array, float]]

    def at(self, depth: float, rate: float) -> tuple[float, float]:
        """Slip and its way at an overlap and its rate: by the one of w and v that changes faster
        there.
        """
        if abs(rate) > 0.7:
            row = W
            goal = sqrt(depth)
        else:
            row = V
            goal = rate
        # The rate falls all the time: the first piece that ends at or below it.
        for c, length in self.pieces:
            if _at(c[V], length) <= rate:
                break
        s = length / 2
        slope = polynomial.polyder(c[row])
        for _ in range(50):
            change = (goal - _at(c[row], s)) / _at(slope, s)
            s = min(max(s + change, 0.0), length)
            if abs(change) <= 1e-16:
                break
        return _at(c[P], s), _at(c[Q], s)

    def end(self) -> tuple[float, float]:
        """Slip and its way where the contact ends."""
        c, length = self.pieces[-1]
        return _at(c[P], length), _at(c[Q], length)


def course(spring: Spring, slip: float) -> Course:
    """The course of the contact from touch, at a slip > 0 in units of the speed, to release."""
    state = [0.0, 1.0, slip, 0.0]
    hangs = 0.0
    if slip > spring.slack:
        mode: int | None = 1
    else:
        mode = STICKS
    pieces: list[tuple[Array, float]] = []
    while mode is not None:
        c = spring.series(state, mode, hangs)
        length, after = _first(spring.ends(c, mode, hangs), mode)
        pieces.append((c, length))
        state = [_at(row, length) for row in c]
        if mode != STICKS and after == STICKS:
            hangs = state[Q] - mode * spring.slack * state[W] ** 2
        mode = after
    return Course(pieces)


def _at(row: Array, s: float) -> float:
    return float(polynomial.polyval(s, row))


def _first(ends: Sequence[tuple[Value, int | None]], mode: int) -> tuple[float, int | None]:
    """Length of a piece and the next mode: where the first function falls through 0, found by
    bisection; STEP and the same if none does.
    """
    for look in range(LOOKS):
        low = STEP * look / LOOKS
        high = STEP * (look + 1) / LOOKS
        fallen = []
        for number, (value, _) in enumerate(ends):
            if value(high) < 0:
                fallen.append((_zero(value, low, high), number))
        if fallen:
            length, first = min(fallen)
            _, after = ends[first]
            return length, after
    return STEP, mode


def _zero(value: Value, low: float, high: float) -> float:
    """Where a function that is positive at `low` and negative at `high` falls through 0."""
    for _ in range(60):
        middle = (low + high) / 2
        if value(middle) > 0:
            low = middle
        else:
            high = middle
    return high
