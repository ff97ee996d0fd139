"""Taylor integration at many digits without any proof: y' = f(t, y), midpoints alone, the step from
the last coefficients.

Order and step after Jorba and Zou, Experimental Mathematics 14 (2005) 99: order half the bits times
log 2, step rho/e^2.
"""

import math
from bisect import bisect_right
from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Any

from flint import arb, arb_poly, arb_series

from refdem.truth.balls import arb_of, precision, series_length, terms_of

Field = Callable[[Any, Sequence[Any]], list[Any]]
"""The rates at (t, y), by + - * / and the methods of arb_series."""
BITS = 192
LAST = 6
"""Coefficients that make the step: of a motion with symmetries only every fourth may differ from 0.
"""


class Solution:
    """The motion from `start` at t = `begin`, as far as it is asked for."""

    def __init__(
        self, field: Field, start: Sequence[arb], *, begin: arb | None = None, bits: int = BITS
    ) -> None:
        self.field = field
        self.bits = bits
        self.order = math.ceil(bits * math.log(2) / 2)
        self.begins: list[arb] = []
        self.ends: list[float] = []
        self.pieces: list[list[arb_poly]] = []
        self.next = (begin if begin is not None else arb(0)), [value.mid() for value in start]

    def at(self, t: arb | Fraction) -> list[arb]:
        """The state at t, at or after the begin."""
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
        """The zero of a function of the state between near - apart and near + apart, by the
        secant.
        """
        with precision(self.bits):
            a = arb(near - apart)
            b = arb(near + apart)
            of_a = value(self.at(a))
            of_b = value(self.at(b))
            for _ in range(60):
                if abs(b - a) < arb(2) ** (8 - self.bits) or of_a.mid() == of_b.mid():
                    break
                a, of_a, b = b, of_b, (b - of_b * (b - a) / (of_b - of_a)).mid()
                of_b = value(self.at(b))
            return b

    def bisected(self, value: Callable[[Sequence[arb]], arb], low: float, high: float) -> arb:
        """The zero of a function that is negative at `low` and positive at `high`, or at both of
        the other sign, by bisection.
        """
        a = arb(low)
        b = arb(high)
        rises = value(self.at(b)) > 0
        with precision(self.bits + 16):
            for _ in range(self.bits):
                middle = ((a + b) / 2).mid()
                a, b = (a, middle) if (value(self.at(middle)) > 0) == rises else (middle, b)
        return b

    def _advance(self) -> None:
        """Integrates the solution one step further."""
        begin, start = self.next
        series = self._series(begin, start)
        size = max(float(abs(value).mid()) for value in start) or 1.0
        sizes = [
            (n, max(abs(one[n]) for one in series))
            for n in range(self.order - LAST, self.order + 1)
        ]
        radii = [
            math.exp(-(_logarithm(last) - math.log(size)) / n) for n, last in sizes if last > 0
        ]
        step = arb(min([*radii, 8.0]) / math.e**2)
        self.begins.append(begin)
        self.pieces.append(series)
        self.ends.append(float((begin + step).mid()))
        self.next = (begin + step).mid(), [polynomial(step).mid() for polynomial in series]

    def _series(self, begin: arb, start: Sequence[arb]) -> list[arb_poly]:
        with series_length(1):
            series = [arb_series([value]) for value in start]
        for length in range(2, self.order + 2):
            with series_length(length):
                clock = arb_series([begin, arb(1)], prec=length)
                rates = map(_as_series, self.field(clock, series))
                series = [value + rate.integral() for value, rate in zip(start, rates, strict=True)]
        return [
            arb_poly([value.mid() for value in terms_of(one, self.order + 1)]) for one in series
        ]


def _as_series(value: Any) -> arb_series:
    if isinstance(value, arb_series):
        return value
    return arb_series([arb(value)])


def _logarithm(value: arb) -> float:
    """log of a positive ball that may be far below the smallest double."""
    return float(value.mid().log())
