"""S(t): how much an error that is made at any time s <= t may have grown by t, as a proven upper
bound.

An error e made at s has become D(t) D(s)^-1 e at t, to first order, D(t) being the derivative of
the state at t by the start. A regular matrix M of any solutions of the variational equation has
M(t) M(s)^-1 = D(t) D(s)^-1, and

    S(t) = max over 0 <= s <= t of |M(t) M(s)^-1|.

Theorem (cell): let M(s) X = 1 + Delta(s) with |Delta(s)| <= delta < 1 for all s of a cell, X one
fixed matrix. Then M(s) is regular, M(t) M(s)^-1 = M(t) X (1 + Delta(s))^-1, and the growth of every
error made in the cell is at most |M(t) X| / (1 - delta). So times of errors are covered by cells,
not sampled: M is evaluated on balls of times, and cells are halved until delta is small.

Theorem (products): let P_m be the true derivative over stretch m and Q_m the doubles that stand for
it, |P_m - Q_m| <= eps_m. From a cell c to t the product of the P differs from that of the Q by the
sum over m of Q_(m+1..t) (P_m - Q_m) P_(c..m), whose last factor is at most S at the start of
stretch m, which is known. So S is at most the largest norm of the products of the Q, in doubles,
plus a proven bound of that sum.

Hypotheses, and where each is checked:

* M solves the variational equation on the stretch: the families' own proof; enclosures of it are
  evaluated on balls that hold all times of a cell (`Element.cell`);
* delta <= WIDEST < 1 on every cell: `Element.cell`, which raises UnsharpError otherwise, on which
  `Element.next_cell` halves the cell; where `quickness` bounds the field's Jacobian instead, delta
  follows from Gronwall's inequality;
* the cells cover all times up to t: `Element.cover` and `Element.until` begin each where the last
  one ended;
* t lies in one stretch: `Stretch.is_over_at` raises UnsharpError within the uncertainty of an end;
* |P_m - Q_m| <= eps_m: `doubles` gives the radii of what is rounded, and ROUNDING is a bound of
  products in binary64 (`Growth.passed`, `Growth.effect_at`);
* the bound of rounding errors is a small part of S: `Growth.read` compares it with
  MAX_ROUNDING_PART; where it is larger, products are computed in balls (`read_in_balls`), or more
  bits are requested.
"""

from bisect import bisect_right
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from math import expm1, frexp, inf, isfinite
from typing import Protocol

import numpy as np
from flint import arb, arb_mat
from numpy.typing import NDArray

from refdem.truth.balls import UndecidedError, arb_of, ball_of, unit_matrix

Array = NDArray[np.float64]
Fundamental = Callable[[arb], arb_mat]
"""M: encloses, for a ball of times, the same solutions of the variational equation at all of them.
"""


@dataclass(frozen=True)
class Effect:
    """The effect of all errors up to a time, on q quantities that are read there, in doubles.

    Matrices from an error to its part in the quantities: `answers` (cells, q, n) has M X F for an
    error made in each cell, F being the instant map of its stretch (the unit matrix without one);
    `carried` (cells, q, n) has M X; `reading` (q, n) is that of an error made now, `whole` (q, n)
    that of an error made at the start. `slack` (cells,) bounds the growth in a cell by |answers| +
    slack |carried|. `rounding` bounds the norm of the rounding error of all of them.
    """

    reading: Array
    rounding: float
    answers: Array
    carried: Array
    slack: Array
    whole: Array


WIDEST = 1 / 8
"""The largest delta of a cell: S is at most 1/(1 - 1/8), 14 per cent, larger than what it
bounds.
"""
MAX_ROUNDING_PART = 1 / 8
"""The largest part of S that the bound of rounding errors may have."""
HALVINGS = 80
"""The most halvings of a cell; if it is still too wide then, M is not known well enough."""
ROUNDING = 2.0**-46
"""A bound of the error of a product of two matrices of at most 32 rows in doubles, as a part of the
product of their norms.
"""
UPWARDS = 1 + 2.0**-30
"""The factor by which norms in doubles are multiplied at the end, so that they are upper bounds."""
BOUNDLESS = 1e300
"""The largest S that is returned. It stands for larger ones too, which are near the end of the
range of doubles.
"""

KNOWN = arb(2) ** -50
"""The part of itself by which a number of a closed form may be uncertain before it is rounded to a
double.
"""
CLOSED_BITS = (128, 256, 512, 1024, 2048, 4096)
"""Working precisions for S in closed form: a start at the distance 10^-d from a separatrix loses
about d digits.
"""


class UnsharpError(UndecidedError):
    """The growth of errors is not known well enough at this precision; more bits may help."""

    def __init__(self, message: str, *, final: bool = False) -> None:
        super().__init__(message, code="precision", final=final)


class Grows(Protocol):
    """Anything that can bound the growth S of an error."""

    def at(self, t: Fraction) -> float:
        """S(t) >= 1; UndecidedError where it is not known at this precision."""


