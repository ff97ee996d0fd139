"""From parameters to Arb balls and back to exact core balls, at a working precision that is raised until it suffices."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from fractions import Fraction

from flint import arb, ctx, fmpq

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


def arb_of(value: Fraction | int) -> arb:
    """A ball that contains the exact rational."""
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


def nearest_integer(value: arb) -> int:
    """The whole number nearest to the midpoint of a ball; exact, so that it can be taken out of a period."""
    return round(_exact(value.mid()))


class UndecidedError(ValueError):
    """Balls at this precision cannot tell which branch of a formula holds."""


def refined(evaluate: Callable[[], dict[str, arb]], target: Fraction, bits: int = 256, most: int = 16384) -> dict[str, Ball] | None:
    """Evaluates at rising precision until every radius is at most `target`; the last result if `most` bits do not do it.

    None if at `most` bits the formula is still undecided or not finite.
    """
    while True:
        with precision(bits):
            try:
                balls: dict[str, Ball] | None = {name: ball_of(value) for name, value in evaluate().items()}
            except ValueError:
                balls = None
        if balls is not None and all(ball.radius <= target for ball in balls.values()):
            return balls
        if bits >= most:
            return balls
        bits *= 2
