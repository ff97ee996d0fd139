"""A truth by validated integration.

Theorem: the quantities at t are those of the solution of y' = field(y), y(0) = start, which exists
and is enclosed at t by the last of a chain of pieces; S(t) is bounded by the products of enclosures
of the flow's derivative over these pieces (refdem/truth/growth.py).

Hypotheses, and where each is checked:

* the field is analytic on a complex disc of times about each piece, on which no solution from the
  set leaves a box about the Taylor polynomial: `grown` (validated_ivp/enclosure.py);
* the remainder of the Taylor polynomial is at most Cauchy's bound on that disc, and the set is
  moved by an enclosure of the derivative (validated_ivp/integration.py, moved.py);
* field and start are exact: constants of a traced field are rationals (traced_field.py), and each
  number of the start is one, or is made anew as a ball at every precision;
* a motion that is reported to become infinite is proved to do so, by `escape` (escape.py).
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from copy import copy
from dataclasses import replace
from fractions import Fraction
from functools import partial
from itertools import count
from math import ceil, log2
from typing import Any, Self

import numpy as np
from flint import arb, arb_mat, ctx

from refdem.core.truth import Ball, Truth
from refdem.truth.balls import SPARE, Guarded, UndecidedError, arb_of, ball_of, largest, precision
from refdem.truth.closed_form import per_precision
from refdem.truth.dual import (
    Derivatives,
    DualBall,
    ball,
    flattened,
    parameters,
    slopes_of,
    unflattened,
)
from refdem.truth.forecast import Course, follow
from refdem.truth.growth import Growth, Norm, Stretch, smooth
from refdem.truth.reals import Number
from refdem.truth.refiner import Refiner, Sensitivity, Size
from refdem.truth.scout import Scout
from refdem.truth.traced_field import Field, Program, traced
from refdem.truth.validated_ivp.integration import GUARD, Integration, Piece, Steps

Quantities = Callable[[Sequence[Any]], Mapping[str, Any]]
"""Quantities by name of a state, by the operations of a field; the names of `state` among them."""
Escape = Callable[[Sequence[arb]], arb | None]
"""From balls of a state: a time [s] within which every motion from there is proved to become
infinite; None where that is not proved.
"""
LOSS = 24
"""The bits that a motion may lose at the first precision; one that loses more is integrated again
with as many more bits.
"""
MOST_BITS = 4096
"""The most bits of an integration, after which a motion ends with the code `precision`: twice as
many bits take about ten times the work.
"""
GAIN = Fraction(1, 16)
"""The part by which the end of a motion must become later when bits are doubled, for more to be
tried: a motion that loses bits at a constant rate is enclosed for twice the time.
"""
AHEAD = 4
"""Steps of a scout for each piece of a forecast. A forecast makes an eighth of what is left, and a
step is as long as two or more pieces: so the scout is at the end before the forecast is.
"""


def balls_of(values: Sequence[Number | int | Callable[[], arb]]) -> list[arb]:
    """Balls, at the current precision, of exact numbers or of what functions give as balls."""
    balls = []
    for value in values:
        if callable(value):
            balls.append(value())
        else:
            balls.append(arb_of(value))
    return balls


def never(y: Sequence[arb]) -> None:
    """The escape of a motion that is not known to become infinite: always None."""


class Reading(ABC):
    """The quantities of a state, and their derivatives by it."""

    @abstractmethod
    def values(self, y: Sequence[arb]) -> dict[str, arb]:
        """The quantities of balls of a state, by name."""

    @abstractmethod
    def slopes(self, y: Sequence[arb]) -> Mapping[str, Sequence[arb]]:
        """d quantity/d y_j, by name."""


class TracedReading(Reading):
    """Quantities that are written in the operations of a field, and differentiated with it."""

    def __init__(self, quantities: Quantities, size: int) -> None:
        self.names: list[str] = []

        def values_in_order(y: Sequence[Any]) -> list[Any]:
            by_name = quantities(y)
            self.names = list(by_name)
            return list(by_name.values())

        outputs, rows = traced(values_in_order, size)
        self.outputs = Program(outputs)
        self.rows = Program([entry for row in rows for entry in row])

    def values(self, y: Sequence[arb]) -> dict[str, arb]:
        return dict(zip(self.names, self.outputs.run(y), strict=True))

    def slopes(self, y: Sequence[arb]) -> Mapping[str, Sequence[arb]]:
        rows = np.array(self.rows.run(y), dtype=object).reshape(len(self.names), -1)
        return dict(zip(self.names, rows, strict=True))


class DualReading(Reading):
    """Quantities that are written for balls, and differentiated by dual numbers."""

    def __init__(self, quantities: Callable[[Sequence[arb]], Mapping[str, arb]]) -> None:
        self.quantities = quantities

    def values(self, y: Sequence[arb]) -> dict[str, arb]:
        return dict(self.quantities(y))

    def slopes(self, y: Sequence[arb]) -> Mapping[str, Sequence[arb]]:
        nothing = [arb(0)] * len(y)
        found = self.quantities(parameters(y))
        return {name: slopes_of(value) or nothing for name, value in found.items()}


class ValidatedFlow(Guarded, Truth):
    """The solution of y' = field(y), y(0) = start, for t >= 0; units do not matter, for norms are
    weighted (enclosure.py).

    `start` has, for each coordinate, an exact number, or a function that gives its ball at the
    current precision (the cosine of a parameter). `quantities(y)` gives the quantities of a state
    by name, and `scale` the size of each, against which its error counts. `moved` has the numbers
    of the coordinates of the start that S displaces and `state`, one for each, the quantities in
    whose scales they are displaced. The working precision is that which the digits ask for, and is
    raised until every radius is met; the pieces of an integration are kept for each precision.

    A family hands in what it adds: `witness` says who checked; `escape` proves that a motion is
    infinite; `constants` gives the scalars; `reported` names the quantities that `at` returns (all
    by default); `door` raises NotCertifiedError where the quantities have no meaning; `remark` says
    of the last certified state what the motion comes to there, for the reader of a refusal.
    """

    method = (
        "validated integration: Taylor series on proved complex discs, Cauchy remainder, Lohner"
        " frame (refdem/truth/validated_ivp)"
    )

    def __init__(
        self,
        field: Field,
        start: Sequence[Fraction | Callable[[], arb]],
        quantities: Quantities | Reading,
        scale: Mapping[str, Size],
        *,
        state: Sequence[str],
        moved: Sequence[int],
        digits: int = 40,
        witness: str = "none",
        escape: Escape = never,
        constants: "Callable[[ValidatedFlow], dict[str, arb]]" = lambda flow: {},
        reported: Sequence[str] = (),
        door: "Callable[[ValidatedFlow], None]" = lambda flow: None,
        remark: Callable[[Sequence[arb], float], str] = lambda y, t: "",
    ) -> None:
        self.refiner = Refiner.of(scale, digits=digits)
        self.kept: dict[Any, Any] = {}
        self.field = field
        self.begin = list(start)
        self.state = tuple(state)
        self.moved = tuple(moved)
        self.ends: dict[int, Fraction] = {}
        if isinstance(quantities, Reading):
            self.reading = quantities
        else:
            self.reading = TracedReading(quantities, len(self.begin))
        self.witness = witness
        self.escape = escape
        self.constants = constants
        self.reported = tuple(reported)
        self.door = door
        self.remark = remark

    @property
    def scale(self) -> Mapping[str, Fraction]:
        """The size of each quantity, against which its error counts."""
        return self.refiner.scale

    def refined(self, digits: int) -> Self:
        """The same truth with radii of at most 10^-digits; what is integrated serves both."""
        other = copy(self)
        other.refiner = self.refiner.to(digits)
        return other

    def at(self, t: Fraction) -> dict[str, Ball]:
        """Every quantity at the exact time t [s]; raises NotCertifiedError where it cannot be
        proved.
        """
        self.door(self)
        balls = self.refiner_now().balls(
            lambda: self.evaluate(arb_of(t)), f"at t = {float(t):.17g} s", t, self.evaluated_at_0
        )
        return {name: balls[name] for name in self.reported or balls}

    def scalars(self) -> dict[str, Ball]:
        """Values that do not depend on time."""
        return self.refiner_now().balls(lambda: self.constants(self), "scalars")

    def sensitivity(self, t: Fraction) -> float:
        """S(t) from the variational equation, for errors of the coordinates `moved`."""
        self.door(self)
        if ("sensitivity", t) not in self.kept:
            # The precision of the first integration, whose pieces are there already, and its
            # doublings.
            first = self.first_bits()
            proof = Sensitivity([first << doubling for doubling in range(4)])
            self.kept["sensitivity", t] = proof.at(self.growth, t, lambda: self.at_start(t))
        bound: float = self.kept["sensitivity", t]
        return bound

    def at_start(self, t: Fraction) -> dict[str, Ball]:
        """The quantities at the start, as the last certified state before t."""
        return self.refiner_now().at_start(t, self.evaluated_at_0)

    def evaluated_at_0(self) -> dict[str, arb]:
        """Every quantity at the start, at the current precision."""
        return self.evaluate(arb(0))

    def refiner_now(self) -> Refiner:
        """The refiner that begins with the bits that have been needed so far."""
        return replace(self.refiner, first=self.bits(), most=self.most_bits())

    def bits(self) -> int:
        """The precision [bit] that `at` begins with: that for the digits, or what they have needed
        so far.
        """
        return int(self.kept.get(("bits", self.refiner.digits), self.first_bits()))

    def first_bits(self) -> int:
        """The bits of the target radius and LOSS more, rounded up to a multiple of 32."""
        asked = ceil(1 / self.refiner.target()).bit_length() + LOSS
        return asked + -asked % 32

    def most_bits(self) -> int:
        """The precision [bit] at which raising it ends."""
        return max(MOST_BITS, 2 * self.bits())

    def derivatives(self, t: Fraction, count: int) -> Derivatives:
        """The derivatives at t of every quantity by each of `count` parameters, by which the
        numbers of this truth carry their own derivatives (dual.py).

        The parameters are coordinates of the state whose rate is 0 (traced_field.py): the
        derivative of the flow by the start contains that by the parameters.
        """
        self.door(self)
        return unflattened(
            self.refiner_now().balls(
                lambda: flattened(self.evaluated_dual(arb_of(t), count), count),
                f"derivatives at t = {float(t):.17g} s",
                t,
            ),
            count,
        )

    def evaluated_dual(self, t: arb, count: int) -> dict[str, arb]:
        """Every quantity at t with its derivatives by `count` parameters.

            dy_i(t)/dp_k = dy_i(t)/dd_k + sum over j of dy_i(t)/dy_j(0) dy_j(0)/dp_k,

        where d_k = 1 is the coordinate of the state that stands for the parameter p_k.
        """
        flow = self.directed(count)
        state = flow.at(t)
        table = flow.jacobian(t).table()
        begin = self.first()
        size = len(begin)
        y = []
        for value, row in zip(state[:size], table, strict=False):
            # dy_i(t)/dd_k, to which each coordinate j of the start adds its product.
            slopes = list(row[size:])
            for by_start, start in zip(row, begin, strict=False):
                of_start = slopes_of(start) or (0,) * count
                slopes = [one + by_start * two for one, two in zip(slopes, of_start, strict=True)]
            y.append(DualBall(value, slopes))
        values = self.reading.values(y)
        return {name: values[name] for name in self.reported or values}

    def directed(self, count: int) -> Integration:
        """The solution with `count` parameters as further coordinates, at the current precision."""
        key = ("directed", count, ctx.prec)
        if key not in self.kept:
            size = len(self.begin)

            def field(y: Sequence[Any]) -> list[Any]:
                return [*self.field(y[:size]), *[0] * count]

            def first() -> list[arb]:
                return [*(ball(value) for value in self.first()), *[arb(1)] * count]

            steps = Steps(jacobian_bits=ctx.prec)
            self.kept[key] = Integration(field, first, ctx.prec, steps, directions=count)
        integration: Integration = self.kept[key]
        return integration

    def integration(self) -> Integration:
        """The solution at the current precision, kept with the pieces that it has made."""
        if ("integration", ctx.prec) not in self.kept:
            self.kept["integration", ctx.prec] = Integration(self.field, self.first, ctx.prec)
        integration: Integration = self.kept["integration", ctx.prec]
        return integration

    def first(self) -> list[arb]:
        """Balls of the start at the current precision."""
        return balls_of(self.begin)

    def evaluate(self, t: arb) -> dict[str, arb]:
        """Every quantity at t at the current precision; UndecidedError where the motion ends."""
        self.kept["bits", self.refiner.digits] = ctx.prec
        try:
            return self.reading.values(self.integration().at(t))
        except UndecidedError as error:
            if error.time is None:
                raise
            raise self.ended(t, error) from None

    def ended(self, t: arb, error: UndecidedError) -> UndecidedError:
        """The same error with the last certified state, and whether more bits may help.

        It is `singular`, and final, where the motion from that state is proved to become infinite
        before t. It is final too where bits were doubled and the end of the integration hardly
        changed: more bits are not tried, and the reason why the proof ends there is not known.
        """
        flow = self.integration()
        y = flow.reached()
        end = arb_of(flow.end)
        balls = {name: ball_of(value) for name, value in self.reading.values(y).items()}
        infinite_within = self.escape(y)
        if infinite_within is not None and end + infinite_within < t:
            latest = float((end + infinite_within).upper())
            message = (
                f"the motion is infinite before t = {latest:.17g} s; it is"
                f" enclosed up to {float(end):.17g} s"
            )
            return UndecidedError(
                message, code="singular", final=True, time=error.time, balls=balls
            )
        self.ends[flow.bits] = flow.end
        ends_at_fewer_bits = [end for bits, end in self.ends.items() if 2 * bits <= flow.bits]
        is_stuck = bool(ends_at_fewer_bits) and flow.end <= max(ends_at_fewer_bits) * (1 + GAIN)
        return UndecidedError(
            f"{error}{self.remark(y, float(flow.end))}",
            code=error.code,
            final=error.final or is_stuck,
            time=error.time,
            balls=balls,
        )

    def displaced(self, axis: int, amount: Fraction) -> Self:
        """The motion whose start has the coordinate `moved[axis]` larger by exactly `amount`.

        Differences of such motions confirm S; S itself is computed by the variational equation.
        """
        coordinate = self.moved[axis]
        before = self.begin[coordinate]
        other = copy(self)
        other.kept = {}
        other.ends = {}
        other.begin = list(self.begin)
        if callable(before):
            other.begin[coordinate] = lambda: before() + arb_of(amount)
        else:
            other.begin[coordinate] = before + amount
        return other

    def jacobian(self, t: Fraction) -> arb_mat:
        """d quantity_i(t)/scale_i over d start_j/scale_j, with `state` as the first rows, from the
        variational equation.
        """
        flow = self.integration().jacobian(arb_of(t)).table()
        # d y(t)/d start_j, times the scale of start_j.
        by_scaled_start = arb_mat([[row[j] * scale for j, scale in self.sizes()] for row in flow])
        return self.scaled_slopes(arb_of(t)) * by_scaled_start

    def scaled_slopes(self, t: arb) -> arb_mat:
        """d quantity_i(t)/scale_i over d y_j(t), with `state` as the first rows."""
        return self.scaled_slopes_at(self.integration().at(t))

    def scaled_slopes_at(self, y: Sequence[arb]) -> arb_mat:
        """d quantity_i/scale_i over d y_j at a state y, with `state` as the first rows."""
        slopes = self.reading.slopes(y)
        names = [*self.state, *(name for name in slopes if name not in self.state)]
        rows = []
        for name in names:
            scale = arb_of(self.scale[name])
            rows.append([entry / scale for entry in slopes[name]])
        return arb_mat(rows)

    @per_precision
    def growth(self) -> Growth:
        """The growth S, piece by piece, by the variational equation."""
        norm = Norm([1] * len(self.moved))
        return Growth(self.stretches(self.integration()), norm, self.readings)

    def stretches(self, flow: Integration) -> Iterator[Stretch]:
        """The pieces of an integration as stretches, made on demand."""
        for number in count():
            while number >= len(flow.pieces):
                flow.advance()
            piece = flow.pieces[number]
            moved = partial(self.moved_by, flow, piece)
            yield smooth(arb_of(piece.begin), arb_of(piece.length), moved, joins=True)

    def moved_by(self, flow: Integration, piece: Piece, since: arb) -> arb_mat:
        """The derivative of the displaced coordinates, `since` [s] after the start of a piece, by
        those at its start, both in scales: no error reaches the other coordinates.
        """
        table = flow.moved_by(piece, since).table()
        scales = self.sizes()
        return arb_mat(
            [
                [table[i][j] * scale_of_start / scale for j, scale_of_start in scales]
                for i, scale in scales
            ]
        )

    def sizes(self) -> list[tuple[int, arb]]:
        """The numbers of the coordinates that are displaced, each with its scale."""
        return [
            (j, arb_of(self.scale[name])) for name, j in zip(self.state, self.moved, strict=True)
        ]

    def readings(self, t: arb) -> arb_mat:
        """d quantity_i(t)/scale_i over d state_j(t)/scale_j."""
        return self.readings_at(self.integration().at(t))

    def readings_at(self, y: Sequence[arb]) -> arb_mat:
        """d quantity_i/scale_i over d state_j/scale_j at a state y."""
        scales = self.sizes()
        slopes = self.scaled_slopes_at(y).table()
        return arb_mat([[row[j] * scale for j, scale in scales] for row in slopes])

    def forecast(self, t: Fraction, digits: int) -> float:
        """CPU seconds that `at(t)` to so many digits is expected to cost; the pieces that are made
        for the forecast are kept.
        """
        asked = self.refined(digits)
        course = Course(asked.bits())
        work = asked.foreseen(t, course)
        return course.seconds_for(work)

    def foreseen(self, t: Fraction, course: Course) -> float:
        """The number of pieces that are still to be made until the radius at t meets the target,
        counted in pieces of the course's precision.
        """
        # log2 of a number that may be below all doubles.
        target = log2(self.refiner.target().numerator) - log2(self.refiner.target().denominator)
        time = float(t)

        def next_bits(bits: int, lacking: float | None) -> int | None:
            """The next precision, raised as by `climbed`: twofold, or by the missing bits."""
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
                """Makes one more piece; False where that is not proved."""
                try:
                    flow.advance()
                except UndecidedError:
                    return False
                return True

            def state() -> tuple[Fraction, int, arb]:
                return flow.end, len(flow.pieces), self.radius_of(flow)

            # The clock of the forecast counts the scout's steps, not seconds. It therefore accounts
            # for fast parts of the motion before the proof reaches them.
            scout = Scout(flow.field, flow.slopes, flow.centre, float(flow.end), self.moved)
            course.clock = scout.clock

            def work() -> float:
                """The work that is left, by a scout that makes AHEAD steps for each piece."""
                scout.go_on(AHEAD, time)
                if len(scout.times) > 1:
                    course.swelling = scout.swelling
                return course.work_to(time, target, next_bits)

            follow(course, state, step, t, work)
        return course.work_to(time, target, next_bits)

    def radius_of(self, flow: Integration) -> arb:
        """The largest radius of a quantity at the end of what is integrated, as `at` reads it from
        the last piece; that of the set where a quantity is not finite there.

        Within a piece the set is bounded by Gronwall's inequality, so that a value there has a
        larger radius than the set at the end of the piece.
        """
        with precision(flow.bits + GUARD):
            if flow.pieces:
                piece = flow.pieces[-1]
                state = piece.at(arb_of(piece.length))
            else:
                state = flow.reached()
            values = self.reading.values(state)
        radius = largest([value.rad() for value in values.values()])
        if radius.is_finite():
            return radius
        return largest(flow.spread.radii())