@dataclass(frozen=True)
class Stretch:
    """One part of a motion, over which a matrix M of solutions of the variational equation is
    known.

    `begin` [s] is when it begins, `length` [s] how long it lasts (None: it never ends).
    `fundamental` is M over the times since the start. `handover` is M at the end, times the jump
    matrix of an event there: it takes the coordinates of M to the state after the end.
    `instant_map` F is a matrix by which an error is multiplied as soon as it is made (an error of a
    slip that friction stops at once); None for the unit matrix. `joins` is True if the end is no
    event but only a change of coordinates. `quickness` bounds the norm of the field's Jacobian on a
    ball of times, or the logarithmic norms of the Jacobian and of its negative where there is an
    `instant_map`; M is then evaluated at points only. `affine` is True if M(s)^-1 is affine in the
    time s, as in free flight.
    """

    begin: arb
    length: arb | None
    fundamental: Fundamental
    handover: Callable[[], arb_mat]
    instant_map: arb_mat | None = None
    joins: bool = False
    quickness: Callable[[arb], float] | None = None
    affine: bool = False

    def is_over_at(self, t: arb) -> bool:
        """True if the time t lies after the stretch; UndecidedError where t lies within the
        uncertainty of its end.
        """
        if self.length is None:
            return False
        end = self.begin + self.length
        if self.joins:
            # The stretches on both sides of such an end are valid near it: either may be used.
            return bool(t.mid() > end.mid())
        if t > end:
            return True
        if t <= end or (t - end).is_zero():
            return False
        raise UnsharpError(f"t = {t.str(8)} s lies within the uncertainty of an event")


def smooth(
    begin: arb,
    length: arb | None,
    fundamental: Fundamental,
    *,
    jump: arb_mat | None = None,
    instant_map: arb_mat | None = None,
    joins: bool = False,
    quickness: Callable[[arb], float] | None = None,
    affine: bool = False,
) -> Stretch:
    """A stretch of a motion whose M is known at all its times, its end included; `jump` is the jump
    matrix of the event at its end, if there is one.
    """

    def handover() -> arb_mat:
        assert length is not None
        last = fundamental(length)
        if jump is None:
            return last
        return jump * last

    return Stretch(begin, length, fundamental, handover, instant_map, joins, quickness, affine)


class Norm:
    """Norms of matrices, for vectors whose norm is the largest Euclidean norm of their parts.

    `parts` has the number of coordinates in each part of the state; `rows` has the same for the
    quantities that are read of it (by default those of the state). If every part is one coordinate,
    the norm of a matrix is its largest sum of absolute values in a row.
    """

    def __init__(self, parts: Sequence[int], rows: Sequence[int] | None = None) -> None:
        if rows is None:
            row_sizes = parts
        else:
            row_sizes = rows
        self.columns = spans(parts)
        self.rows = spans(row_sizes)
        self.single = len(self.columns) == sum(parts) and (rows is None or len(rows) == sum(rows))

    def read(self, matrices: Array) -> Array:
        """Norms of matrices (..., rows, columns) from the state to what is read of it."""
        return self.norms(matrices, self.rows)

    def __call__(self, matrices: Array) -> Array:
        """Norms of matrices (..., rows, columns) from the state to the state."""
        return self.norms(matrices, self.columns)

    def norms(self, matrices: Array, rows: Sequence[slice]) -> Array:
        """Upper bounds of the operator norms of matrices (..., rows, columns).

        With blocks B_ij from part j to part i, |B x|_i <= sum_j |B_ij| |x_j|: the norm is at most
        the largest sum over j of the spectral norms |B_ij|.
        """
        if self.single:
            largest: Array = np.abs(matrices).sum(axis=-1).max(axis=-1)
            return largest
        row_sums = [
            sum(spectral(matrices[..., row, column]) for column in self.columns) for row in rows
        ]
        bounds: Array = np.max(np.array(row_sums), axis=0)
        return bounds


def spans(parts: Sequence[int]) -> list[slice]:
    """The slice of coordinates of each part, for parts of these sizes one after another."""
    ends = np.cumsum(parts)
    return [slice(int(end) - size, int(end)) for end, size in zip(ends, parts, strict=True)]


def spectral(block: Array) -> Array:
    """Upper bounds of the largest singular values of blocks B (..., rows, columns).

    The lesser of two bounds: sqrt(largest row sum times largest column sum) of |B|, and |(B^T
    B)^8|^(1/16) in the Frobenius norm, which is at most the 32nd root of the number of columns too
    large.
    """
    # Entries of at most 1 keep the 16th powers from overflowing.
    largest = np.abs(block).max(axis=(-2, -1), keepdims=True)
    unit = block / np.where(largest > 0, largest, 1.0)
    magnitudes = np.abs(unit)
    row_sum = magnitudes.sum(axis=-1).max(axis=-1)
    column_sum = magnitudes.sum(axis=-2).max(axis=-1)
    geometric_mean = np.sqrt(row_sum * column_sum)
    # (B^T B)^8 by three squarings.
    power = np.swapaxes(unit, -1, -2) @ unit
    for _ in range(3):
        power = power @ power
    frobenius = np.sqrt((power * power).sum(axis=(-2, -1))) ** (1 / 16)
    bounds: Array = largest[..., 0, 0] * np.minimum(frobenius, geometric_mean) * UPWARDS
    return bounds


@dataclass(frozen=True)
class Cell:
    """An interval of times [low, high] since the start of a stretch, with one matrix X near M(s)^-1
    for all s in it.

    |M(s) X - 1| <= delta for all s of the cell. `inverse` is X in doubles, `slack` = delta/(1 -
    delta) is the most by which |(1 + Delta)^-1| exceeds 1. `fine` is X where it needs more digits
    than doubles have.
    """

    low: Fraction
    high: Fraction
    inverse: Array
    slack: float
    fine: arb_mat | None = None

    @property
    def exact(self) -> arb_mat:
        """X without rounding: the doubles of `inverse`, or `fine` where doubles do not suffice."""
        if self.fine is None:
            return exactly(self.inverse)
        return self.fine


