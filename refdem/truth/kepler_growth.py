"""S(t) in a central field r'' = G(r) along a motion of one period, by branch and bound over the
times at which errors are made.

With M any matrix of solutions of the variational equation, an error made at s has at t the answers
y(s) = M(t) M(s)^-1, row by row (y_r, y_v), and y_r' = -y_v dG, y_v' = -y_r with the time s.

Theorem (cell): let |dG| <= w^2 in the norm of the largest sum of a row for all s of a cell, at most
h from c. In the sums of absolute values p of y_r(c) and q of y_v(c),

    |y_r(s) - y_r(c)| <= p (cosh w h - 1) + q w sinh w h,
    |y_v(s) - y_v(c)| <= q (cosh w h - 1) + p sinh(w h)/w,

as both differences are solutions of inequalities whose equalities these are; dG is symmetric. This
is in the units of the place: near a centre w is the rate at which the body passes it.

Theorem (all times): D(P) = 1 + N with N N = 0 (growth.py, PeriodicGrowth). So the answers to an
error of an earlier period are linear in the number of periods between, and largest for the fewest
or the most.

Hypotheses, and where each is checked:

* M is regular: `inverted` raises UnsharpError where balls hold a matrix without an inverse;
* |dG| <= w^2 on the whole cell: `gradient` is evaluated on a ball of all its times (`moment`);
* w h is small enough for a useful bound: `change` is infinite beyond FARTHEST, and the cell is then
  halved;
* the cells cover all times at which errors are made: `spans`, up to `end`, whose ball's upper end
  is taken.
"""

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from math import inf, sinh

from flint import arb, arb_mat

from refdem.truth.balls import arb_of, ball_of
from refdem.truth.growth import UPWARDS, inverted, upper
from refdem.truth.swept_growth import Span, largest_growth

FARTHEST = 50.0
"""The w h of a cell beyond which no bound is computed: it would be e^50 of what is there."""
PLACE = slice(0, 2)
SPEED = slice(2, 4)
"""The columns of answers to errors of the position and of the velocity: y_r and y_v."""


@dataclass(frozen=True)
class Moment:
    """The numbers of a cell that do not depend on the time of reading: M(c)^-1 (`inverse`), w
    (`rate`) [1/s] and h (`half`) [s].
    """

    inverse: arb_mat
    rate: float
    half: float


class CentralGrowth:
    """S of (x, y, vx, vy) in a central field, in scales of a position and of a velocity."""

    def __init__(
        self,
        fundamental: Callable[[arb], arb_mat],
        gradient: Callable[[arb], float],
        period: arb,
        ratio: float,
    ) -> None:
        """Takes M in scales (`fundamental`), a bound of |dG| [1/s^2] on a ball of times
        (`gradient`), the period [s], and the `ratio` [s] of the scales of position and velocity.
        """
        self.fundamental = fundamental
        self.gradient = gradient
        self.period = period
        self.ratio = ratio
        self.moments: dict[tuple[Fraction, Fraction], Moment] = {}

    def at(self, t: Fraction) -> float:
        """The bound S(t) >= 1 on the growth of an error."""
        time = arb_of(t)
        turns = int(ball_of(time / self.period).mid)
        since = time - turns * self.period
        # If it is not decided whether the period is over, some errors may be made just after t.
        spans = self.spans(max(upper(since), Fraction(0)), since)
        if turns:
            # Errors of earlier periods grow most over the fewest or the most periods between.
            whole = upper(self.period)
            for periods in {1, turns}:
                spans += self.spans(whole, since + periods * self.period)
        return largest_growth(spans)

    def spans(self, end: Fraction, now: arb) -> list[Span]:
        """The spans of times up to `end` at which errors are made that are read at the time `now`;
        both are counted from the same periapsis.

        Spans are halves of the period, halves of those that are left, and so on: the same ones for
        all times, so that `moment` is computed once for each.
        """
        matrix = self.fundamental(now)
        answers = partial(self.answers, matrix)
        whole = upper(self.period)
        spans = []
        low = Fraction(0)
        width = whole
        while low < end and width > whole / 2**40:
            if low + width <= end:
                spans.append(Span(low, low + width, answers))
                low += width
            width /= 2
        if low < end:
            spans.append(Span(low, end, answers))
        return spans

    def answers(
        self, matrix: arb_mat, middle: Fraction, half: Fraction
    ) -> tuple[list[arb], list[arb]]:
        """The answer of each quantity to errors of one scale in all coordinates, made at `middle`,
        and a bound of it for those made at most `half` from there.

        `matrix` is M(t) at the time of reading: the answers are the rows of M(t) M(s)^-1.
        """
        moment = self.moment(middle, half)
        at_middle = []
        bounds = []
        for row in (matrix * moment.inverse).table():
            # p and q of the theorem on cells.
            place = sum((abs(entry) for entry in row[PLACE]), arb(0))
            speed = sum((abs(entry) for entry in row[SPEED]), arb(0))
            at_middle.append(place + speed)
            bounds.append(place + speed + self.change(moment, place, speed))
        return at_middle, bounds

    def change(self, moment: Moment, place: arb, speed: arb) -> arb:
        """The amount by which |y_r| + |y_v| may be larger elsewhere in the cell than p + q at its
        middle (theorem on cells); `place` is p, `speed` q.
        """
        angle = moment.rate * moment.half
        if not angle < FARTHEST:
            return arb(inf)
        # With p and q in the scales X of positions and V of velocities the theorem on cells has
        # w X/V in the place of w, but for w h.
        rate = moment.rate * self.ratio
        # cosh(w h) - 1 = 2 sinh^2(w h/2), without its cancellation.
        cosh_less_1 = 2 * sinh(angle / 2) ** 2 * UPWARDS
        sinh_angle = sinh(angle) * UPWARDS
        # p (cosh w h - 1) + q w sinh w h, and q (cosh w h - 1) + p sinh(w h)/w.
        place_change = place * cosh_less_1 + speed * rate * sinh_angle
        speed_change = speed * cosh_less_1 + place * (sinh_angle / rate)
        return (place_change + speed_change) * UPWARDS

    def moment(self, middle: Fraction, half: Fraction) -> Moment:
        """The numbers of the cell middle +- half [s]; kept for later calls."""
        if (middle, half) not in self.moments:
            # w^2 bounds |dG| at all times of the cell.
            times = arb_of(middle - half).union(arb_of(middle + half))
            rate = self.gradient(times) ** 0.5 * UPWARDS
            inverse = inverted(self.fundamental(arb_of(middle)))
            self.moments[middle, half] = Moment(inverse, rate, float(half) * UPWARDS)
        return self.moments[middle, half]
