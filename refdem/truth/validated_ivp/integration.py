"""The solution of y' = f(y) piece by piece, at one precision, as far as it is asked for; pieces are kept.

Theorem (step): the solution at the begin of a piece lies in c + {A r} (moved.py), inside a box whose disc is proved (enclosure.py). With
the Taylor coefficients c_n of the exact centre c, for 0 <= s <= h every solution from the set lies within
remainder(s) + exp(L s) max |A r| of sum c_n s^n (Cauchy, Gronwall); at the end of the piece the set is moved by the flow Jacobian.
"""

from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import ceil, log2

from flint import acb, arb, arb_mat, arb_poly, ctx

from refdem.errors import NotCertifiedError
from refdem.truth.balls import UndecidedError, arb_of, ball_of, precision
from refdem.truth.validated_ivp.enclosure import Disc, disc, gronwall, norm, remainder, width_of
from refdem.truth.validated_ivp.field import Field, Program, largest, traced
from refdem.truth.validated_ivp.moved import Spread, at_start, flow_jacobian, hull, moved, outward
from refdem.truth.validated_ivp.recurrences import taylor

GUARD = 24
"""Bits by which coefficients are sharper than the bits asked for, for the rounding of their sums."""
HALVINGS = 24
"""A disc 2^-24 as wide as the widest so far means that the motion, or the set, has run into a singularity."""
JACOBIAN_BITS = 48
"""To which the flow Jacobian of a step is known: far below its own share in the error."""


@dataclass(frozen=True)
class Steps:
    """How steps are made: h/R, and the orders of solution and Jacobian (None: those that the bits ask for)."""

    ratio: Fraction = Fraction(1, 6)
    order: int | None = None
    jacobian_order: int | None = None

    def orders(self, bits: int) -> tuple[int, int]:
        """Orders of the solution and of its Jacobian."""
        gained = -log2(self.ratio)
        return self.order or ceil(bits / gained), self.jacobian_order or ceil(JACOBIAN_BITS / gained)


@dataclass(frozen=True)
class Piece:
    """The solution on [begin, begin + length]: polynomials from the exact centre, and the set about it."""

    begin: Fraction
    length: Fraction
    polynomials: list[arb_poly]
    box: list[arb]
    disc: Disc
    spread: Spread
    widest: arb
    order: int

    @property
    def end(self) -> Fraction:
        return self.begin + self.length

    def centre(self, since: arb) -> list[arb]:
        """The solution from the exact centre, at (every point of the ball of) a time since the begin."""
        rest = remainder(self.disc, outward(since), self.order)
        return [one(since) + arb(0, radius) for one, radius in zip(self.polynomials, rest, strict=True)]

    def at(self, since: arb) -> list[arb]:
        """The solutions from the whole set."""
        apart = arb(0, outward(gronwall(self.disc, outward(since)) * self.widest))
        return [value + apart for value in self.centre(since)]


class Integration:
    """The solution from `start` (called at the working precision) to about `bits` bits, before errors grow."""

    def __init__(self, field: Field, start: Callable[[], Sequence[arb]], bits: int, steps: Steps | None = None) -> None:
        self.bits, self.steps = bits, steps or Steps()
        with precision(bits + GUARD):
            whole = list(start())
        outputs, slopes = traced(field, len(whole))
        self.field, self.slopes = Program(outputs), Program([entry for row in slopes for entry in row])
        self.order, self.jacobian_order = self.steps.orders(bits)
        self.centre = [value.mid() for value in whole]
        self.spread = at_start([value.rad() for value in whole])
        self.pieces: list[Piece] = []
        self.begins: list[Fraction] = []
        self.first, self.widest = arb(1), arb(0)

    def at(self, t: arb) -> list[arb]:
        """The state at the time t >= 0 [s] (every point of the ball); NotCertifiedError or UndecidedError where it is not proved."""
        piece = self.piece(t)
        with precision(self.bits + GUARD):
            return piece.at(t - arb_of(piece.begin))

    def jacobian(self, t: arb) -> arb_mat:
        """Enclosure of the derivative of the state at t by that at 0."""
        piece = self.piece(t)
        with precision(self.bits + GUARD):
            return self.moved_by(piece, t - arb_of(piece.begin)) * piece.spread.jacobian()

    def piece(self, t: arb) -> Piece:
        """The piece that holds the midpoint of the time; pieces up to it are made. A ball must lie in the disc of its piece."""
        middle = ball_of(t).mid
        if middle < 0:
            raise ValueError(f"t = {t}; an integration runs forward from 0")
        while not self.pieces or self.pieces[-1].end < middle:
            self.advance()
        found = self.pieces[bisect_right(self.begins, middle) - 1]
        if not abs(t - arb_of(found.begin)) < found.disc.radius:
            raise UndecidedError(f"t = {t} is not in one piece")
        return found

    def advance(self) -> None:
        """Makes the next piece and moves the set to its end."""
        begin = self.pieces[-1].end if self.pieces else Fraction(0)
        radii = self.spread.radii()
        box = hull(self.centre, radii)
        found = self.proved_disc(box, begin)
        with precision(self.bits + GUARD):
            length = dyadic(found.radius * arb_of(self.steps.ratio))
            polynomials = taylor(self.field, self.centre, self.order)
            piece = Piece(begin, length, polynomials, box, found, self.spread, largest(radii), self.order)
            end = piece.centre(arb_of(length))
        self.spread = moved(self.spread, self.moved_by(piece, arb_of(length)), [value.rad() for value in end])
        self.centre = [value.mid() for value in end]
        self.pieces.append(piece)
        self.begins.append(begin)

    def moved_by(self, piece: Piece, since: arb) -> arb_mat:
        """The flow Jacobian from the begin of a piece."""
        return flow_jacobian(self.field, self.slopes, piece.box, piece.disc, since, self.jacobian_order)

    def proved_disc(self, box: Sequence[arb], begin: Fraction) -> Disc:
        """The largest disc that is found; its first ring is as wide as the stiffness there suggests, or narrower."""
        width = width_of(norm(self.slopes, [acb(value) for value in box]), self.first)
        for _ in range(HALVINGS):
            found = disc(self.field, self.slopes, box, width)
            if found is not None and found.radius > self.widest / 2**HALVINGS:
                self.first, self.widest = width * 2, max(self.widest, found.radius)
                return found
            width = width / 2
        if largest(self.spread.radii()) > arb(2) ** (-HALVINGS):
            raise UndecidedError(f"the set of solutions is too large to be enclosed after t = {float(begin):.17g} s")
        raise NotCertifiedError(f"the motion is enclosed up to t = {float(begin):.17g} s and no further: no disc is proved there")


def dyadic(value: arb) -> Fraction:
    """A number of eight bits that is at most the (positive) value and close to it."""
    with precision(ctx.prec):
        mantissa, exponent = value.abs_lower().man_exp()
    number = Fraction(int(mantissa)) * Fraction(2) ** int(exponent)
    unit = Fraction(2) ** (int(mantissa).bit_length() + int(exponent) - 8)
    return (number / unit).__floor__() * unit