class Element:
    """A stretch with the cells that cover it, which are made as far as requested.

    The same stretch always gets the same cells, independently of earlier requests. `step` is the
    width [s] that the next cell is tried with, `norm` measures errors.
    """

    def __init__(self, stretch: Stretch, norm: Norm, step: Fraction) -> None:
        self.stretch = stretch
        self.norm = norm
        self.step = step
        self.cells: list[Cell] = []
        self.origin = self.cell(Fraction(0), Fraction(0))
        if stretch.length is None:
            self.end = None
        else:
            self.end = upper(stretch.length)

    def cover(self, until: Fraction) -> None:
        """Makes the cells that cover [0, until], or the whole stretch if it ends before."""
        if self.stretch.affine:
            self.cells = self.ends(until)
            return
        while not self.cells or self.cells[-1].high < until:
            if self.cells:
                low = self.cells[-1].high
            else:
                low = Fraction(0)
            if self.end is not None and low >= self.end:
                return
            self.cells.append(self.next_cell(low))

    def ends(self, last: Fraction) -> list[Cell]:
        """Two cells of no width, at 0 and at `last`, that stand for all times between them.

        Where M(s)^-1 is affine in s, the norm of a matrix times it is convex in s, and a convex
        function is largest at an end of its interval.
        """
        return [self.cell(time, time) for time in (Fraction(0), last)]

    def next_cell(self, low: Fraction) -> Cell:
        """The widest cell from `low` on that is narrow enough, of about the last one's width.

        A cell that is too wide is halved; one whose slack is a third of what is allowed lets the
        next one be twice as wide. UnsharpError after HALVINGS.
        """
        for _ in range(HALVINGS):
            high = low + self.step
            if self.end is not None:
                high = min(high, self.end)
            try:
                cell = self.cell(low, high)
            except UnsharpError:
                self.step /= 2
                continue
            if cell.slack < WIDEST / 3:
                self.step *= 2
            return cell
        raise UnsharpError("how errors grow is not known well enough at this precision")

    def cell(self, low: Fraction, high: Fraction) -> Cell:
        """The cell [low, high] with X = M(middle)^-1, rounded to doubles; UndecidedError if it is
        too wide.
        """
        centre = self.stretch.fundamental(arb_of((low + high) / 2))
        inverse = inverse_in_doubles(centre)
        exact = exactly(inverse)
        # |M(middle) X - 1|: the part of delta that is due to the rounding of X.
        residual = self.off_one(centre, exact)
        fine = None
        if not residual < WIDEST / 4:
            # The columns of M are nearly parallel: its inverse needs more digits than doubles have.
            exact = fine = fine_inverse(centre)
            residual = self.off_one(centre, exact)
            inverse, _ = doubles(exact)
        times = arb_of(low).union(arb_of(high))
        if self.stretch.quickness is None:
            delta = self.off_one(self.stretch.fundamental(times), exact)
        else:
            # |M(middle) M(s)^-1| <= exp(q |s - middle|), and |s - middle| <= (high - low)/2
            # (Gronwall). If q bounds the norm of the field's Jacobian, A = M(s) M(middle)^-1 - 1 is
            # at most exp(q |s - middle|) - 1. With M(middle) X = 1 + B, M(s) X = (1 + A)(1 + B).
            exponent = self.stretch.quickness(times) * float(high - low) / 2
            moved = expm1(min(1.0, exponent))
            # |(1 + A)(1 + B) - 1| <= |A| + |B| + |A| |B|.
            delta = (moved + residual + moved * residual) * UPWARDS
        if not delta <= WIDEST:
            raise UnsharpError("a cell that is too wide")
        return Cell(low, high, inverse, delta / (1 - delta), fine)

    def until(self, now: Fraction) -> list[Cell]:
        """The cells that cover [0, now]: those that end by `now`, and one of what is left before
        it.
        """
        if self.stretch.affine:
            return self.ends(max(Fraction(0), now))
        self.cover(now)
        ends = [cell.high for cell in self.cells]
        whole_cells = self.cells[: bisect_right(ends, now)]
        if whole_cells:
            begun = whole_cells[-1].high
        else:
            begun = Fraction(0)
        return [*whole_cells, self.cell(begun, max(begun, now))]

    def inverse_at_begin(self) -> arb_mat:
        """The inverse M(0)^-1 of the fundamental matrix at the start of the stretch, in balls."""
        return inverted(self.stretch.fundamental(arb(0)))

    def off_one(self, matrix: arb_mat, inverse: arb_mat) -> float:
        """An upper bound of |M X - 1| in the norm: how far X is from the inverse of M."""
        product = matrix * inverse
        count = inverse.nrows()
        deviation = np.array(
            [
                [float((product[i, j] - int(i == j)).abs_upper()) for j in range(count)]
                for i in range(count)
            ]
        )
        return float(self.norm(deviation)) * UPWARDS


def inverse_in_doubles(matrix: arb_mat) -> Array:
    """The inverse of the midpoints, as numpy computes it; zeros where it is singular or overflows.

    No proof depends on it: `off_one` bounds its distance from the inverse, which is 1 for zeros.
    """
    middle, _ = doubles(matrix)
    try:
        inverse: Array = np.asarray(np.linalg.inv(middle), dtype=np.float64)
    except np.linalg.LinAlgError:
        return np.zeros_like(middle)
    if not np.isfinite(inverse).all():
        return np.zeros_like(middle)
    return inverse


