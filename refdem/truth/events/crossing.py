"""Where a switching function is proved positive along a piece, and where it is first zero:
bisection and interval Newton.

Theorem: let G(I) and D(I) hold the function and its rate for every motion of the set over the times
I. If G(I) > 0, or D(I) > 0 after a positive value, it is positive on I. If D(I) < 0, positive
before and negative after, each motion has exactly one zero in I, and with any m in I all zeros lie
in m - G(m)/D(I) (interval Newton).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Self

from flint import arb

from refdem.truth.balls import UndecidedError

Along = Callable[[arb], arb]
SPLIT = 63
"""In 128ths: intervals are not split in their middle, where zeros of simple motions lie."""
LEAST = 2.0**-100
"""Of a window: what is not decided on less is grazing, or a zero at an end that more digits tell
apart.
"""


FINAL = ("end", "singular", "time")
"""Ends that more bits do not move."""


class SwitchError(UndecidedError):
    """Balls cannot follow a switch; `code` is that of an end (errors.py), `since` about when [s] in
    the piece.

    `state` has balls of the last certified state (its clock last); `final`: more digits would
    seldom help.
    """

    def __init__(self, code: str, message: str, since: float) -> None:
        super().__init__(message, code=code, final=code in FINAL)
        self.since = since
        self.state: list[arb] = []

    def at(self, state: Sequence[arb], *, thin: bool = False) -> Self:
        """The same error with the last certified state, and whether the set is thin there."""
        self.state = list(state)
        self.final = self.final or (thin and self.code in ("grazing", "corner", "separatrix"))
        return self


@dataclass(frozen=True)
class Watched:
    """One switching function along a piece: balls of it and of its rates for every motion of the
    set, over any ball of times.

    `touching` is the order of a zero at the begin of the piece, 0 for none.
    """

    name: str
    rates: list[Along]
    touching: int = 0

    @property
    def value(self) -> Along:
        return self.rates[0]

    @property
    def rate(self) -> Along:
        return self.rates[1]


def first_crossing(watched: Watched, low: arb, high: arb) -> arb | None:
    """A ball of the times in (low, high] at which each motion of the set first has a zero.

    None if it is proved that none has any.
    """
    if not watched.touching and not watched.value(low) > 0:
        raise SwitchError(
            "corner", f"{watched.name} is not proved positive where it begins", float(low)
        )
    # The order of the derivative that decides until the value has left the zero at the begin.
    # Whatever is popped, the value is proved positive from `low` to there, but for that zero.
    fresh = watched.touching
    waiting = [(low, high)]
    least = (high - low) * LEAST
    while waiting:
        a, b = waiting.pop()
        interval = a.union(b)
        if watched.rates[fresh](interval) > 0 and (not fresh or touches(watched, a)):
            fresh = 0
            continue
        if not fresh:
            rate = watched.rate(interval)
            if rate > 0 or (rate < 0 and watched.value(b) > 0):
                continue
            if rate < 0 and watched.value(b) < 0:
                return only_zero(watched, a, b)
        middle = (a + (b - a) * SPLIT / 128).mid()
        if not b - a > least or not a < middle < b:
            raise undecided(watched, a, b)
        # The earlier half is popped first.
        waiting += [(middle, b), (a, middle)]
    return None


def touches(watched: Watched, begin: arb) -> bool:
    """The derivatives that an entry says vanish may do so: their balls hold 0.

    ValueError if one does not.
    """
    for order in range(watched.touching):
        if not watched.rates[order](begin).contains(0):
            raise ValueError(
                f"derivative {order} of {watched.name} is {watched.rates[order](begin)} at an entry"
                " that says it is 0"
            )
    return True


def only_zero(watched: Watched, low: arb, high: arb) -> arb:
    """A ball of the zeros in [low, high], where the rate is negative: interval Newton until it
    shrinks no more.
    """
    interval = low.union(high)
    while True:
        middle = interval.mid()
        closer = (middle - watched.value(middle) / watched.rate(interval)).intersection(interval)
        if not closer.rad() < interval.rad() / 2:
            return closer
        interval = closer


def undecided(watched: Watched, low: arb, high: arb) -> SwitchError:
    """Why neither a sign nor a crossing is proved on what is left."""
    middle = float(low.union(high).mid())
    if watched.rate(low.union(high)).contains(0):
        return SwitchError(
            "grazing",
            f"{watched.name} comes too close to zero without crossing it, or touches it",
            middle,
        )
    return SwitchError(
        "precision", f"a zero of {watched.name} lies too near the end of a stretch", middle
    )


def earliest(guards: list[Watched], low: arb, high: arb) -> tuple[str, arb] | None:
    """The guard that is first zero in (low, high] and a ball of when.

    None if none is. SwitchError where two may come together.
    """
    found: tuple[str, arb] | None = None
    for watched in guards:
        if found is None:
            crossing = first_crossing(watched, low, high)
        else:
            crossing = crossing_before(watched, low, found)
        if crossing is None:
            continue
        if found and not crossing < found[1]:
            raise SwitchError(
                "corner", f"{found[0]} and {watched.name} may come together", float(crossing.mid())
            )
        found = watched.name, crossing
    return found


def crossing_before(watched: Watched, low: arb, found: tuple[str, arb]) -> arb | None:
    """The first crossing up to that of another guard; a zero too near that one is a corner."""
    try:
        return first_crossing(watched, low, arb(found[1].upper()))
    except SwitchError as error:
        if error.code != "precision":
            raise
        raise SwitchError(
            "corner", f"{found[0]} and {watched.name} may come together", error.since
        ) from None


def sign(value: arb, what: str) -> int:
    """The sign of a ball: -1, 0 (an exact 0 only) or 1.

    UndecidedError (a corner) where the ball holds zero and more.
    """
    if value > 0 or value < 0 or value == 0:
        return int(bool(value > 0)) - int(bool(value < 0))
    raise SwitchError("corner", f"the sign of {what} is not decided: {value.str(5)}", 0.0)
