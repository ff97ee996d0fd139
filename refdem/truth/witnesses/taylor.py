"""Taylor integration of y' = f(t, y) at many digits, without any proof: only midpoints of balls are
used, and the step follows from the last coefficients.

Order and step after Jorba and Zou, Experimental Mathematics 14 (2005) 99: the order is half the
bits times log 2, the step rho/e^2 with the radius of convergence rho estimated from the last
coefficients. Numbers are balls only because they have many digits: their radii are dropped after
each step.
"""

import math
from bisect import bisect_right
from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Any

from flint import arb, arb_poly, arb_series

from refdem.truth.balls import arb_of, precision, series_length, terms_of

Field = Callable[[Any, Sequence[Any]], list[Any]]
"""The right-hand side f(t, y), written with + - * / and the methods of arb_series."""
BITS = 192
"""Bits of the coefficients, three times those of binary64."""
LAST = 6
"""Number of last coefficients from which the step is estimated. In a motion with symmetries it may
be that only every fourth coefficient differs from 0.
"""


class Solution:
    """The motion y' = f(t, y) from `start` at t = `begin`, integrated as far as needed.

    Piece i is a polynomial in t - begins[i] for each component, used up to the time ends[i].
    """

    def __init__(
        self, field: Field, start: Sequence[arb], *, begin: arb | None = None, bits: int = BITS
    ) -> None:
        self.field = field
        self.bits = bits
        self.order = math.ceil(bits * math.log(2) / 2)
        self.begins: list[arb] = []
        self.ends: list[float] = []
        self.pieces: list[list[arb_poly]] = []
        first_time = arb(0)
        if begin is not None:
            first_time = begin
        # Time and state from which the next piece starts.
        self.next = first_time, [value.mid() for value in start]

    def at(self, t: arb | Fraction) -> list[arb]:
        """The state at t, at or after the start."""
        if isinstance(t, arb):
            time = t
        else:
            time = arb_of(t)
        with precision(self.bits):
            while not self.ends or self.ends[-1] <= float(time):
                self._advance()
            index = bisect_right(self.ends, float(time))
            since = time - self.begins[index]
            return [polynomial(since) for polynomial in self.pieces[index]]

    def crossing(self, value: Callable[[Sequence[arb]], arb], near: float, apart: float) -> arb:
        """The time near `near` at which a function of the state is 0, by the secant method.

        It starts from near - apart and near + apart.
        """
        with precision(self.bits):
            a = arb(near - apart)
            b = arb(near + apart)
            value_a = value(self.at(a))
            value_b = value(self.at(b))
            for _ in range(60):
                if abs(b - a) < arb(2) ** (8 - self.bits) or value_a.mid() == value_b.mid():
                    break
                # t_(k+1) = t_k - g(t_k) (t_k - t_(k-1))/(g(t_k) - g(t_(k-1)))
                secant = (b - value_b * (b - a) / (value_b - value_a)).mid()
                a = b
                value_a = value_b
                b = secant
                value_b = value(self.at(b))
            return b

    def bisected(self, value: Callable[[Sequence[arb]], arb], low: float, high: float) -> arb:
        """The time between `low` and `high` at which a function of the state changes its sign, by
        bisection.
        """
        a = arb(low)
        b = arb(high)
        rises = value(self.at(b)) > 0
        with precision(self.bits + 16):
            for _ in range(self.bits):
                middle = ((a + b) / 2).mid()
                if (value(self.at(middle)) > 0) == rises:
                    b = middle
                else:
                    a = middle
        return b

    def _advance(self) -> None:
        """Integrates the solution one step further.

        The radius of convergence is estimated as min over n of (|y_0|/|y_n|)^(1/n), at most 8.
        """
        begin, start = self.next
        series = self._series(begin, start)
        start_size = max(float(abs(value).mid()) for value in start)
        if start_size == 0:
            start_size = 1.0
        radii = [8.0]
        for n in range(self.order - LAST, self.order + 1):
            coefficient = max(abs(polynomial[n]) for polynomial in series)
            if coefficient > 0:
                # (|y_0|/|y_n|)^(1/n), by logarithms, as y_n may be below the smallest double.
                radii.append(math.exp(-(_logarithm(coefficient) - math.log(start_size)) / n))
        # Jorba and Zou: h = rho/e^2.
        step = arb(min(radii) / math.e**2)
        self.begins.append(begin)
        self.pieces.append(series)
        self.ends.append(float((begin + step).mid()))
        self.next = (begin + step).mid(), [polynomial(step).mid() for polynomial in series]

    def _series(self, begin: arb, start: Sequence[arb]) -> list[arb_poly]:
        """The Taylor polynomials of the solution at `begin`, by Picard iteration.

        Each pass y <- y(begin) + integral of f(t, y) determines one more coefficient.
        """
        with series_length(1):
            series = [arb_series([value]) for value in start]
        for length in range(2, self.order + 2):
            with series_length(length):
                clock = arb_series([begin, arb(1)], prec=length)
                rates = map(_as_series, self.field(clock, series))
                # y <- y(begin) + integral of f(t, y)
                series = [value + rate.integral() for value, rate in zip(start, rates, strict=True)]
        return [
            arb_poly([value.mid() for value in terms_of(one, self.order + 1)]) for one in series
        ]


def _as_series(value: Any) -> arb_series:
    """A power series of a rate, which may be a constant."""
    if isinstance(value, arb_series):
        return value
    return arb_series([arb(value)])


def _logarithm(value: arb) -> float:
    """log of a positive ball that may be far below the smallest double."""
    return float(value.mid().log())