@dataclass
class Front:
    """The effect of all errors that were made before the start of an element, seen at that start.

    `carried` (cells, n, n) has M(begin) X of every cell so far; `answers` is the same for errors as
    they are felt at once (`Stretch.instant_map`); `slack` (cells,) widens both. `after` (elements,
    n, n) has the derivative from the end of every element so far to here, `weight` (elements,) the
    bound eps_m of what the doubles of that element lost, times S at its start: the two factors of
    the theorem on products. `whole` is the derivative from the start of the motion, `largest` is S
    of the state here, `count` is the number of elements that lie before.
    """

    carried: Array
    answers: Array
    slack: Array
    after: Array
    weight: Array
    whole: Array
    largest: float
    count: int = 0


@dataclass(frozen=True)
class BallEffect:
    """The effect of all errors, in balls.

    `carried` has M X (q, n cells) of all cells side by side (None: there are no cells), `slack`
    (cells,) widens them. `whole` is the derivative by the state at the start. `reading` (q, n), in
    doubles, is what is read of an error that is made now.
    """

    reading: Array
    carried: arb_mat | None
    slack: Array
    whole: arb_mat

    @property
    def answers(self) -> arb_mat:
        """M X of all cells, of which there must be at least one."""
        assert self.carried is not None
        return self.carried


def followed(
    reading: Array, matrix: arb_mat, front: BallEffect, element: Element, cells: Sequence[Cell]
) -> BallEffect:
    """The effect, at a time in an element, of the errors that were carried to its start (`front`)
    and of those of its `cells`.

    `matrix` is M at that time, times the readings if any. An error made before the element is
    multiplied by M M(0)^-1, one made in a cell becomes M X. `reading` is that of an error made now.
    """
    since_begin = matrix * element.inverse_at_begin()
    blocks = [matrix * beside([cell.exact for cell in cells])]
    if front.carried is not None:
        blocks.insert(0, since_begin * front.carried)
    slack = np.concatenate([front.slack, [cell.slack for cell in cells]])
    return BallEffect(reading, beside(blocks), slack, since_begin * front.whole)


