"""What all closed forms share: precision raised until it suffices, for values and for S(t) alike.

A closed form gives four things: its quantities as balls at the current precision, how its errors
grow, the same motion from a displaced start, and its scalars. All else is here.
"""

from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence
from copy import copy
from fractions import Fraction
from functools import wraps
from typing import Any, Self, TypeVar

from flint import arb, ctx

from refdem.core.truth import Ball
from refdem.errors import NotCertifiedError
from refdem.truth.balls import (
    Climb,
    GuardedTruth,
    UndecidedError,
    arb_of,
    climbed,
    precision,
    refined,
)
from refdem.truth.growth import Grows

DISPLACEMENT = Fraction(1, 2**120)
"""Part of its scale by which a coordinate of the start is moved for differences: a start that is
1e-30 off a separatrix stays on its side."""
FIRST_BITS = 256
"""Working precision to begin with."""
GROWTH_BITS = (64, 128, 256, 512, 1024, 2048)
"""Working precisions for S, which need not be sharp."""
MOST_BITS = 16384
"""Where it ends."""

Size = float | Fraction
Owner = TypeVar("Owner", bound="ClosedForm")
Kept = TypeVar("Kept")


def per_precision(method: Callable[[Owner], Kept]) -> Callable[[Owner], Kept]:
    """Keeps what a method without arguments returns, once for each working precision."""

    @wraps(method)
    def kept(self: Owner) -> Kept:
        key = (method.__name__, ctx.prec)
        if key not in self.kept:
            self.kept[key] = method(self)
        found: Kept = self.kept[key]
        return found

    return kept


class ClosedForm(GuardedTruth):
    """A truth by formula. `digits`: radii are at most 10^-digits times the smallest scale (and
    10^-digits).

    `scale` maps every quantity to the size against which its error counts. `state` names, for each
    coordinate of the start, the quantity in whose scale that coordinate is displaced.
    """

    state: tuple[str, ...]

    def __init__(self, scale: Mapping[str, Size], *, digits: int = 40) -> None:
        self.scale = {name: Fraction(size) for name, size in scale.items()}
        self.digits = digits
        self.kept: dict[Any, Any] = {}

    @abstractmethod
    def evaluate(self, t: arb) -> dict[str, arb]:
        """Every quantity at time t at the current precision.

        UndecidedError where balls cannot choose a branch.
        """

    @abstractmethod
    def displaced(self, axis: int, amount: Fraction) -> Self:
        """The motion from a start whose coordinate `axis` is larger by exactly `amount` [its
        unit].
        """

    def constants(self) -> dict[str, arb]:
        """The scalars at the current precision."""
        return {}

    def bits(self) -> int:
        """Working precision to begin with."""
        return FIRST_BITS

    def most_bits(self) -> int:
        """The largest working precision [bits] that is tried."""
        return MOST_BITS

    def target(self) -> Fraction:
        """The largest radius that is asked for."""
        return (
            min([Fraction(1), *(size for size in self.scale.values() if size > 0)])
            / Fraction(10) ** self.digits
        )

    def refined(self, digits: int) -> Self:
        """The same truth with radii of at most 10^-digits."""
        other = copy(self)
        other.digits = digits
        return other

    def at(self, t: Fraction) -> dict[str, Ball]:
        """Every quantity at the exact time t [s]; raises NotCertifiedError where it cannot be
        proved.
        """
        return self._certified(lambda: self.evaluate(arb_of(t)), f"at t = {float(t):.17g} s", t)

    def scalars(self) -> dict[str, Ball]:
        """Values that do not depend on time."""
        return self._certified(self.constants, "scalars")

    def _certified(
        self, evaluate: Callable[[], dict[str, arb]], what: str, t: Fraction | None = None
    ) -> dict[str, Ball]:
        """Balls within the target; NotCertifiedError that says which end it is (errors.py)."""
        target = self.target()
        climb = climbed(evaluate, target, self.bits(), self.most_bits())
        balls = climb.balls
        if balls is None:
            raise self.undecided(climb, what, t)
        if any(ball.radius > target for ball in balls.values()):
            worst = max(balls, key=lambda name: balls[name].radius)
            radius = float(balls[worst].radius)
            told = (
                f"{what}: precision: with {climb.bits} bits the radius of {worst} stays at"
                f" {radius:.3g}; ask for fewer digits"
            )
            raise NotCertifiedError(
                told,
                code="precision",
                time=None if t is None else float(t),
                state={} if t is None else balls,
            )
        return balls

    def undecided(self, climb: Climb, what: str, t: Fraction | None) -> NotCertifiedError:
        """The end of a climb without balls; the last certified state is that which the reason has,
        or the one at the start.
        """
        reason = climb.reason
        if not isinstance(reason, UndecidedError):
            told = f"{what}: precision: with {climb.bits} bits a value is not finite: {reason}"
            return NotCertifiedError(
                told, code="precision", time=0.0 if t else None, state=self.at_start(t)
            )
        if reason.time is not None:
            told = f"{what}: {reason.code}: {reason}"
            return NotCertifiedError(told, code=reason.code, time=reason.time, state=reason.balls)
        if reason.code == "separatrix":
            advice = "; move the start off the boundary"
        else:
            advice = ""
        told = (
            f"{what}: {reason.code}: with {climb.bits} bits balls cannot decide a branch:"
            f" {reason}{advice}"
        )
        return NotCertifiedError(
            told, code=reason.code, time=0.0 if t else None, state=self.at_start(t)
        )

    def at_start(self, t: Fraction | None) -> dict[str, Ball]:
        """The last state that is certified where a branch is not: that at 0; none for scalars, and
        where it has a branch itself.
        """
        if t:
            return refined(lambda: self.evaluate(arb(0)), self.target(), self.bits()) or {}
        return {}

    @abstractmethod
    def growth(self) -> Grows:
        """How errors of this motion grow, at the current precision (refdem/truth/growth.py); kept
        by `per_precision`.
        """

    def growth_bits(self) -> Sequence[int]:
        """Working precisions for S, one after another until one suffices."""
        return GROWTH_BITS

    def sensitivity(self, t: Fraction) -> float:
        """S(t) >= 1: no error that is made at any time s <= t is larger at t, to first order, than
        S(t) times what it was at s.

        Errors and answers are counted in scales: the largest of those of the coordinates of the
        state, and of the quantities.
        """
        if ("sensitivity", t) not in self.kept:
            self.kept["sensitivity", t] = self._sensitivity(t)
        found: float = self.kept["sensitivity", t]
        return found

    def _sensitivity(self, t: Fraction) -> float:
        code = "precision"
        why = "no precision suffices"
        for bits in self.growth_bits():
            with precision(bits):
                try:
                    return self.growth().at(t)
                except (UndecidedError, NotCertifiedError) as error:
                    # An integration to few bits may end where one to more goes on.
                    code = getattr(error, "code", "separatrix")
                    why = str(error)
                    if getattr(error, "final", False):
                        break
        told = f"no sensitivity at t = {float(t):.17g} s: {code}: {why}"
        raise NotCertifiedError(told, code=code, time=0.0, state=self.at_start(t))

    def pair(self, axis: int) -> tuple[Self, Self]:
        """The motions from starts displaced by +-DISPLACEMENT scales along one coordinate."""
        if ("pair", axis) not in self.kept:
            amount = DISPLACEMENT * self.scale[self.state[axis]]
            self.kept["pair", axis] = self.displaced(axis, amount), self.displaced(axis, -amount)
        found: tuple[Self, Self] = self.kept["pair", axis]
        return found
