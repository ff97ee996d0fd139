"""Proofs that a switching function is positive along a piece, or where it is first zero: bisection
and interval Newton.

Theorem: let G(I) and D(I) enclose the function and its derivative in time, for every motion of the
set and all times of an interval I = [a, b]. If G(I) > 0, or G(a) > 0 and D(I) > 0, the function is
positive on I. If D(I) < 0, G(a) > 0 and G(b) < 0, it has exactly one zero in I for each motion, and
for any m in I all these zeros lie in m - G(m)/D(I) (interval Newton).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Self

from flint import arb

from refdem.truth.balls import UndecidedError
from refdem.truth.dual import ball, carried, slopes_of

Along = Callable[[arb], arb]
SPLIT = 63
"""The place, in 128ths, at which an interval is split: not its middle, where zeros of simple
motions lie.
"""
LEAST = 2.0**-100
"""The least part of a window that is still split. An interval that is shorter and not decided holds
a grazing contact, or has a zero so close to its end that only more digits separate them.
"""


FINAL = ("end", "singular", "time")
"""The codes of ends that do not depend on the number of bits."""


class SwitchError(UndecidedError):
    """A motion cannot be followed through a switch at this precision.

    `code` is the kind of end (errors.py), `since` [s] its approximate time in the piece. `state`
    has balls of the last certified state (its clock last); `final` is True where more digits would
    seldom help.
    """

    def __init__(self, code: str, message: str, since: float) -> None:
        super().__init__(message, code=code, final=code in FINAL)
        self.since = since
        self.state: list[arb] = []

    def at(self, state: Sequence[arb], *, thin: bool = False) -> Self:
        """The same error with the last certified state; where the set is `thin` there, the codes of
        a boundary (grazing, corner, separatrix) are final.
        """
        self.state = list(state)
        self.final = self.final or (thin and self.code in ("grazing", "corner", "separatrix"))
        return self


@dataclass(frozen=True)
class Watched:
    """One switching function along a piece, for every motion of the set.

    `rates[n]` gives a ball of its n-th derivative in time over a ball of times since the piece's
    begin. `touching` is the order of a zero at the start of the piece, 0 for none.
    """

    name: str
    rates: list[Along]
    touching: int = 0

    @property
    def value(self) -> Along:
        """The function itself: G of the theorem."""
        return self.rates[0]

    @property
    def rate(self) -> Along:
        """The first derivative of the function: D of the theorem."""
        return self.rates[1]


def first_crossing(watched: Watched, low: arb, high: arb) -> arb | None:
    """A ball of the times in (low, high] at which each motion of the set first has a zero; None if
    it is proved that none has any.

    Bisection, in order of time, until the sign of the function or of its rate decides each interval
    (theorem of the module). SwitchError where an interval stays undecided.
    """
    if not watched.touching and not watched.value(low) > 0:
        raise SwitchError(
            "corner", f"{watched.name} is not proved positive where it begins", float(low)
        )
    # The order n of the zero at the start, 0 once the value has left it. With G = G' = ... =
    # G^(n-1) = 0 at `begin` and G^(n) > 0 on the interval, G > 0 after `begin` (Taylor).
    order = watched.touching
    # Invariant: from `low` to the start of the interval that is popped next, the value is proved
    # positive, but for the zero at `low`.
    waiting = [(low, high)]
    least = (high - low) * LEAST
    while waiting:
        begin, end = waiting.pop()
        interval = begin.union(end)
        if watched.rates[order](interval) > 0 and (not order or touches(watched, begin)):
            order = 0
            continue
        if not order:
            # G > 0 at `begin`: G > 0 on the interval if D > 0, or if D < 0 and G > 0 at `end`.
            rate = watched.rate(interval)
            if rate > 0 or (rate < 0 and watched.value(end) > 0):
                continue
            if rate < 0 and watched.value(end) < 0:
                return only_zero(watched, begin, end)
        middle = (begin + (end - begin) * SPLIT / 128).mid()
        if not end - begin > least or not begin < middle < end:
            raise undecided(watched, begin, end)
        # The earlier half is popped first.
        waiting += [(middle, end), (begin, middle)]
    return None


def touches(watched: Watched, begin: arb) -> bool:
    """True, after a check that the ball of every derivative that an entry declares to be 0 holds 0.

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
    """A ball of the zeros in [low, high], where the rate is negative, by interval Newton.

    I -> (m - G(m)/D(I)) n I with the midpoint m, until it shrinks by less than half.
    """
    interval = low.union(high)
    while True:
        middle = interval.mid()
        # m - G(m)/D(I).
        newton = middle - watched.value(middle) / watched.rate(interval)
        closer = newton.intersection(interval)
        if not closer.rad() < interval.rad() / 2:
            return closer
        interval = closer


def undecided(watched: Watched, low: arb, high: arb) -> SwitchError:
    """The error for an interval on which neither a sign nor a crossing is proved: the rate may
    vanish (grazing), or more digits are needed.
    """
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
    """The name of the guard that is first zero in (low, high] and a ball of when it is.

    None if no guard vanishes. SwitchError where two may vanish at the same time.
    """
    first: tuple[str, arb] | None = None
    for watched in guards:
        if first is None:
            crossing = first_crossing(watched, low, high)
        else:
            crossing = crossing_before(watched, low, first)
        if crossing is None:
            continue
        if first and not crossing < first[1]:
            raise SwitchError(
                "corner", f"{first[0]} and {watched.name} may come together", float(crossing.mid())
            )
        first = watched.name, crossing
    return first


def carried_crossing(guards: list[Watched], low: arb, high: arb) -> tuple[str, arb] | None:
    """The crossing that `earliest` finds, of guards that may carry derivatives by parameters.

    G(x, p) = 0 gives dx/dp = -(dG/dp at a fixed x)/G'(x), for each parameter p.
    """
    found = earliest([undirected(watched) for watched in guards], ball(low), ball(high))
    if found is None:
        return None
    name, x = found
    (crossed,) = [watched for watched in guards if watched.name == name]
    value = crossed.value(x)
    if not slopes_of(value):
        return found
    # dx/dp = -(dG/dp)/G'(x).
    return name, carried(x, (-1 / ball(crossed.rate(x)), value))


def undirected(watched: Watched) -> Watched:
    """The same function without the derivatives that it carries."""

    def without(rate: Along) -> Along:
        return lambda x: ball(rate(x))

    return replace(watched, rates=[without(rate) for rate in watched.rates])


def crossing_before(watched: Watched, low: arb, other: tuple[str, arb]) -> arb | None:
    """The first crossing up to that of the `other` guard, given by name and time; None if there is
    none.

    A zero that cannot be separated from that of the other one is a corner.
    """
    name, when = other
    try:
        return first_crossing(watched, low, arb(when.upper()))
    except SwitchError as error:
        if error.code != "precision":
            raise
        raise SwitchError(
            "corner", f"{name} and {watched.name} may come together", error.since
        ) from None


def sign(value: arb, what: str) -> int:
    """The sign of a ball: -1, 0 (an exact 0 only) or 1; `what` names it in the message.

    SwitchError (a corner) where the ball holds zero and other numbers.
    """
    if value > 0 or value < 0 or value == 0:
        return int(bool(value > 0)) - int(bool(value < 0))
    raise SwitchError("corner", f"the sign of {what} is not decided: {value.str(5)}", 0.0)