class Growth:
    """S along a motion that is given stretch by stretch.

    S is found by products of doubles, and by products of balls where rounding loses too much.
    `readings(t)` gives the derivative of the quantities at t by the state, both in scales; without
    it the state itself is read. `error_coordinates` has the numbers of the coordinates in which
    errors are made: by default all of them. `step` [s] is the width that the first cell is tried
    with.
    """

    def __init__(
        self,
        stretches: Iterable[Stretch],
        size: Norm,
        readings: Callable[[arb], arb_mat] | None = None,
        error_coordinates: Sequence[int] | None = None,
        step: Fraction = Fraction(1, 8),
    ) -> None:
        self.coming: Iterator[Stretch] = iter(stretches)
        self.norm = size
        self.readings = readings
        self.error_coordinates = error_coordinates
        self.step = step
        self.elements: list[Element] = []
        self.front: Front | None = None
        self.ball_front: BallEffect | None = None
        self.ball_count = 0

    def at(self, t: Fraction) -> float:
        """S(t) >= 1; UndecidedError where it is not known at this precision."""
        time = arb_of(t)
        if self.readings is None:
            readings = None
        else:
            readings = self.readings(time)
        return self.read(time, readings)

    def read(self, time: arb, readings: arb_mat | None) -> float:
        """The growth of all errors up to a time, in the quantities that `readings` gives there.

        The growth by a cell is at most |M X| (1 + slack) (theorem on cells), and rounding adds its
        bound.
        """
        effect = self.effect_at(time, readings)
        by_cell = self.norm.read(effect.answers) + self.norm.read(effect.carried) * effect.slack
        # An error made at the time t itself has not grown: only the readings act on it.
        at_once = self.norm.read(effect.reading)
        bound = max(float(by_cell.max(initial=0.0)), float(at_once))
        if effect.rounding > MAX_ROUNDING_PART * bound:
            return self.read_in_balls(time, readings)
        return bounded(bound + effect.rounding)

    def read_in_balls(self, time: arb, readings: arb_mat | None) -> float:
        """The same growth by products of balls, whose radii become smaller with more bits."""
        effect = self.effect_in_balls(time, readings)
        at_once = float(self.norm.read(effect.reading))
        return bounded(max(at_once, self.largest(effect.answers, effect.slack)))

    def largest(self, answers: arb_mat, slack: Array) -> float:
        """The largest growth by M X (q, n cells) of all cells side by side.

        UnsharpError where the radii of the balls make more than the part MAX_ROUNDING_PART of it.
        """
        middles, radii = split(answers, len(slack))
        middle_norms = self.norm.read(middles)
        radius_norms = self.norm.read(radii)
        # |M X| (1 + slack), with |M X| <= |midpoints| + |radii|.
        by_cell = (middle_norms + radius_norms) * (1 + slack)
        bound = float(by_cell.max(initial=0.0)) * UPWARDS
        if not float(radius_norms.max(initial=0.0)) <= MAX_ROUNDING_PART * bound:
            raise UnsharpError("how errors grow is not known well enough at this precision")
        return bound

    def effect_in_balls(self, time: arb, readings: arb_mat | None) -> BallEffect:
        """The effect of all errors up to a time, as they are read there, in balls.

        UnsharpError where errors are made in some coordinates only, or where a stretch has an
        instant map: the computation in balls does not have these.
        """
        number = self.number(time)
        element = self.elements[number]
        stretches = [one.stretch for one in self.elements[: number + 1]]
        has_instant_maps = any(stretch.instant_map is not None for stretch in stretches)
        if self.error_coordinates is not None or has_instant_maps:
            raise UnsharpError(
                "rounding has a larger part in how errors grow than this precision allows"
            )
        since = time - element.stretch.begin
        now = element.stretch.fundamental(since)
        count = now.nrows()
        if readings is None:
            reading = np.eye(count)
            matrix = now
        else:
            reading = doubles(readings)[0]
            matrix = readings * now
        front = self.front_in_balls(number, count)
        return followed(reading, matrix, front, element, element.until(upper(since)))

    def front_in_balls(self, number: int, count: int) -> BallEffect:
        """The effect of all errors made before the element of that number, at its start, in balls.

        `count` is the number of coordinates. Elements are passed one after another; a number before
        the last one requested starts anew.
        """
        if self.ball_front is None or self.ball_count > number:
            self.ball_front = BallEffect(np.eye(count), None, np.zeros(0), unit_matrix(count))
            self.ball_count = 0
        while self.ball_count < number:
            element = self.elements[self.ball_count]
            assert element.end is not None
            element.cover(element.end)
            handover = element.stretch.handover()
            self.ball_front = followed(
                np.eye(count), handover, self.ball_front, element, element.cells
            )
            self.ball_count += 1
        return self.ball_front

    def effect_at(self, time: arb, readings: arb_mat | None) -> Effect:
        """The effect of all errors up to a time, as they are read there, in doubles."""
        number = self.number(time)
        element = self.elements[number]
        front = self.front_at(number)
        since = time - element.stretch.begin
        cells = element.until(upper(since))
        now = element.stretch.fundamental(since)
        if readings is None:
            reading = np.eye(now.nrows())
            read_now = now
        else:
            reading = doubles(readings)[0]
            read_now = readings * now
        # The derivative of the readings by the coordinates of M, and the error of its doubles.
        matrix, inexact = doubles(read_now)
        inverses = np.array([cell.inverse for cell in cells])
        # Errors made in this element become M X, those made before it M M(0)^-1 (what was carried).
        fresh = matrix @ inverses
        since_begin = matrix @ element.origin.inverse
        rows = max(1, matrix.shape[0])
        # |fl(M X) - M X| <= unit_loss |X|, with the error of the doubles of M and that of the
        # product.
        unit_loss = inexact * rows + ROUNDING * float(self.norm.read(matrix))
        loss_of_fresh = unit_loss * float(self.norm(inverses).max())
        # The theorem on products: |P - Q| of this element times S at its start, with
        # |P - Q| <= unit_loss |X_0| + |M X_0| slack_0, X_0 near M(0)^-1; and the sum over earlier
        # elements m of |Q_(m+1..now)| eps_m S_m.
        loss_of_carried = (
            unit_loss * float(self.norm(element.origin.inverse))
            + float(self.norm.read(since_begin)) * element.origin.slack
        ) * front.largest
        followed_norms = self.norm.read(since_begin @ front.after)
        loss_on_the_way = float((followed_norms * front.weight).sum())
        # Cell by cell: what was carried to the start of this element, then what is made in it.
        carried = np.concatenate([since_begin @ front.carried, fresh])
        fresh_answers = self.after_instant_map(element, fresh)
        answers = np.concatenate([since_begin @ front.answers, fresh_answers])
        slack = np.concatenate([front.slack, self.slack(element, cells)])
        return Effect(
            reading=reading,
            rounding=loss_of_fresh + loss_of_carried + loss_on_the_way,
            answers=answers,
            carried=carried,
            slack=slack,
            whole=since_begin @ front.whole,
        )

    def number(self, time: arb) -> int:
        """The number of the element in which a time lies; elements up to it are made."""
        number = 0
        while True:
            while number >= len(self.elements):
                self.elements.append(self.next_element())
            if not self.elements[number].stretch.is_over_at(time):
                return number
            number += 1

    def next_element(self) -> Element:
        """The element of the next stretch, which begins with the width of cell of the last one.

        UnsharpError if the motion has no more stretches.
        """
        if self.elements:
            last = self.elements[-1]
            assert last.end is not None
            last.cover(last.end)
            self.step = last.step
        stretch = next(self.coming, None)
        if stretch is None:
            raise UnsharpError("the motion is not known so far")
        return Element(stretch, self.norm, self.step)

    def front_at(self, number: int) -> Front:
        """The effect of all errors made before the element of that number, at its start."""
        if self.front is None or self.front.count > number:
            self.front = self.no_errors(len(self.elements[0].origin.inverse))
        while self.front.count < number:
            self.front = self.passed(self.front, self.elements[self.front.count])
        return self.front

    def no_errors(self, count: int) -> Front:
        """The front at the start of a motion of so many coordinates: no error has been made."""
        empty = np.zeros((0, count, count))
        return Front(
            carried=empty,
            answers=self.chosen(empty),
            slack=np.zeros(0),
            after=empty,
            weight=np.zeros(0),
            whole=np.eye(count),
            largest=1.0,
        )

    def passed(self, front: Front, element: Element) -> Front:
        """The front at the end of an element, from that at its start.

        With H the handover, an error made before becomes H M(0)^-1 of itself, one made in a cell H
        X.
        """
        assert element.end is not None
        element.cover(element.end)
        handover, inexact = doubles(element.stretch.handover())
        inverses = np.array([cell.inverse for cell in element.cells])
        whole = handover @ element.origin.inverse
        fresh = handover @ inverses
        # |fl(H X) - H X| <= unit_loss |X|, with the error of the doubles of H and that of the
        # product.
        unit_loss = inexact * len(handover) + ROUNDING * float(self.norm(handover))
        # eps_m = unit_loss |X_0| + |H X_0| (slack_0 + 4 ROUNDING) >= |P - Q|, X_0 near M(0)^-1: the
        # errors of the doubles of H and of X_0. `weight` is eps_m S, plus the error of H X of
        # the cells.
        product_loss = unit_loss * float(self.norm(element.origin.inverse)) + float(
            self.norm(whole)
        ) * (element.origin.slack + 4 * ROUNDING)
        weight = product_loss * front.largest + unit_loss * float(self.norm(inverses).max())
        after = np.concatenate([whole @ front.after, np.eye(len(whole))[None]])
        answers = np.concatenate([whole @ front.answers, self.after_instant_map(element, fresh)])
        carried = np.concatenate([whole @ front.carried, fresh])
        slack = np.concatenate([front.slack, self.slack(element, element.cells)])
        weights = np.concatenate([front.weight, [weight]])
        by_cell = self.norm(answers) + self.norm(carried) * slack
        # S at the end: the largest |H X F| + slack |H X| of a cell, plus the sum over elements m of
        # |Q_(m+1..end)| times the weight of m.
        largest = float(by_cell.max()) + float((self.norm(after) * weights).sum())
        return Front(
            carried=carried,
            answers=answers,
            slack=slack,
            after=after,
            weight=weights,
            whole=whole @ front.whole,
            largest=bounded(largest),
            count=front.count + 1,
        )

    def slack(self, element: Element, cells: Sequence[Cell]) -> Array:
        """The slack (cells,) of cells, times |F| where the stretch has an instant map F.

        M X (1 + Delta)^-1 F differs from M X F by at most |M X| slack |F|.
        """
        slacks = np.array([cell.slack for cell in cells])
        if element.stretch.instant_map is None:
            return slacks
        return slacks * float(self.norm(doubles(element.stretch.instant_map)[0])) * UPWARDS

    def after_instant_map(self, element: Element, carried: Array) -> Array:
        """Matrices (cells, q, n) of carried errors, times the instant map F if there is one."""
        if element.stretch.instant_map is None:
            return self.chosen(carried)
        return self.chosen(carried @ doubles(element.stretch.instant_map)[0])

    def chosen(self, carried: Array) -> Array:
        """Matrices (cells, q, n) with zero columns for the coordinates in which no errors are
        made.
        """
        if self.error_coordinates is None:
            return carried
        chosen = np.zeros_like(carried)
        chosen[..., list(self.error_coordinates)] = carried[..., list(self.error_coordinates)]
        return chosen


