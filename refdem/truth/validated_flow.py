"""A Truth by validated integration: quantities of the state as balls, S(t) from the variational
equation.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from copy import copy
from fractions import Fraction
from functools import partial
from itertools import count
from math import ceil, log2
from typing import Any, Self

import numpy as np
from flint import arb, arb_mat, ctx

from refdem.truth.balls import SPARE, UndecidedError, arb_of, ball_of, largest, precision
from refdem.truth.closed_form import Size, per_precision
from refdem.truth.forecast import Course, follow
from refdem.truth.growth import Growth, Norm, Stretch, smooth
from refdem.truth.smooth_flow import SmoothFlow
from refdem.truth.traced_field import Field, Program, traced
from refdem.truth.validated_ivp.integration import Integration, Piece

Quantities = Callable[[Sequence[Any]], Mapping[str, Any]]
"""Quantities by name of a state, by the operations of a field; the names of `state` among them."""
LOSS = 24
"""Bits that a quiet motion may lose; one that loses more is integrated anew with as many more."""
MOST_BITS = 4096
"""Where a motion ends as `precision`: twice as many bits take about ten times the work."""
GAIN = Fraction(1, 16)
"""Part by which the end of a motion must move if bits are doubled: a motion that loses bits by and
by comes twice as far.
"""


class ValidatedFlow(SmoothFlow):
    """The solution of y' = field(y), y(0) = start, for t >= 0; units do not matter, for norms are
    weighted (enclosure.py).

    `start` has, for each coordinate, an exact number, or a function that gives its ball at the
    current precision (the cosine of a parameter). `moved` has the coordinates of the start that S
    displaces and `state`, one for each, the quantities in whose scales they are displaced. Bits are
    those that the digits ask for, and more until every radius is met; pieces are kept for each
    number.
    """

    method = (
        "validated integration: Taylor series on proved complex discs, Cauchy remainder, Lohner"
        " frame (refdem/truth/validated_ivp)"
    )
    witness = "none"

    def __init__(
        self,
        field: Field,
        start: Sequence[Fraction | Callable[[], arb]],
        quantities: Quantities,
        scale: Mapping[str, Size],
        *,
        state: Sequence[str],
        moved: Sequence[int],
        digits: int = 40,
    ) -> None:
        super().__init__(scale, digits=digits)
        self.field, self.begin, self.quantities = field, list(start), quantities
        self.state, self.moved = tuple(state), tuple(moved)
        self.names: list[str] = []
        self.ends: dict[int, Fraction] = {}
        outputs, slopes = traced(self.listed, len(self.begin))
        self.values, self.slopes = (
            Program(outputs),
            Program([entry for row in slopes for entry in row]),
        )

    def listed(self, y: Sequence[Any]) -> list[Any]:
        """The quantities of a state one after another, as `names` lists them."""
        found = self.quantities(y)
        self.names = list(found)
        return list(found.values())

    def bits(self) -> int:
        """What `at` begins with: bits for the digits, or what they have needed so far."""
        return int(self.kept.get(("bits", self.digits), self.first_bits()))

    def first_bits(self) -> int:
        """Bits for the digits, and LOSS more."""
        asked = ceil(1 / self.target()).bit_length() + LOSS
        return asked + -asked % 32

    def most_bits(self) -> int:
        return max(MOST_BITS, 2 * self.bits())

    def infinite_within(self, y: Sequence[arb]) -> arb | None:
        """A time [s] within which every motion from these balls of the state is proved to be
        infinite; None where that is not proved.
        """
        return None

    def integration(self) -> Integration:
        """The solution at the current precision."""
        if ("integration", ctx.prec) not in self.kept:
            self.kept["integration", ctx.prec] = Integration(self.field, self.first, ctx.prec)
        found: Integration = self.kept["integration", ctx.prec]
        return found

    def first(self) -> list[arb]:
        """The start at the current precision."""
        return [value() if callable(value) else arb_of(value) for value in self.begin]

    def evaluate(self, t: arb) -> dict[str, arb]:
        self.kept["bits", self.digits] = ctx.prec
        try:
            return self.named(self.integration().at(t))
        except UndecidedError as error:
            if error.time is None:
                raise
            raise self.ended(t, error) from None

    def named(self, y: Sequence[arb]) -> dict[str, arb]:
        """The quantities of a state, by name."""
        return dict(zip(self.names, self.values.run(y), strict=True))

    def ended(self, t: arb, error: UndecidedError) -> UndecidedError:
        """The same end with the last certified state, and whether it is proved to be one of the
        motion, or more bits may move it.

        It is `singular` where the motion from that state is proved to be infinite before t. Where
        bits were doubled and the end hardly moved, more are not tried; what stops the proof there
        is then not known.
        """
        flow = self.integration()
        y = flow.reached()
        end = arb_of(flow.end)
        balls = {name: ball_of(value) for name, value in self.named(y).items()}
        within = self.infinite_within(y)
        if within is not None and end + within < t:
            told = (
                f"the motion is infinite before t = {float((end + within).upper()):.17g} s; it is"
                f" enclosed up to {float(end):.17g} s"
            )
            return UndecidedError(told, code="singular", final=True, time=error.time, balls=balls)
        self.ends[flow.bits] = flow.end
        earlier = [other for bits, other in self.ends.items() if 2 * bits <= flow.bits]
        stays = bool(earlier) and flow.end <= max(earlier) * (1 + GAIN)
        return UndecidedError(
            str(error), code=error.code, final=error.final or stays, time=error.time, balls=balls
        )

    def displaced(self, axis: int, amount: Fraction) -> Self:
        """The motion whose start has the coordinate `moved[axis]` larger by exactly `amount`: a
        witness of S, which needs none.
        """
        other = copy(self)
        other.kept, other.ends, other.begin = {}, {}, list(self.begin)
        before = self.begin[self.moved[axis]]
        other.begin[self.moved[axis]] = (
            (lambda: before() + arb_of(amount)) if callable(before) else before + amount
        )
        return other

    def jacobian(self, t: Fraction) -> arb_mat:
        """d quantity_i(t)/scale_i over d start_j/scale_j, with `state` as the first rows, from the
        variational equation.
        """
        flow = self.integration().jacobian(arb_of(t)).table()
        return self.scaled_slopes(arb_of(t)) * arb_mat(
            [[row[j] * size for j, size in self.sizes()] for row in flow]
        )

    def scaled_slopes(self, t: arb) -> arb_mat:
        """d quantity_i(t)/scale_i over d y_j(t), with `state` as the first rows."""
        return self.scaled_slopes_at(self.integration().at(t))

    def scaled_slopes_at(self, y: Sequence[arb]) -> arb_mat:
        """Scaled derivatives of the quantities at a given state y."""
        slopes = self.slopes.run(y)
        rows = dict(
            zip(
                self.names, np.array(slopes, dtype=object).reshape(len(self.names), -1), strict=True
            )
        )
        order = [*self.state, *(name for name in self.names if name not in self.state)]
        return arb_mat(
            [[entry / arb_of(self.scale[name]) for entry in rows[name]] for name in order]
        )

    @per_precision
    def growth(self) -> Growth:
        """Piece by piece, by the variational equation."""
        return Growth(
            self.stretches(self.integration()), Norm([1] * len(self.moved)), self.readings
        )

    def growth_bits(self) -> Sequence[int]:
        """The precisions of the first integration, whose pieces are there already."""
        first = self.first_bits()
        return [first << n for n in range(4)]

    def stretches(self, flow: Integration) -> Iterator[Stretch]:
        """The pieces of an integration, made as they are asked for."""
        for number in count():
            while number >= len(flow.pieces):
                flow.advance()
            piece = flow.pieces[number]
            moved = partial(self.moved_by, flow, piece)
            yield smooth(arb_of(piece.begin), arb_of(piece.length), moved, joins=True)

    def moved_by(self, flow: Integration, piece: Piece, since: arb) -> arb_mat:
        """The derivative of the state since the begin of a piece, both in scales: no error reaches
        what is not displaced.
        """
        table = flow.moved_by(piece, since).table()
        sizes = self.sizes()
        return arb_mat([[table[i][j] * own / size for j, own in sizes] for i, size in sizes])

    def sizes(self) -> list[tuple[int, arb]]:
        """The coordinates that are displaced, and their scales."""
        return [
            (j, arb_of(self.scale[name])) for name, j in zip(self.state, self.moved, strict=True)
        ]

    def readings(self, t: arb) -> arb_mat:
        """d quantity_i(t)/scale_i over d state_j(t)/scale_j."""
        return self.readings_at(self.integration().at(t))

    def readings_at(self, y: Sequence[arb]) -> arb_mat:
        """Scaled readings of the quantities at a given state y."""
        sizes = self.sizes()
        return arb_mat(
            [[row[j] * size for j, size in sizes] for row in self.scaled_slopes_at(y).table()]
        )

    def forecast(self, t: Fraction, digits: int) -> float:
        """CPU seconds that `at(t)` to so many digits is about to cost; what is followed for it is
        kept.
        """
        asked = self.refined(digits)
        course = Course(asked.bits())
        work = asked.foreseen(t, course)
        return course.seconds_for(work)

    def foreseen(self, t: Fraction, course: Course) -> float:
        """The pieces that are left until the radius at t is what is asked for, in pieces of the
        course's precision.
        """
        # log2 of a number that may be below all doubles.
        target = log2(self.target().numerator) - log2(self.target().denominator)
        time = float(t)

        def next_bits(bits: int, lacking: float | None) -> int | None:
            if lacking is None:
                more = bits
            else:
                more = max(bits // 4, ceil(lacking) + SPARE)
            if bits < self.most_bits():
                return bits + more
            return None

        with precision(course.bits):
            flow = self.integration()

            def step() -> bool:
                try:
                    flow.advance()
                except UndecidedError:
                    return False
                return True

            def state() -> tuple[Fraction, int, arb]:
                return flow.end, len(flow.pieces), largest(flow.spread.radii())

            follow(course, state, step, t, lambda: course.work_to(time, target, next_bits))
        return course.work_to(time, target, next_bits)
