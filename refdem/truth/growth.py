"""S(t): how much an error that is made at any time s <= t may have grown by t, as a proven upper
bound.

An error e made at s is D(t) D(s)^-1 e at t, to first order, D being the derivative of the flow. Let
M be any matrix of solutions of the variational equation, M(t) M(s)^-1 = D(t) D(s)^-1.

Theorem (cell): let M(s) X = 1 + Delta(s) with |Delta(s)| <= delta < 1 for all s of a cell, X one
fixed matrix. Then M(s) is regular, M(t) M(s)^-1 = M(t) X (1 + Delta(s))^-1, and the growth of every
error made in the cell is at most |M(t) X| / (1 - delta). So times of errors are covered by cells,
not sampled: M is evaluated on balls of times, and cells are halved until delta is small.

Theorem (products): let P_m be the true derivative over stretch m and Q_m the doubles that stand for
it, |P_m - Q_m| <= eps_m. From a cell c to t the product of the P differs from that of the Q by the
sum over m of Q_(m+1..t) (P_m - Q_m) P_(c..m), whose last factor is at most S at the begin of
stretch m, which is known. So S is a maximum of norms of products in doubles and one proven sum of
errors.

Hypotheses, and where each is checked:

* M solves the variational equation on the stretch: the families' own proof; enclosures of it are
  evaluated on balls that hold all times of a cell (`Element.cell`);
* delta <= WIDEST < 1 on every cell: `Element.cell`, which raises UnsharpError, so that
  `Element.next_cell` halves; where `quickness` bounds the field's Jacobian instead, delta follows
  from Gronwall's inequality;
* the cells cover all times up to t: `Element.cover` and `Element.until` begin each where the last
  one ended;
* t lies in one stretch: `Stretch.is_over_at` raises UnsharpError within the uncertainty of an end;
* |P_m - Q_m| <= eps_m: `doubles` gives the radii of what is rounded, and ROUNDING is a bound of
  products in binary64 (`Growth.passed`, `Growth.errors_at`);
* what rounding may have lost is a small part of S: `Growth.read` compares it with LOST, and goes on
  in balls (`read_wide`), or asks for more bits.
"""

from bisect import bisect_right
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import expm1, frexp, inf, isfinite
from typing import Protocol

import numpy as np
from flint import arb, arb_mat
from numpy.typing import NDArray

from refdem.truth.balls import UndecidedError, arb_of, ball_of

Array = NDArray[np.float64]
Fundamental = Callable[[arb], arb_mat]
"""M: encloses, for a ball of times, the same solutions of the variational equation at all of them.
"""

Errors = tuple[Array, float, Array, Array, Array, Array]
"""What `errors_at` of Growth returns."""

WIDEST = 1 / 8
"""delta: S is at most 1/(1 - 1/8), 14 per cent, larger than what it bounds."""
LOST = 1 / 8
"""Part of S that what is lost by rounding may have; a higher precision loses less."""
HALVINGS = 80
"""Of a cell; one that is still too wide says that M is not known well enough."""
ROUNDING = 2.0**-46
"""Part of the product of their norms by which a product of two matrices of at most 32 rows in
doubles is off, at most.
"""
UPWARDS = 1 + 2.0**-30
"""What norms in doubles are multiplied by at the end."""
BOUNDLESS = 1e300
"""An S that is larger is not told apart from this: no double has had a digit left for long."""

KNOWN = arb(2) ** -50
"""Part by which a number of a closed form may be uncertain before it is rounded to a double."""
CLOSED_BITS = (128, 256, 512, 1024, 2048, 4096)
"""Working precisions for S in closed form: near a separatrix its numbers lose as many digits as the
start is off it.
"""


class UnsharpError(UndecidedError):
    """How errors grow is not known well enough at this precision."""

    def __init__(self, message: str, *, final: bool = False) -> None:
        super().__init__(message, code="precision", final=final)


class Grows(Protocol):
    """Anything that can bound the growth S of an error."""

    def at(self, t: Fraction) -> float:
        """S(t) >= 1; UndecidedError where it is not known at this precision."""