@dataclass(frozen=True)
class PeriodicGrowth:
    """S along a motion of period P whose errors grow in proportion to time: D(P) = 1 + N with N N =
    0.

    Motions of one degree of freedom and Kepler's ellipses are such: their period depends on the
    energy E alone, N = -P'(E) f grad E^T, and grad E . f = 0. With t = tau + k P and an error made
    at s in an earlier period,

        D(t) D(s)^-1 = D(tau) (1 + n N) A,    0 <= n <= k - 1,

    A being the growth from s to the end of its period. The norm is convex in n, so it is largest
    for n = 0 or n = k - 1.

    `first` gives the growth within one period.
    """

    first: Growth
    period: arb

    @cached_property
    def over_a_period(self) -> Effect:
        """What errors made within a period have become at its end, by products of doubles."""
        return self.first.effect_at(self.period, None)

    @cached_property
    def over_a_period_in_balls(self) -> BallEffect:
        """What errors made within a period have become at its end, by products of balls."""
        return self.first.effect_in_balls(self.period, None)

    def at(self, t: Fraction) -> float:
        """The bound S(t) >= 1 on the growth of an error."""
        time = arb_of(t)
        # t = tau + k P, with k = `turns` and tau = `since`.
        turns = int(ball_of(time / self.period).mid)
        if turns == 0:
            return self.first.at(t)
        since = time - turns * self.period
        if not since >= 0:
            # It is not decided whether the period is over: `since` holds all times of the ball.
            since = arb(0).union(arb(since.abs_upper()))
        if self.first.readings is None:
            readings = None
        else:
            readings = self.first.readings(time)
        this_period = self.first.read(since, readings)
        earlier, rounding = self.of_earlier(since, readings, turns)
        if rounding > MAX_ROUNDING_PART * max(this_period, earlier):
            return bounded(max(this_period, self.of_earlier_in_balls(since, readings, turns)))
        return bounded(max(this_period, earlier + rounding))

    def of_earlier(self, since: arb, readings: arb_mat | None, turns: int) -> tuple[float, float]:
        """The growth of errors made in earlier periods, by products of doubles, and a bound of its
        rounding error.

        `since` is tau, the time since the last period ended, at which `readings` are made; `turns`
        is the number k of whole periods.
        """
        norm = self.first.norm
        period = self.over_a_period
        now = self.first.effect_at(since, readings)
        # S at the end of the first period.
        by_cell = norm(period.answers) + norm(period.carried) * period.slack
        largest = bounded(float(by_cell.max()) + period.rounding)
        # N = D(P) - 1.
        one = np.eye(len(period.whole))
        drift = period.whole - one
        growth_bound = 0.0
        rounding_bound = 0.0
        # A norm is convex in n, so that it is largest at an end of 0 <= n <= k - 1.
        for n in {0, turns - 1}:
            # D(tau) (1 + n N) A, of each cell.
            later = now.whole @ (one + n * drift)
            sizes = norm.read(later @ period.answers)
            sizes = sizes + norm.read(later @ period.carried) * period.slack
            # The error of D(tau) (1 + n N), at most
            #   rounding_tau (1 + n |N|) + |D(tau)| n rounding_P + ROUNDING |D(tau)| (1 + n |N|),
            # times S at the end of the first period; and |D(tau) (1 + n N)| times the error of A.
            drift_norm = 1 + n * float(norm(drift))
            now_norm = float(norm.read(now.whole))
            inexact = now.rounding * drift_norm + now_norm * n * period.rounding
            inexact += ROUNDING * now_norm * drift_norm
            lost = inexact * largest + float(norm.read(later)) * period.rounding
            growth_bound = max(growth_bound, float(sizes.max()))
            rounding_bound = max(rounding_bound, lost)
        return growth_bound, rounding_bound

    def of_earlier_in_balls(self, since: arb, readings: arb_mat | None, turns: int) -> float:
        """The growth of errors made in earlier periods, by products of balls; the arguments are
        those of `of_earlier`.
        """
        growth = self.first
        period = self.over_a_period_in_balls
        # D(tau), and N = D(P) - 1.
        now = growth.effect_in_balls(since, readings).whole
        one = unit_matrix(period.whole.nrows())
        drift = period.whole - one
        bounds = []
        for n in {0, turns - 1}:
            # D(tau) (1 + n N) A.
            answers = now * (one + n * drift) * period.answers
            bounds.append(growth.largest(answers, period.slack))
        return max(bounds)


