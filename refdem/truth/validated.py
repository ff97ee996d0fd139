"""Proven solutions of y' = f(y): Taylor pieces with the Lagrange remainder over an a-priori enclosure, and their first zeros.

A box B with y0 + [0, h] f(B) inside B holds the solution on [0, h] (Picard). With c_n(Y) the Taylor coefficients that the recurrences
of the field give for the box Y, y(t) lies in sum_{n<=N} c_n(y0) t^n + c_{N+1}(B) t^{N+1} for 0 <= t <= h (Moore, Methods and
Applications of Interval Analysis, 1979, chapter 8). Balls are carried from piece to piece as they are, without a device against
wrapping: for motions of a few time constants, at hundreds of bits.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from flint import arb, arb_poly, arb_series, ctx

from refdem.errors import NotCertifiedError
from refdem.truth.balls import arb_of

Field = Callable[[Sequence[Any]], list[Any]]
"""f(y) by + - * / alone, for y of arb or of arb_series."""
HALVINGS = 30
"""Of a step whose enclosure fails, and of an interval on which a sign is not seen: 1e-9 of it."""
PIECES = 2000


def taylor(field: Field, start: Sequence[arb], order: int) -> list[arb_poly]:
    """Taylor polynomials of degree `order` of the solutions from (every point of the box) `start`.

    One order is gained by each turn of y <- start + integral of f(y).
    """
    before = ctx.cap
    try:
        ctx.cap = 1
        series = [arb_series([value], prec=1) for value in start]
        for length in range(2, order + 2):
            ctx.cap = length
            series = [value + rate.integral() for value, rate in zip(start, field(series), strict=True)]
    finally:
        ctx.cap = before
    return [arb_poly(one.coeffs()) for one in series]


def enclosure(field: Field, start: Sequence[arb], step: arb) -> list[arb] | None:
    """A box that holds the solution from `start` on [0, step]; None if none is found."""
    whole = arb(step / 2, step / 2)
    box = list(start)
    for _ in range(20):
        image = [value + whole * rate for value, rate in zip(start, field(box), strict=True)]
        if not all(side.is_finite() for side in image):
            return None
        if all(side.contains(new) for side, new in zip(box, image, strict=True)):
            return image
        box = [side + (side - side.mid()) / 8 + arb(0, 1) * arb(2) ** -ctx.prec for side in image]
    return None


@dataclass(frozen=True)
class Piece:
    """The solution on [begin, begin + length] as polynomials of the time since `begin`; both times are exact."""

    begin: arb
    length: arb
    polynomials: list[arb_poly]

    def at(self, since: arb) -> list[arb]:
        """The state at a time (or over an interval of times) since its begin."""
        return [polynomial(since) for polynomial in self.polynomials]


class Flow:
    """The solution from `start`, piece by piece as far as it is asked for, at the precision at which it was made."""

    def __init__(self, field: Field, start: Sequence[arb], step: Fraction, order: int) -> None:
        self.field, self.start, self.step, self.order = field, list(start), step, order
        self.pieces: list[Piece] = []

    def piece(self, index: int) -> Piece:
        """One piece; raises NotCertifiedError where no enclosure is found."""
        while len(self.pieces) <= index:
            self.pieces.append(self._next())
        return self.pieces[index]

    def _next(self) -> Piece:
        last = self.pieces[-1] if self.pieces else None
        begin = last.begin + last.length if last else arb(0)
        start = last.at(last.length) if last else self.start
        for halving in range(HALVINGS):
            step = arb_of(self.step / 2**halving)
            box = enclosure(self.field, start, step)
            if box is not None and len(self.pieces) < PIECES:
                thin = taylor(self.field, start, self.order)
                fat = taylor(self.field, box, self.order + 1)
                remainders = (_with_remainder(*pair, self.order + 1) for pair in zip(thin, fat, strict=True))
                return Piece(begin, step, list(remainders))
        raise NotCertifiedError(f"the motion is enclosed up to {float(begin):.17g} s of the contact and no further")


def _with_remainder(thin: arb_poly, fat: arb_poly, degree: int) -> arb_poly:
    coefficients = thin.coeffs() + [arb(0)] * (degree - thin.length())
    return arb_poly([*coefficients, fat[degree]])


def is_positive(value: Callable[[arb], arb], low: arb, high: arb, halvings: int = HALVINGS) -> bool:
    """True if `value`, which encloses a function over any interval, is proved > 0 on all of [low, high]."""
    if value(low.union(high)) > 0:
        return True
    if halvings == 0 or not (value(low) > 0 and value(high) > 0):
        return False
    middle = ((low + high) / 2).mid()
    return is_positive(value, low, middle, halvings - 1) and is_positive(value, middle, high, halvings - 1)


def first_zero(function: arb_poly, low: arb, high: arb) -> arb | None:
    """The first zero in (low, high] of a function that is > 0 just after `low`; None if it has none.

    Where the function rises, or is proved positive, there is none; where it falls the signs at the ends decide.
    NotCertifiedError where neither is proved within HALVINGS: more digits would seldom help.
    """
    slope = function.derivative()
    waiting = [(low, high, HALVINGS)]
    while waiting:
        a, b, halvings = waiting.pop()
        interval = a.union(b)
        if function(interval) > 0 or slope(interval) > 0:
            continue
        if slope(interval) < 0 and (function(b) > 0 or function(b) < 0):
            if function(b) > 0:
                continue
            return _only_zero(function, slope, interval)
        if halvings == 0:
            raise NotCertifiedError("a first zero of the motion is too shallow, or too near the end of a step, to be proved")
        middle = ((a + b) / 2).mid()
        waiting += [(middle, b, halvings - 1), (a, middle, halvings - 1)]
    return None


def _only_zero(function: arb_poly, slope: arb_poly, interval: arb) -> arb:
    """The zero in an interval on which the slope has one sign: interval Newton until it shrinks no more."""
    while True:
        middle = interval.mid()
        closer = (middle - function(middle) / slope(interval)).intersection(interval)
        if not closer.rad() < interval.rad() / 2:
            return closer
        interval = closer
