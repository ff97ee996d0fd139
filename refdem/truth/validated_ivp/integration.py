"""The solution of y' = f(y) piece by piece, at one precision, as far as requested; pieces are
kept.

Theorem (step): let the solution at the start of a piece lie in c + {A r} (moved.py), c being exact,
and let a disc be proved for that set (enclosure.py). With the Taylor polynomial T(s) = sum of c_n
s^n over n <= N of the solution from c, every solution y from the set obeys, for 0 <= s <= h,

    |y(s) - T(s)| <= exp(integral of L from 0 to s) (max |A r| + s M q^N/((1 - q)(N + 1))), q = s/S

(Cauchy, Gronwall; S, M, L are those of the disc). At the end of the piece the set is moved by the
flow Jacobian.
"""

from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import ceil, log2

from flint import arb, arb_mat, arb_poly

from refdem.truth.balls import Guarded, UndecidedError, arb_of, ball_of, largest, outward, precision
from refdem.truth.traced_field import Field, Program, traced
from refdem.truth.validated_ivp.enclosure import JACOBIAN_BITS, Disc, disc, norm
from refdem.truth.validated_ivp.moved import (
    BITS,
    Spread,
    at_start,
    flow_jacobian,
    flow_series,
    moved,
)
from refdem.truth.validated_ivp.recurrences import taylor

UNEQUAL = 80
"""The most bits that are added to those of the flow Jacobian for unequal weights: the remainder of
its entry (i, j) is proportional to w_i/w_j.
"""
GUARD = 24
"""Guard bits: coefficients are computed with so many bits more than requested, against the rounding
of their sums.
"""
HALVINGS = 24
"""A disc 2^-24 as wide as the widest so far is refused: the set, or the motion, is near a
singularity.
"""
SMALL = arb(2) ** -20
"""The least weight of a coordinate as a part of its size, and the largest radius of the set that is
sought as a part of a weight.
"""
MOST_PIECES = 2**17
"""Largest number of pieces of one integration. One that needs more ends with the code `time`; the
pieces so far are certified.
"""


@dataclass(frozen=True)
class Steps:
    """The choice of steps: `ratio` of step and outer radius, orders of the Taylor polynomial and of
    the flow Jacobian (None: those that the bits require), and the bits of the Jacobian.
    """

    ratio: Fraction = Fraction(1, 4)
    order: int | None = None
    jacobian_order: int | None = None
    jacobian_bits: int = JACOBIAN_BITS

    def orders(self, bits: int) -> tuple[int, int | None]:
        """The orders of the solution and of its Jacobian (None: as its remainder on each disc
        requires).

        ratio^order <= 2^-bits.
        """
        # ratio^order <= 2^-bits where order >= bits/log2(1/ratio).
        order = self.order or ceil(bits / -log2(self.ratio))
        return order, self.jacobian_order


@dataclass(frozen=True)
class Piece:
    """The solutions on [begin, begin + length] [s].

    `polynomials` are the Taylor polynomials T of the solution from the exact centre, `disc` the
    disc on which it is proved. `spread` is the set about the centre, `start` its norm. `flow` has
    the coefficients of the flow Jacobian V.
    """

    begin: Fraction
    length: Fraction
    polynomials: list[arb_poly]
    disc: Disc
    spread: Spread
    start: arb
    flow: list[arb_mat]

    @property
    def end(self) -> Fraction:
        """The time [s] at which the piece ends."""
        return self.begin + self.length

    def centre(self, since: arb) -> list[arb]:
        """Balls of the solution from the exact centre, at every time since the start in the ball
        `since` [s].
        """
        return self._from(since, arb(0))

    def at(self, since: arb) -> list[arb]:
        """Balls of the solutions from the whole set, at every time since the start in the ball
        `since` [s].
        """
        return self._from(since, self.start)

    def _from(self, since: arb, start: arb) -> list[arb]:
        """Balls of the solutions from all points within the norm `start` of the centre: T and the
        bound of their distance from it.
        """
        # T_i(s) +- w_i apart(s, start).
        radii = self.disc.sides(self.disc.apart(outward(since), start))
        return [
            one(since) + arb(0, radius) for one, radius in zip(self.polynomials, radii, strict=True)
        ]