class SteadyGrowth:
    """S of a motion whose errors obey a linear equation with constant coefficients: their growth
    depends on the elapsed time alone.

        S(t) = max over 0 <= tau <= t of |exp(J tau)|

    `propagator` gives exp(J tau). If its norm is at most 1 at some time `repeat` > 0, then
    |exp(J (repeat + tau))| <= |exp(J tau)|, and the maximum lies before `repeat`. `step` [s] is the
    width that the first cell of elapsed times is tried with.
    """

    def __init__(
        self, propagator: Fundamental, size: Norm, step: Fraction, repeat: arb | None = None
    ) -> None:
        self.propagator = propagator
        self.measure = size
        self.step = step
        self.repeat = repeat
        # The upper end of each cell of elapsed times, and the largest norm in it.
        self.highs: list[Fraction] = [Fraction(0)]
        self.norms: list[float] = [1.0]

    def at(self, t: Fraction) -> float:
        """The bound S(t) >= 1 on the growth of an error: the largest norm of the cells up to t."""
        if self.repeat is not None:
            t = min(t, upper(self.repeat))
        while self.highs[-1] < t:
            self.advance()
        whole = max(norm for high, norm in zip(self.highs, self.norms, strict=True) if high <= t)
        before = max(high for high in self.highs if high <= t)
        if before == t:
            rest = 0.0
        else:
            rest = self.norm(arb_of(before).union(arb_of(t)))
        return bounded(max(whole, rest))

    def advance(self) -> None:
        """Appends the next cell of elapsed times, on which the bound of the norm is at most an
        eighth above the larger of 1 and the norm in its middle.
        """
        low = self.highs[-1]
        for _ in range(HALVINGS):
            high = low + self.step
            bound = self.norm(arb_of(low).union(arb_of(high)))
            middle = self.norm(arb_of((low + high) / 2))
            if bound <= (1 + WIDEST) * max(1.0, middle):
                self.highs.append(high)
                self.norms.append(bound)
                # A third of what is allowed: the next cell may be twice as wide.
                if bound <= (1 + WIDEST / 3) * max(1.0, middle):
                    self.step *= 2
                return
            self.step /= 2
        raise UnsharpError("how errors grow is not known well enough at this precision")

    def norm(self, elapsed: arb) -> float:
        """The largest norm of exp(J tau) for tau in a ball of times elapsed [s]; infinite where the
        propagator is not finite.
        """
        table = self.propagator(elapsed).table()
        if not all(entry.is_finite() for row in table for entry in row):
            return inf
        magnitudes = np.array([[float(entry.abs_upper()) for entry in row] for row in table])
        return float(self.measure.read(magnitudes))


@dataclass(frozen=True)
class Told:
    """S by a formula of the time: a ball that holds the supremum, or a bound of it."""

    formula: Callable[[arb], arb]

    def at(self, t: Fraction) -> float:
        """The bound S(t) >= 1 on the growth of an error."""
        return bounded(float(self.formula(arb_of(t)).upper()))


@dataclass(frozen=True)
class Retimed:
    """S of a motion whose `first` growth counts time in units of `unit` [s]."""

    first: Grows
    unit: Fraction

    def at(self, t: Fraction) -> float:
        """The bound S(t) >= 1 on the growth of an error."""
        return self.first.at(t / self.unit)


