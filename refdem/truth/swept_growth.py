"""S(t) where the growth of an error is known in balls for whole cells of times at which it is made:
the supremum, by branch and bound.

The cell whose bound is the largest is halved until that bound is at most WIDEST larger than the
growth at the middle of some cell: every error of every cell grows by no more than the largest
bound, and some error grows by nearly as much.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from heapq import heappop, heappush

from flint import arb

from refdem.truth.balls import arb_of
from refdem.truth.growth import UPWARDS, WIDEST, UnsharpError, bounded, most

Swept = Callable[[arb, arb], Sequence[arb]]
"""What every quantity answers to an error of one scale in each coordinate, made at any time at most
`off` from `middle` [s].
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

    def bound(self) -> float:
        """No error of the span grows by more."""
        half = arb_of((self.high - self.low) / 2)
        return most(self.answers(arb_of(self.middle), half)) * UPWARDS

    def seen(self) -> float:
        """The growth at the middle, at least."""
        answers = self.answers(arb_of(self.middle), arb(0))
        return max(float(answer.lower()) for answer in answers)

    def halves(self) -> list["Span"]:
        """Both halves."""
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
            seen = max(seen, span.seen())
            heappush(waiting, (-span.bound(), count, span))
            count += 1
        if not waiting:
            return seen
        found, _, widest = heappop(waiting)
        if -found <= (1 + WIDEST) * seen:
            return bounded(-found)
        fresh = widest.halves()
    raise UnsharpError("how errors grow is not known well enough at this precision")
