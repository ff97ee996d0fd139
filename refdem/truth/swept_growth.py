"""S(t) where the growth of an error is known in balls for whole cells of times at which it is made:
the supremum, by branch and bound.

The cell whose bound is the largest is halved until that bound is at most WIDEST larger than the
growth at the middle of some cell: every error of every cell grows by no more than the largest
bound, and some error grows by nearly as much.

Hypotheses, and where each is checked:

* the spans cover all times up to t at which errors are made: whoever makes them (kepler_growth.py,
  contact_path.py); halves cover what they halve (`Span.halves`);
* what `answers` calls a bound holds for every error of the span: proved there;
* the bound is sharp: `largest_growth` stops only within WIDEST of a growth that is attained, and
  raises UnsharpError after MOST_CELLS.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from heapq import heappop, heappush

from flint import arb

from refdem.truth.growth import UPWARDS, WIDEST, UnsharpError, bounded, most

Swept = Callable[[Fraction, Fraction], tuple[Sequence[arb], Sequence[arb]]]
"""From `middle` [s] and `half` [s]: the answer of every quantity to an error of one scale in each
coordinate that is made at `middle`, and a bound of it for those made at most `half` from there.
"""
MOST_CELLS = 4096
"""The most cells of a search; if more are needed the balls are too wide."""


@dataclass(frozen=True)
class Span:
    """An interval [low, high] of times [s] at which errors are made, and the `answers` to them."""

    low: Fraction
    high: Fraction
    answers: Swept

    @property
    def middle(self) -> Fraction:
        """The time [s] at which the growth is evaluated."""
        return (self.low + self.high) / 2

    def growth(self) -> tuple[float, float]:
        """A lower bound of the growth of an error made at the middle, and an upper bound of that of
        every error of the span.
        """
        at_middle, bounds = self.answers(self.middle, (self.high - self.low) / 2)
        least = max(float(answer.lower()) for answer in at_middle)
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
    # A heap with the largest bound first (as -bound); `count` orders equal ones.
    waiting: list[tuple[float, int, Span]] = []
    count = 0
    # The largest growth that is proved to happen.
    attained = 1.0
    fresh = list(spans)
    while count < MOST_CELLS:
        for span in fresh:
            least, bound = span.growth()
            attained = max(attained, least)
            heappush(waiting, (-bound, count, span))
            count += 1
        if not waiting:
            return attained
        minus_largest, _, span_of_largest = heappop(waiting)
        # attained <= S <= largest bound <= (1 + WIDEST) attained
        if -minus_largest <= (1 + WIDEST) * attained:
            return bounded(-minus_largest)
        fresh = span_of_largest.halves()
    raise UnsharpError("how errors grow is not known well enough at this precision")