@dataclass(frozen=True)
class Times:
    """S of a motion whose errors are larger by a `factor` than those of another, whose S is
    `first`.
    """

    first: Grows
    factor: arb

    def at(self, t: Fraction) -> float:
        """The bound S(t) >= 1 on the growth of an error."""
        return bounded(self.first.at(t) * float(upper(self.factor)))


def narrow(rate: arb) -> Fraction:
    """The width [s] to begin with for a cell: a power of two between 1/32 and 1/16 of 1/rate.

    `rate` [1/s] is that at which errors change; without any the width is 1/8 s.
    """
    fastest = float(rate.abs_upper())
    if fastest > 0:
        # fastest = m 2^e with 1/2 <= m < 1.
        exponent = frexp(fastest)[1]
        return Fraction(2) ** (-4 - exponent)
    return Fraction(1, 8)


def most(values: Iterable[arb]) -> float:
    """The largest upper end of the balls, at least 0; infinite where a ball is not finite, which
    Python's max would ignore.
    """
    largest = 0.0
    for value in values:
        if not value.is_finite():
            return inf
        largest = max(largest, float(value.upper()))
    return largest


def doubles(matrix: arb_mat) -> tuple[Array, float]:
    """The midpoints of a matrix of balls as doubles, and a bound of its largest error in norm.

    The bound is the number of columns times the largest error of an entry: its radius, and 2^-52 of
    its midpoint, which is truncated to a double. UndecidedError if an entry is not finite.
    """
    table = matrix.table()
    middles = np.array([[float(entry.mid()) for entry in row] for row in table])
    radius = max((float(entry.rad()) for row in table for entry in row), default=0.0)
    if not (np.isfinite(middles).all() and isfinite(radius)):
        raise UnsharpError("how errors grow is not known at this precision")
    columns = max(1, middles.shape[1])
    cut_off = 2.0**-52 * float(np.abs(middles).max(initial=0.0))
    return middles, (radius + cut_off) * columns


def known(value: arb, size: float = 0.0) -> float:
    """The double of a ball whose radius is at most KNOWN of its midpoint, or of `size`.

    UnsharpError if it is larger.
    """
    middle = value.mid()
    if not (value.is_finite() and value.rad() <= KNOWN * arb.max(abs(middle), arb(size))):
        raise UnsharpError("the motion is not known well enough at this precision")
    return float(middle)


def rounded(values: Sequence[arb]) -> tuple[Array, float]:
    """The midpoints of balls as doubles, and their largest radius; UnsharpError if one is not
    finite.
    """
    if not all(value.is_finite() for value in values):
        raise UnsharpError("the motion is not known at this precision")
    largest_radius = max(float(value.rad()) for value in values)
    return np.array([float(value.mid()) for value in values]), largest_radius


def beside(matrices: Sequence[arb_mat]) -> arb_mat:
    """One matrix of matrices of the same number of rows, side by side."""
    tables = [matrix.table() for matrix in matrices]
    rows = []
    for i in range(len(tables[0])):
        rows.append([entry for table in tables for entry in table[i]])
    return arb_mat(rows)


def split(matrix: arb_mat, count: int) -> tuple[Array, Array]:
    """Midpoints and radii (count, rows, columns) of so many matrices that stand side by side: the
    reverse of `beside`.

    UnsharpError if one is not finite.
    """
    table = matrix.table()
    middles = np.array([[float(entry.mid()) for entry in row] for row in table])
    radii = np.array([[float(entry.rad()) for entry in row] for row in table])
    if not (np.isfinite(middles).all() and np.isfinite(radii).all()):
        raise UnsharpError("how errors grow is not known at this precision")
    shape = (matrix.nrows(), count, matrix.ncols() // count)
    return middles.reshape(shape).swapaxes(0, 1), radii.reshape(shape).swapaxes(0, 1)


def between_scales(rows: Sequence[Sequence[arb]], sizes: Sequence[arb]) -> arb_mat:
    """A matrix that maps errors of coordinates, given by its rows, in units of the sizes of these
    coordinates: entry (i, j) times size j over size i.
    """
    scaled = []
    for row, size in zip(rows, sizes, strict=True):
        scaled.append([entry * column / size for entry, column in zip(row, sizes, strict=True)])
    return arb_mat(scaled)


def inverted(matrix: arb_mat) -> arb_mat:
    """The inverse of a matrix of balls; UnsharpError where they may hold a singular matrix."""
    try:
        return matrix.inv()
    except ZeroDivisionError:
        raise UnsharpError("a matrix of solutions that is not regular") from None


def fine_inverse(matrix: arb_mat) -> arb_mat:
    """An exact matrix near the inverse, to the working precision: the midpoints of its balls."""
    return inverted(matrix).mid()


def exactly(matrix: Array) -> arb_mat:
    """A matrix of doubles as exact balls."""
    return arb_mat(len(matrix), matrix.shape[1], [float(x) for x in matrix.flatten()])


def bounded(value: float) -> float:
    """An S rounded up: at least 1, and BOUNDLESS where it is larger than that or not a number."""
    if not value < BOUNDLESS:
        return BOUNDLESS
    if value > 1.0:
        return max(1.0, value) * UPWARDS
    return 1.0


def upper(value: arb) -> Fraction:
    """The exact upper end of a ball; ValueError if it is not finite."""
    ball = ball_of(value)
    return ball.mid + ball.radius