@dataclass(frozen=True)
class Stretch:
    """Part of a motion: M over the times [s] since its begin, and what takes the coordinates of M
    to the state after its end.

    `length` is None for a stretch that never ends. `handover` is M at its end, times the jump of an
    event there. `felt` is what an error undergoes at once, as a slip does that friction stops; None
    where errors stay what they are. `joins`: nothing happens at the end, where only the way of
    telling the motion changes. `quickness` bounds the norm of the field's Jacobian on a ball of
    times, or the logarithmic norms of it and of its negative where errors are felt as they are
    made; M is then evaluated at points only.
    """

    begin: arb
    length: arb | None
    fundamental: Fundamental
    handover: Callable[[], arb_mat]
    felt: arb_mat | None = None
    joins: bool = False
    quickness: Callable[[arb], float] | None = None

    def is_over_at(self, t: arb) -> bool:
        """Whether the time t lies after the stretch.

        UndecidedError where t lies within the uncertainty of its end.
        """
        if self.length is None:
            return False
        end = self.begin + self.length
        if self.joins:
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
    felt: arb_mat | None = None,
    joins: bool = False,
    quickness: Callable[[arb], float] | None = None,
) -> Stretch:
    """A stretch of a motion whose M is known at all its times; at its end the state jumps by
    `jump`, if it does.
    """

    def handover() -> arb_mat:
        assert length is not None
        last = fundamental(length)
        if jump is None:
            return last
        return jump * last

    return Stretch(begin, length, fundamental, handover, felt, joins, quickness)


class Norm:
    """Norms of matrices: vectors are as large as the largest of their parts, each part is measured
    by Euclid.

    `parts` has the number of coordinates in each part of the state, `rows` the same of what is read
    of it. With parts of one number the norm of a matrix is its largest sum of absolute values in a
    row.
    """

    def __init__(self, parts: Sequence[int], rows: Sequence[int] | None = None) -> None:
        self.columns = spans(parts)
        self.rows = spans(parts if rows is None else rows)
        self.single = len(self.columns) == sum(parts) and (rows is None or len(rows) == sum(rows))

    def read(self, matrices: Array) -> Array:
        """Norms of matrices (..., rows, columns) from the state to what is read of it."""
        return self.norms(matrices, self.rows)

    def __call__(self, matrices: Array) -> Array:
        """Norms of matrices (..., rows, columns) from the state to the state."""
        return self.norms(matrices, self.columns)

    def norms(self, matrices: Array, rows: Sequence[slice]) -> Array:
        """Upper bounds of the operator norms."""
        if self.single:
            largest: Array = np.abs(matrices).sum(axis=-1).max(axis=-1)
            return largest
        sums = [
            sum(spectral(matrices[..., row, column]) for column in self.columns) for row in rows
        ]
        found: Array = np.max(np.array(sums), axis=0)
        return found


def spans(parts: Sequence[int]) -> list[slice]:
    """Where each part lies among the coordinates."""
    ends = np.cumsum(parts)
    return [slice(int(end) - size, int(end)) for end, size in zip(ends, parts, strict=True)]


def spectral(block: Array) -> Array:
    """Upper bounds of the largest singular values of blocks (..., rows, columns).

    The lesser of the geometric mean of the largest sums of a row and of a column, and of |(B^T
    B)^8|^(1/16) in Frobenius' norm, which is at most the 32nd root of the number of columns too
    large.
    """
    largest = np.abs(block).max(axis=(-2, -1), keepdims=True)
    unit = block / np.where(largest > 0, largest, 1.0)
    sizes = np.abs(unit)
    mean = np.sqrt(sizes.sum(axis=-1).max(axis=-1) * sizes.sum(axis=-2).max(axis=-1))
    power = np.swapaxes(unit, -1, -2) @ unit
    for _ in range(3):
        power = power @ power
    sharper = np.sqrt((power * power).sum(axis=(-2, -1))) ** (1 / 16)
    found: Array = largest[..., 0, 0] * np.minimum(sharper, mean) * UPWARDS
    return found


