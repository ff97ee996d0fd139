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
* w h is not too large for a bound of use: `change` says infinity beyond FARTHEST, and the cell is
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
"""w h of a cell for which no bound is asked: e^50 of what is there."""
PLACE = slice(0, 2)
SPEED = slice(2, 4)


@dataclass(frozen=True)
class Moment:
    """What a cell needs whatever is asked: M(c)^-1, w and h."""

    inverse: arb_mat
    rate: float
    half: float


class CentralGrowth:
    """S of (x, y, vx, vy), in scales of a place and of a velocity."""

    def __init__(
        self,
        fundamental: Callable[[arb], arb_mat],
        gradient: Callable[[arb], float],
        period: arb,
        ratio: float,
    ) -> None:
        """Takes M in scales, |dG| [1/s^2] on a ball of times, and the scales' `ratio` [s]."""
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
        # Where balls do not tell whether the period is over, some errors are made just after t.
        spans = self.spans(max(upper(since), Fraction(0)), since)
        if turns:
            whole = upper(self.period)
            for periods in {1, turns}:
                spans += self.spans(whole, since + periods * self.period)
        return largest_growth(spans)

    def spans(self, end: Fraction, now: arb) -> list[Span]:
        """Errors made up to `end`, as they are answered at the time `now`, counted from the same
        periapsis.

        Halves of the period, halves of those that are left, and so on: the same cells for all
        times.
        """
        matrix = self.fundamental(now)
        answers = partial(self.answers, matrix)
        whole = upper(self.period)
        found = []
        low = Fraction(0)
        width = whole
        while low < end and width > whole / 2**40:
            if low + width <= end:
                found.append(Span(low, low + width, answers))
                low += width
            width /= 2
        if low < end:
            found.append(Span(low, end, answers))
        return found

    def answers(
        self, matrix: arb_mat, middle: Fraction, half: Fraction
    ) -> tuple[list[arb], list[arb]]:
        """The answers of each quantity to errors of one scale in all coordinates: those of
        `middle`, and those at most `half` from it.
        """
        moment = self.moment(middle, half)
        seen = []
        bounds = []
        for row in (matrix * moment.inverse).table():
            place = sum((abs(entry) for entry in row[PLACE]), arb(0))
            speed = sum((abs(entry) for entry in row[SPEED]), arb(0))
            seen.append(place + speed)
            bounds.append(place + speed + self.change(moment, place, speed))
        return seen, bounds

    def change(self, moment: Moment, place: arb, speed: arb) -> arb:
        """The amount by which the sum of both may be larger in the cell."""
        angle = moment.rate * moment.half
        if not angle < FARTHEST:
            return arb(inf)
        # In units of time the rows of M^-1 have the ratio of the scales.
        rate = moment.rate * self.ratio
        # cosh - 1 without its cancellation.
        even = 2 * sinh(angle / 2) ** 2 * UPWARDS
        odd = sinh(angle) * UPWARDS
        places = place * even + speed * rate * odd
        speeds = speed * even + place * (odd / rate)
        return (places + speeds) * UPWARDS

    def moment(self, middle: Fraction, half: Fraction) -> Moment:
        """The same for all that is asked."""
        if (middle, half) not in self.moments:
            times = arb_of(middle - half).union(arb_of(middle + half))
            rate = self.gradient(times) ** 0.5 * UPWARDS
            inverse = inverted(self.fundamental(arb_of(middle)))
            self.moments[middle, half] = Moment(inverse, rate, float(half) * UPWARDS)
        return self.moments[middle, half]
