"""From parameters to Arb balls and back to exact core balls, at a working precision that is raised until it suffices."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from fractions import Fraction

from flint import acb, arb, ctx, fmpq

from refdem.core.truth import Ball


@contextmanager
def precision(bits: int) -> Iterator[None]:
    """Arb's working precision, restored afterwards."""
    before = ctx.prec
    ctx.prec = bits
    try:
        yield
    finally:
        ctx.prec = before


def arb_of(value: Fraction | int | arb) -> arb:
    """A ball that contains the exact rational; a ball is one already."""
    if isinstance(value, arb):
        return value
    value = Fraction(value)
    return arb(fmpq(value.numerator, value.denominator))


def ball_of(value: arb) -> Ball:
    """The same ball with exact rational midpoint and radius; ValueError if it is not finite."""
    if not value.is_finite():
        raise ValueError(f"{value} is not finite")
    return Ball(_exact(value.mid()), _exact(value.rad()))


def _exact(value: arb) -> Fraction:
    mantissa, exponent = value.man_exp()
    return Fraction(int(mantissa)) * Fraction(2) ** int(exponent)


def outward(value: arb | acb) -> arb:
    """An exact number that |value| does not exceed; nan if it is not finite."""
    return value.abs_upper()


def largest(values: Sequence[arb | acb]) -> arb:
    """An exact upper bound of all absolute values (0 if there are none); nan if one is not finite."""
    found = arb(0)
    for bound in map(outward, values):
        if not bound.is_finite():
            return arb("nan")
        if bound > found:
            found = bound
    return found


def nearest_integer(value: arb) -> int:
    """The whole number nearest to the midpoint of a ball; exact, so that it can be taken out of a period."""
    return round(_exact(value.mid()))


class UndecidedError(ValueError):
    """Balls at this precision cannot tell which branch of a formula holds."""


SPARE = 32
"""Bits more than a radius is too large by: what it loses grows a little with the precision's own roundings."""


def refined(evaluate: Callable[[], dict[str, arb]], target: Fraction, bits: int = 256, most: int = 16384) -> dict[str, Ball] | None:
    """Evaluates at rising precision until every radius is at most `target`; the last result if `most` bits do not do it.

    Bits rise by what the largest radius lacks, and twofold where the formula is undecided or not finite; None if it is so to the end.
    """
    while True:
        with precision(bits):
            try:
                balls: dict[str, Ball] | None = {name: ball_of(value) for name, value in evaluate().items()}
            except ValueError:
                balls = None
        worst = None if balls is None else max((ball.radius for ball in balls.values()), default=Fraction(0))
        if bits >= most or (worst is not None and worst <= target):
            return balls
        bits = min(most, 2 * bits if worst is None else bits + max(bits // 4, (worst / target).__ceil__().bit_length() + SPARE))