class Chain(Guarded):
    """Pieces of a solution one after another, each made on demand.

    `field` and `slopes` are the programs of f and of its Jacobian; the set at the end of the last
    piece is `centre` + `spread`. The last `steady` coordinates change at a rate that is constant.
    """

    bits: int
    steps: Steps
    field: Program
    slopes: Program
    centre: list[arb]
    spread: Spread
    steady: int = 0

    def begin(self) -> None:
        """Sets all that belongs to the pieces, of which there are none yet; bits, steps, field,
        slopes, centre and spread must be set.
        """
        self.order, self.jacobian_order = self.steps.orders(self.bits)
        self.pieces: list[Piece] = []
        self.begins: list[Fraction] = []
        # The largest |y_i| so far, the outer radius to begin a search with, the widest disc so far.
        self.largest: list[arb] = []
        self.first = arb(1)
        self.widest = arb(0)

    def at(self, t: arb) -> list[arb]:
        """The state at the time t >= 0 [s] (every point of the ball).

        NotCertifiedError or UndecidedError where it is not proved.
        """
        piece = self.piece(t)
        with precision(self.bits + GUARD):
            return piece.at(t - arb_of(piece.begin))

    def jacobian(self, t: arb) -> arb_mat:
        """Enclosure of the derivative of the state at t by the state at 0."""
        piece = self.piece(t)
        # V(t) = V of the piece up to t, times V from 0 to its start.
        with precision(self.bits + GUARD):
            return self.moved_by(piece, t - arb_of(piece.begin)) * piece.spread.jacobian()

    @property
    def end(self) -> Fraction:
        """The time up to which pieces are made."""
        if self.pieces:
            return self.pieces[-1].end
        return Fraction(0)

    def reached(self) -> list[arb]:
        """Balls of the state at `end`."""
        with precision(self.bits + GUARD):
            return self.spread.around(self.centre)

    def piece(self, t: arb) -> Piece:
        """The piece that holds the midpoint of the time; pieces up to it are made.

        A ball must lie in the disc of its piece.
        """
        middle = ball_of(t).mid
        if middle < 0:
            raise ValueError(f"t = {t}; an integration runs forward from 0")
        while not self.pieces or self.end < middle:
            self.advance()
        piece = self.pieces[bisect_right(self.begins, middle) - 1]
        if not abs(t - arb_of(piece.begin)) < piece.disc.radius:
            raise UndecidedError(f"t = {t} is not in one piece", code="precision")
        return piece

    def advance(self) -> None:
        """Makes the next piece and moves the set to its end.

        UndecidedError where no piece is proved; its `time` is the end of the last one.
        """
        begin = self.end
        if len(self.pieces) >= MOST_PIECES:
            message = (
                f"{MOST_PIECES} pieces are used up at t = {float(begin):.17g} s; ask for an earlier"
                " time"
            )
            raise UndecidedError(message, code="time", final=True, time=float(begin))
        with precision(self.bits + GUARD):
            polynomials = taylor(self.field, self.centre, self.order)
        proved = self.proved_disc(polynomials, begin)
        start = norm(self.spread.radii(), proved.weights)
        with precision(self.steps.jacobian_bits + GUARD):
            jacobian_bits = self.steps.jacobian_bits + unequal(proved.weights)
            order = self.jacobian_order or proved.jacobian_order(jacobian_bits)
            flow = flow_series(self.slopes, polynomials, proved, start, order, self.steady)
        piece = Piece(begin, proved.step, polynomials, proved, self.spread, start, flow)
        # The centre at the end is a ball c' + u: its midpoint c' is the exact centre of the next
        # piece. The set {A r} becomes {V A r + u}, with the flow Jacobian V (moved.py).
        with precision(self.bits + GUARD):
            length = arb_of(piece.length)
            end = piece.centre(length)
        self.spread = moved(
            self.spread,
            self.moved_by(piece, length),
            [value.rad() for value in end],
            max(BITS, self.steps.jacobian_bits),
        )
        self.centre = [value.mid() for value in end]
        self.pieces.append(piece)
        self.begins.append(begin)

    def least_weights(self, radii: Sequence[arb]) -> list[arb]:
        """The least weight of each coordinate y_i, whose error is at most `radii[i]`.

        w_i = max(SMALL |y_i|, min(radii_i/SMALL, |y_i|), 4^-bits times the largest |y_i| so far).

        The second term keeps the set small in comparison with its weights, the third one serves a
        coordinate that passes zero.
        """
        sizes = [outward(value) for value in self.centre]
        largest_before = self.largest or sizes
        self.largest = [max(before, now) for before, now in zip(largest_before, sizes, strict=True)]
        negligible = arb(2) ** (-2 * self.bits)
        least = []
        for size, radius, largest_size in zip(sizes, radii, self.largest, strict=True):
            least.append(max(size * SMALL, min(radius / SMALL, size), largest_size * negligible))
        return least

    def moved_by(self, piece: Piece, since: arb) -> arb_mat:
        """The flow Jacobian V from the start of a piece to the time `since` [s] after that."""
        with precision(self.steps.jacobian_bits + GUARD):
            return flow_jacobian(piece.flow, piece.disc, since)

    def proved_disc(self, polynomials: Sequence[arb_poly], begin: Fraction) -> Disc:
        """The disc for the longest step that is found, or for a shorter one.

        UndecidedError where no disc is proved. The motion need not be singular there: the set may
        have become too large, and more bits make it smaller.
        """
        radii = self.spread.radii()
        least = self.least_weights(radii)
        ratio = float(self.steps.ratio)
        for halving in range(HALVINGS):
            proved = disc(
                self.field,
                self.slopes,
                polynomials,
                self.order,
                radii,
                least=least,
                ratio=ratio / 2**halving,
                first=float(self.first),
            )
            if proved is not None and proved.radius > self.widest / 2**HALVINGS:
                self.first = proved.outer
                self.widest = max(self.widest, proved.radius)
                return proved
        if largest(radii) > arb(2) ** (-HALVINGS):
            message = (
                f"the set of solutions is too large to be enclosed after t = {float(begin):.17g} s"
            )
        else:
            message = (
                f"the motion is enclosed up to t = {float(begin):.17g} s; at {self.bits} bits no"
                " disc beyond is proved"
            )
        raise UndecidedError(message, code="precision", time=float(begin))