@dataclass(frozen=True)
class Cell:
    """Times [low, high] since the begin of a stretch, at all of which |M(s) X - 1| <= delta.

    `slack` is delta/(1 - delta).
    """

    low: Fraction
    high: Fraction
    inverse: Array
    slack: float
    fine: arb_mat | None = None

    @property
    def exact(self) -> arb_mat:
        """X: the doubles of `inverse`, or, where doubles do not suffice, what they are rounded
        from.
        """
        if self.fine is None:
            return exactly(self.inverse)
        return self.fine


class Element:
    """A stretch with its cells, made as far as they are asked for, always the same ones."""

    def __init__(self, stretch: Stretch, size: Norm, step: Fraction) -> None:
        self.stretch = stretch
        self.size = size
        self.step = step
        self.cells: list[Cell] = []
        self.origin = self.cell(Fraction(0), Fraction(0))
        if stretch.length is None:
            self.end = None
        else:
            self.end = upper(stretch.length)

    def cover(self, until: Fraction) -> None:
        """Makes the cells that cover [0, until]."""
        while not self.cells or self.cells[-1].high < until:
            if self.cells:
                low = self.cells[-1].high
            else:
                low = Fraction(0)
            if self.end is not None and low >= self.end:
                return
            self.cells.append(self.next_cell(low))

    def next_cell(self, low: Fraction) -> Cell:
        """The widest cell from `low` on that is narrow enough, of about the last one's width."""
        for _ in range(HALVINGS):
            high = low + self.step
            if self.end is not None:
                high = min(high, self.end)
            try:
                found = self.cell(low, high)
            except UnsharpError:
                self.step /= 2
                continue
            if found.slack < WIDEST / 3:
                self.step *= 2
            return found
        raise UnsharpError("how errors grow is not known well enough at this precision")

    def cell(self, low: Fraction, high: Fraction) -> Cell:
        """A cell; UndecidedError if it is too wide."""
        centre = self.stretch.fundamental(arb_of((low + high) / 2))
        middle, _ = doubles(centre)
        try:
            inverse: Array = np.asarray(np.linalg.inv(middle), dtype=np.float64)
        except np.linalg.LinAlgError:
            inverse = np.zeros_like(middle)
        if not np.isfinite(inverse).all():
            inverse = np.zeros_like(middle)
        exact = exactly(inverse)
        off = self.off_one(centre, exact)
        fine = None
        if not off < WIDEST / 4:
            # An M whose columns are nearly alike: its inverse asks for more digits than doubles
            # have.
            exact = fine = fine_inverse(centre)
            off = self.off_one(centre, exact)
            inverse, _ = doubles(exact)
        times = arb_of(low).union(arb_of(high))
        if self.stretch.quickness is None:
            delta = self.off_one(self.stretch.fundamental(times), exact)
        else:
            # M(middle) M(s)^-1 is at most exp(q |s - middle|) in norm, and, q being the norm
            # itself, 1 to less than that - 1 (Gronwall).
            moved = expm1(min(1.0, self.stretch.quickness(times) * float(high - low) / 2))
            delta = (moved + off + moved * off) * UPWARDS
        if not delta <= WIDEST:
            raise UnsharpError("a cell that is too wide")
        return Cell(low, high, inverse, delta / (1 - delta), fine)

    def until(self, now: Fraction) -> list[Cell]:
        """The cells that end by a time since the begin, and what of the last one lies before it."""
        self.cover(now)
        cells = self.cells[: bisect_right([cell.high for cell in self.cells], now)]
        if cells:
            begun = cells[-1].high
        else:
            begun = Fraction(0)
        return [*cells, self.cell(begun, max(begun, now))]

    def from_begin(self) -> arb_mat:
        """The inverse M(0)^-1 of the first fundamental matrix, in balls."""
        return inverted(self.stretch.fundamental(arb(0)))

    def off_one(self, matrix: arb_mat, inverse: arb_mat) -> float:
        """The norm |M X - 1|: how far X is from the inverse of M."""
        product = matrix * inverse
        count = inverse.nrows()
        apart = np.array(
            [
                [float((product[i, j] - int(i == j)).abs_upper()) for j in range(count)]
                for i in range(count)
            ]
        )
        return float(self.size(apart)) * UPWARDS


