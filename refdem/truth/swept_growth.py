"""S(t) where the growth of an error is known in balls for whole cells of times at which it is made:
the supremum, by branch and bound.

The cell whose bound is the largest is halved until that bound is at most WIDEST larger than the
growth at the middle of some cell: every error of every cell grows by no more than the largest
bound, and some error grows by nearly as much.

Hypotheses, and where each is checked:

* the spans cover all times up to t at which errors are made: whoever makes them (kepler_growth.py,
  contact_path.py); halves cover what they halve (`Span.halves`);
* what `answers` calls a bound holds for every error of the span: proved there;
* the bound that is told is sharp: `largest_growth` stops only within WIDEST of a growth that is
  seen, and raises UnsharpError after MOST_CELLS.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from heapq import heappop, heappush

from flint import arb

from refdem.truth.growth import UPWARDS, WIDEST, UnsharpError, bounded, most

Swept = Callable[[Fraction, Fraction], tuple[Sequence[arb], Sequence[arb]]]
"""What every quantity answers to an error of one scale in each coordinate, made at a `middle` [s],
and what it answers at most to one that is made at most `half` from there.
"""
MOST_CELLS = 4096
"""More say that balls are too wide."""


@dataclass(frozen=True)
class Span:
    """Times [low, high] at which an error is made, and what it becomes."""

    low: Fraction
    high: Fraction
    answers: Swept

    @property
    def middle(self) -> Fraction:
        """Where its growth is looked at."""
        return (self.low + self.high) / 2

    def growth(self) -> tuple[float, float]:
        """The growth of an error at the middle, at least, and that of any error of the span, at
        most.
        """
        seen, bounds = self.answers(self.middle, (self.high - self.low) / 2)
        least = max(float(answer.lower()) for answer in seen)
        return least, most(bounds) * UPWARDS

    def halves(self) -> list["Span"]:
        """The two halves of the span, in order."""
        return [
            Span(self.low, self.middle, self.answers),
            Span(self.middle, self.high, self.answers),
        ]


def largest_growth(spans: Sequence[Span]) -> float:
    """A bound of the growth of all errors of the spans, at most WIDEST above the supremum, and at
    least 1.
    """
    waiting: list[tuple[float, int, Span]] = []
    count = 0
    seen = 1.0
    fresh = list(spans)
    while count < MOST_CELLS:
        for span in fresh:
            least, bound = span.growth()
            seen = max(seen, least)
            heappush(waiting, (-bound, count, span))
            count += 1
        if not waiting:
            return seen
        found, _, widest = heappop(waiting)
        if -found <= (1 + WIDEST) * seen:
            return bounded(-found)
        fresh = widest.halves()
    raise UnsharpError("how errors grow is not known well enough at this precision")