class Integration(Chain):
    """The solution of y' = field(y), known to about `bits` bits before errors grow.

    `start()` gives balls of the state at time 0, at the working precision; its last `directions`
    coordinates stand for parameters (traced_field.py).
    """

    def __init__(
        self,
        field: Field,
        start: Callable[[], Sequence[arb]],
        bits: int,
        steps: Steps | None = None,
        *,
        directions: int = 0,
    ) -> None:
        self.bits = bits
        self.steps = steps or Steps()
        self.steady = directions
        with precision(bits + GUARD):
            balls = list(start())
        size = len(balls)
        outputs, slopes = traced(field, size, range(size - directions, size))
        self.field = Program(outputs)
        self.slopes = Program([entry for row in slopes for entry in row])
        self.centre = [value.mid() for value in balls]
        self.spread = at_start([value.rad() for value in balls])
        self.begin()


def unequal(weights: Sequence[arb]) -> int:
    """The number of bits, at most UNEQUAL, by which the largest weight is above the smallest."""
    sizes = [float(weight) for weight in weights]
    # Both numbers are kept within the range of doubles, which a weight may leave.
    ratio = max(sizes) / max(min(sizes), 1e-300)
    bits = int(log2(max(1.0, min(ratio, 1e300))))
    return min(UNEQUAL, bits)