@dataclass
class Front:
    """All errors made before the begin of an element, there.

    `carried` (cells, n, n) has M(begin) X of every cell, `answers` the same with what errors
    undergo at once; `slack` (cells,) what widens them. `after` (elements, n, n) has the derivative
    from the end of every element, `weight` (elements,) the error that was made in it times S at its
    begin. `whole` is the derivative from the start, `largest` is S, of the state itself.
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
class Wide:
    """The same in balls: M X (q, n cells) of all cells side by side (None: there are none) with
    their slack, what the state at the start has become, and in doubles what is read of an error
    made now.
    """

    own: Array
    carried: arb_mat | None
    slack: Array
    whole: arb_mat

    @property
    def answers(self) -> arb_mat:
        """M X of all cells, at least one."""
        assert self.carried is not None
        return self.carried


def followed(
    own: Array, matrix: arb_mat, front: Wide, element: Element, cells: Sequence[Cell]
) -> Wide:
    """What was carried to the begin of an element, and the errors of its cells, followed by M
    there.
    """
    first = matrix * element.from_begin()
    parts = [matrix * beside([cell.exact for cell in cells])]
    if front.carried is not None:
        parts.insert(0, first * front.carried)
    slack = np.concatenate([front.slack, [cell.slack for cell in cells]])
    return Wide(own, beside(parts), slack, first * front.whole)


class Growth:
    """S along a motion that is told stretch by stretch: by products of doubles, and of balls where
    those lose too much.

    `readings(t)` gives the derivative of what is read at t by the state, both in scales; without it
    the state itself is read.
    `made` has the numbers of the coordinates in which errors are made: by default all of them.
    """

    def __init__(
        self,
        stretches: Iterable[Stretch],
        size: Norm,
        readings: Callable[[arb], arb_mat] | None = None,
        made: Sequence[int] | None = None,
        step: Fraction = Fraction(1, 8),
    ) -> None:
        self.coming: Iterator[Stretch] = iter(stretches)
        self.size = size
        self.readings = readings
        self.made = made
        self.step = step
        self.elements: list[Element] = []
        self.front: Front | None = None
        self.wide: Wide | None = None
        self.wide_count = 0

    def at(self, t: Fraction) -> float:
        """S(t) >= 1; UndecidedError where it is not known at this precision."""
        time = arb_of(t)
        return self.read(time, None if self.readings is None else self.readings(time))

    def read(self, time: arb, readings: arb_mat | None) -> float:
        """The growth of all errors up to a time, as it is read there."""
        now, lost, answers, carried, slack, _ = self.errors_at(time, readings)
        sizes = self.size.read(answers) + self.size.read(carried) * slack
        # An error made at the time itself has not grown, but is read.
        own = self.size.read(now)
        told = max(float(sizes.max(initial=0.0)), float(own))
        if lost > LOST * told:
            return self.read_wide(time, readings)
        return bounded(told + lost)

    def read_wide(self, time: arb, readings: arb_mat | None) -> float:
        """The same by products of balls, which more bits make as sharp as need be."""
        wide = self.wide_at(time, readings)
        own = float(self.size.read(wide.own))
        return bounded(max(own, self.largest(wide.answers, wide.slack)))

    def largest(self, answers: arb_mat, slack: Array) -> float:
        """The largest growth by M X (q, n cells) of all cells side by side."""
        middles, radii = split(answers, len(slack))
        sizes = self.size.read(middles)
        off = self.size.read(radii)
        told = float(((sizes + off) * (1 + slack)).max(initial=0.0)) * UPWARDS
        if not float(off.max(initial=0.0)) <= LOST * told:
            raise UnsharpError("how errors grow is not known well enough at this precision")
        return told

    def wide_at(self, time: arb, readings: arb_mat | None) -> "Wide":
        """All errors up to a time, as they are read there, in balls."""
        number = self.number(time)
        element = self.elements[number]
        if self.made is not None or any(
            one.stretch.felt is not None for one in self.elements[: number + 1]
        ):
            raise UnsharpError(
                "rounding has a larger part in how errors grow than this precision allows"
            )
        since = time - element.stretch.begin
        now = element.stretch.fundamental(since)
        count = now.nrows()
        if readings is None:
            own = np.eye(count)
        else:
            own = doubles(readings)[0]
        if readings is None:
            matrix = now
        else:
            matrix = readings * now
        front = self.wide_front_at(number, count)
        return followed(own, matrix, front, element, element.until(upper(since)))

    def wide_front_at(self, number: int, count: int) -> "Wide":
        """All errors made before an element, at its begin, in balls."""
        if self.wide is None or self.wide_count > number:
            one = arb_mat(count, count, [int(i == j) for i in range(count) for j in range(count)])
            self.wide = Wide(np.eye(count), None, np.zeros(0), one)
            self.wide_count = 0
        while self.wide_count < number:
            element = self.elements[self.wide_count]
            assert element.end is not None
            element.cover(element.end)
            self.wide = followed(
                np.eye(count), element.stretch.handover(), self.wide, element, element.cells
            )
            self.wide_count += 1
        return self.wide

    def errors_at(self, time: arb, readings: arb_mat | None) -> Errors:
        """The effect of all errors up to a time, as they are read there.

        The readings (q, n); a bound of what all others may be off, in norm; the answers and carried
        matrices (cells, q, n), their slack (cells,); and what the state at the start has become (q,
        n).
        """
        number = self.number(time)
        element = self.elements[number]
        front = self.front_at(number)
        since = time - element.stretch.begin
        now = upper(since)
        cells = element.until(now)
        matrix = element.stretch.fundamental(since)
        read, unread = doubles(matrix if readings is None else readings * matrix)
        if readings is None:
            own = np.eye(matrix.nrows())
        else:
            own = doubles(readings)[0]
        inverses = np.array([cell.inverse for cell in cells])
        fresh = read @ inverses
        first = read @ element.origin.inverse
        # What the product read @ X of doubles may be off, for X of a cell and for that of the
        # begin.
        rows = max(1, read.shape[0])
        off = unread * rows + ROUNDING * float(self.size.read(read))
        lost_here = off * float(self.size(inverses).max())
        lost_before = (
            off * float(self.size(element.origin.inverse))
            + float(self.size.read(first)) * element.origin.slack
        ) * front.largest
        lost_on_the_way = float((self.size.read(first @ front.after) * front.weight).sum())
        answers = np.concatenate([first @ front.answers, self.felt(element, fresh)])
        carried = np.concatenate([first @ front.carried, fresh])
        slack = np.concatenate([front.slack, self.slack(element, cells)])
        return (
            own,
            lost_here + lost_before + lost_on_the_way,
            answers,
            carried,
            slack,
            first @ front.whole,
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
        """The element of the next stretch."""
        if self.elements:
            last = self.elements[-1]
            assert last.end is not None
            last.cover(last.end)
            self.step = last.step
        stretch = next(self.coming, None)
        if stretch is None:
            raise UnsharpError("the motion is not known so far")
        return Element(stretch, self.size, self.step)

    def front_at(self, number: int) -> Front:
        """All errors made before an element, at its begin."""
        if self.front is None or self.front.count > number:
            self.front = self.nothing(len(self.elements[0].origin.inverse))
        while self.front.count < number:
            self.front = self.passed(self.front, self.elements[self.front.count])
        return self.front

    def nothing(self, count: int) -> Front:
        """The state of the computation before any error was made."""
        none = np.zeros((0, count, count))
        return Front(none, self.chosen(none), np.zeros(0), none, np.zeros(0), np.eye(count), 1.0)

    def passed(self, front: Front, element: Element) -> Front:
        """The errors made before an element and in it, after its end."""
        assert element.end is not None
        element.cover(element.end)
        hands, unsure = doubles(element.stretch.handover())
        inverses = np.array([cell.inverse for cell in element.cells])
        whole = hands @ element.origin.inverse
        fresh = hands @ inverses
        off = unsure * len(hands) + ROUNDING * float(self.size(hands))
        # |P - Q|: the doubles of the handover, and those of M(0)^-1.
        wrong = off * float(self.size(element.origin.inverse)) + float(self.size(whole)) * (
            element.origin.slack + 4 * ROUNDING
        )
        weight = wrong * front.largest + off * float(self.size(inverses).max())
        after = np.concatenate([whole @ front.after, np.eye(len(whole))[None]])
        answers = np.concatenate([whole @ front.answers, self.felt(element, fresh)])
        carried = np.concatenate([whole @ front.carried, fresh])
        slack = np.concatenate([front.slack, self.slack(element, element.cells)])
        weights = np.concatenate([front.weight, [weight]])
        sizes = self.size(answers) + self.size(carried) * slack
        largest = float(sizes.max()) + float((self.size(after) * weights).sum())
        return Front(
            carried,
            answers,
            slack,
            after,
            weights,
            whole @ front.whole,
            bounded(largest),
            front.count + 1,
        )

    def slack(self, element: Element, cells: Sequence[Cell]) -> Array:
        """What widens the answers of cells: their slack times the norm of what errors undergo at
        once.
        """
        found = np.array([cell.slack for cell in cells])
        if element.stretch.felt is None:
            return found
        return found * float(self.size(doubles(element.stretch.felt)[0])) * UPWARDS

    def felt(self, element: Element, carried: Array) -> Array:
        """The same matrices (cells, q, n) for errors as they are made."""
        if element.stretch.felt is None:
            return self.chosen(carried)
        return self.chosen(carried @ doubles(element.stretch.felt)[0])

    def chosen(self, carried: Array) -> Array:
        """The same with nothing in the coordinates in which no errors are made."""
        if self.made is None:
            return carried
        found = np.zeros_like(carried)
        found[..., list(self.made)] = carried[..., list(self.made)]
        return found


class PeriodicGrowth:
    """S along a motion of one period P on whose tori errors drift apart in proportion to time: D(P)
    = 1 + N with N N = 0.

    So it is for one degree of freedom and for Kepler's ellipses, where the period depends on the
    energy alone: N = -P'(E) f grad E, and grad E . f = 0. With t = tau + k P and an error made at
    sigma in an earlier period D(t) D(s)^-1 = D(tau) (1 + n N) A, A being the growth from sigma to
    the end of its period and 0 <= n < k. A norm is convex in n: it is largest for n = 0 or n = k -
    1.
    """

    def __init__(self, first: Growth, period: arb) -> None:
        self.first = first
        self.period = period
        self.year: Errors | None = None
        self.wide_year: Wide | None = None

    def at(self, t: Fraction) -> float:
        """The bound S(t) >= 1 on the growth of an error."""
        time = arb_of(t)
        turns = int(ball_of(time / self.period).mid)
        if turns == 0:
            return self.first.at(t)
        since = time - turns * self.period
        if not since >= 0:
            # Balls do not tell whether the period is over: all that is within them is meant.
            since = arb(0).union(arb(since.abs_upper()))
        if self.first.readings is None:
            readings = None
        else:
            readings = self.first.readings(time)
        found = self.first.read(since, readings)
        earlier, lost = self.of_earlier(since, readings, turns)
        if lost > LOST * max(found, earlier):
            return bounded(max(found, self.of_earlier_wide(since, readings, turns)))
        return bounded(max(found, earlier + lost))

    def of_earlier(self, since: arb, readings: arb_mat | None, turns: int) -> tuple[float, float]:
        """The growth of errors made in earlier periods by products of doubles, and what those have
        lost at most.
        """
        growth = self.first
        size = self.first.size
        if self.year is None:
            self.year = growth.errors_at(self.period, None)
        _, lost, answers, carried, slack, whole = self.year
        _, lost_now, _, _, _, now = growth.errors_at(since, readings)
        largest = bounded(float((size(answers) + size(carried) * slack).max()) + lost)
        drift = whole - np.eye(len(whole))
        found = 0.0
        most = 0.0
        for n in {0, turns - 1}:
            later = now @ (np.eye(len(whole)) + n * drift)
            sizes = size.read(later @ answers) + size.read(later @ carried) * slack
            # What D(tau) (1 + n N) may be off, times S; and what the growth up to the end of the
            # period may be off.
            wrong = lost_now * (1 + n * float(size(drift))) + float(size.read(now)) * n * lost
            wrong += ROUNDING * float(size.read(now)) * (1 + n * float(size(drift)))
            found = max(found, float(sizes.max()))
            most = max(most, wrong * largest + float(size.read(later)) * lost)
        return found, most

    def of_earlier_wide(self, since: arb, readings: arb_mat | None, turns: int) -> float:
        """The same by products of balls."""
        growth = self.first
        if self.wide_year is None:
            self.wide_year = growth.wide_at(self.period, None)
        year = self.wide_year
        now = growth.wide_at(since, readings).whole
        count = year.whole.nrows()
        one = arb_mat(count, count, [int(i == j) for i in range(count) for j in range(count)])
        drift = year.whole - one
        return max(
            growth.largest(now * (one + n * drift) * year.answers, year.slack)
            for n in {0, turns - 1}
        )


class SteadyGrowth:
    """S of a motion whose errors obey a linear equation with constant coefficients: they grow by
    the time elapsed alone.

    `propagator` gives exp(J tau). S(t) is its largest norm up to t. Once it has a norm of at most 1
    at some `repeat` > 0 nothing later exceeds what was there before it: |exp(J (repeat + tau))| <=
    |exp(J tau)|.
    """

    def __init__(
        self, propagator: Fundamental, size: Norm, step: Fraction, repeat: arb | None = None
    ) -> None:
        self.propagator = propagator
        self.size = size
        self.step = step
        self.repeat = repeat
        self.highs: list[Fraction] = [Fraction(0)]
        self.norms: list[float] = [1.0]

    def at(self, t: Fraction) -> float:
        """The bound S(t) >= 1 on the growth of an error."""
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
        """The next cell of times elapsed, on which the bound of the norm is at most an eighth above
        the norm in its middle.
        """
        low = self.highs[-1]
        for _ in range(HALVINGS):
            high = low + self.step
            found = self.norm(arb_of(low).union(arb_of(high)))
            middle = self.norm(arb_of((low + high) / 2))
            if found <= (1 + WIDEST) * max(1.0, middle):
                self.highs.append(high)
                self.norms.append(found)
                if found <= (1 + WIDEST / 3) * max(1.0, middle):
                    self.step *= 2
                return
            self.step /= 2
        raise UnsharpError("how errors grow is not known well enough at this precision")

    def norm(self, elapsed: arb) -> float:
        """The largest norm on a ball of times elapsed."""
        table = self.propagator(elapsed).table()
        if not all(entry.is_finite() for row in table for entry in row):
            return inf
        return float(
            self.size.read(np.array([[float(entry.abs_upper()) for entry in row] for row in table]))
        )


@dataclass(frozen=True)
class Told:
    """S by a formula: a ball that holds the supremum, or what is not below it."""

    formula: Callable[[arb], arb]

    def at(self, t: Fraction) -> float:
        """The bound S(t) >= 1 on the growth of an error."""
        return bounded(float(self.formula(arb_of(t)).upper()))


@dataclass(frozen=True)
class Retimed:
    """S of a motion that is told in a clock of its own, with this unit [s]."""

    first: Grows
    unit: Fraction

    def at(self, t: Fraction) -> float:
        """The bound S(t) >= 1 on the growth of an error."""
        return self.first.at(t / self.unit)


@dataclass(frozen=True)
class Times:
    """S of a motion whose errors are larger by a factor than those of another."""

    first: Grows
    factor: arb

    def at(self, t: Fraction) -> float:
        """The bound S(t) >= 1 on the growth of an error."""
        return bounded(self.first.at(t) * float(upper(self.factor)))


def narrow(rate: arb) -> Fraction:
    """A power of two [s] to begin with as the width of a cell, well below 1/rate, for a rate [1/s]
    at which errors change.
    """
    size = float(rate.abs_upper())
    if size > 0:
        return Fraction(2) ** (-4 - frexp(size)[1])
    return Fraction(1, 8)


def most(values: Iterable[arb]) -> float:
    """The largest that any of the balls may be; infinite where one is not finite: Python's max
    passes nan over.
    """
    found = 0.0
    for value in values:
        if not value.is_finite():
            return inf
        found = max(found, float(value.upper()))
    return found


def doubles(matrix: arb_mat) -> tuple[Array, float]:
    """The midpoints as doubles, and the largest that an entry may be off, rounded up.

    UndecidedError if an entry is not finite.
    """
    table = matrix.table()
    found = np.array([[float(entry.mid()) for entry in row] for row in table])
    off = max((float(entry.rad()) for row in table for entry in row), default=0.0)
    if not (np.isfinite(found).all() and isfinite(off)):
        raise UnsharpError("how errors grow is not known at this precision")
    return found, (off + 2.0**-52 * float(np.abs(found).max(initial=0.0))) * max(1, found.shape[1])


def known(value: arb, size: float = 0.0) -> float:
    """The double of a ball that is known to KNOWN of itself, or of `size`.

    UnsharpError if it is not.
    """
    middle = value.mid()
    if not (value.is_finite() and value.rad() <= KNOWN * arb.max(abs(middle), arb(size))):
        raise UnsharpError("the motion is not known well enough at this precision")
    return float(middle)


def rounded(values: Sequence[arb]) -> tuple[Array, float]:
    """Midpoints as doubles, and the largest radius; UnsharpError if one is not finite."""
    if not all(value.is_finite() for value in values):
        raise UnsharpError("the motion is not known at this precision")
    radii = max(float(value.rad()) for value in values)
    return np.array([float(value.mid()) for value in values]), radii


def beside(matrices: Sequence[arb_mat]) -> arb_mat:
    """Matrices of the same number of rows side by side."""
    tables = [matrix.table() for matrix in matrices]
    return arb_mat(
        [[entry for table in tables for entry in table[i]] for i in range(len(tables[0]))]
    )


def split(matrix: arb_mat, count: int) -> tuple[Array, Array]:
    """Midpoints and radii of so many matrices that stand side by side, (count, rows, columns) each.

    UnsharpError if not finite.
    """
    table = matrix.table()
    middles = np.array([[float(entry.mid()) for entry in row] for row in table])
    radii = np.array([[float(entry.rad()) for entry in row] for row in table])
    if not (np.isfinite(middles).all() and np.isfinite(radii).all()):
        raise UnsharpError("how errors grow is not known at this precision")
    shape = (matrix.nrows(), count, matrix.ncols() // count)
    return middles.reshape(shape).swapaxes(0, 1), radii.reshape(shape).swapaxes(0, 1)


def inverted(matrix: arb_mat) -> arb_mat:
    """The inverse in balls; UnsharpError where they hold a matrix that has none."""
    try:
        return matrix.inv()
    except ZeroDivisionError:
        raise UnsharpError("a matrix of solutions that is not regular") from None


def fine_inverse(matrix: arb_mat) -> arb_mat:
    """An exact matrix near the inverse."""
    return inverted(matrix).mid()


def exactly(matrix: Array) -> arb_mat:
    """The same matrix of doubles."""
    return arb_mat(len(matrix), matrix.shape[1], [float(x) for x in matrix.flatten()])


def bounded(value: float) -> float:
    """An S rounded up: at least 1, and BOUNDLESS where it is no longer told."""
    if not value < BOUNDLESS:
        return BOUNDLESS
    if value > 1.0:
        return max(1.0, value) * UPWARDS
    return 1.0


def upper(value: arb) -> Fraction:
    """A rational that the ball does not exceed."""
    ball = ball_of(value)
    return ball.mid + ball.radius
