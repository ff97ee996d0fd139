"""What a truth is composed of: a refiner, which proves values, and a sensitivity, which proves S.

Theorem (refiner): a formula that is evaluated in balls at any working precision gives balls that
contain its values. So a radius is only ever too large, never wrong, and raising the precision until
all radii are small enough proves the values to the digits that are requested.

Hypotheses, and where each is checked:

* the formula begins at exact numbers: the constructor of every truth (`Guarded.__new__`) and
  `arb_of` refuse what is rounded;
* every branch is decided for whole balls: a comparison that is not raises UndecidedError, after
  which more bits are tried;
* one thread at a time sets the precision: `precision` and `Guarded` hold a lock;
* the balls are finite: `ball_of` refuses one that is not.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Self

from flint import arb

from refdem.core.truth import Ball
from refdem.errors import NotCertifiedError
from refdem.truth.balls import Climb, UndecidedError, climbed, precision, refined
from refdem.truth.growth import Grows

FIRST_BITS = 256
"""The working precision [bit] to begin with."""
MOST_BITS = 16384
"""The precision [bit] at which raising it ends."""
GROWTH_BITS = (64, 128, 256, 512, 1024, 2048)
"""Working precisions for S, which need not be sharp."""

Size = float | Fraction
Formula = Callable[[], dict[str, arb]]
"""Quantities by name, as balls at the current precision."""


@dataclass(frozen=True)
class Refiner:
    """Proves a formula to radii of at most 10^-digits times the smallest scale (and 10^-digits).

    `scale` maps every quantity to the size against which its error counts. Precision rises from
    `first` bits to `most` bits.
    """

    scale: Mapping[str, Fraction]
    digits: int = 40
    first: int = FIRST_BITS
    most: int = MOST_BITS

    @classmethod
    def of(cls, scale: Mapping[str, Size], *, digits: int = 40) -> Self:
        """The refiner of quantities with these scales, which need not be exact."""
        return cls({name: Fraction(size) for name, size in scale.items()}, digits)

    def to(self, digits: int) -> Self:
        """The same one for other digits."""
        return replace(self, digits=digits)

    def target(self) -> Fraction:
        """The largest radius that is requested."""
        sizes = [Fraction(1), *(size for size in self.scale.values() if size > 0)]
        return min(sizes) / Fraction(10) ** self.digits

    def balls(
        self, formula: Formula, what: str, t: Fraction | None = None, start: Formula | None = None
    ) -> dict[str, Ball]:
        """Balls of `what` within the target; NotCertifiedError with the code of the failure.

        The codes are those of refdem/errors.py. `start` is the formula at time 0: its balls are the
        last certified state where a branch is not decided at `t`.
        """
        target = self.target()
        climb = climbed(formula, target, self.first, self.most)
        balls = climb.balls
        if balls is None:
            raise self.undecided(climb, what, t, start)
        if any(ball.radius > target for ball in balls.values()):
            worst = max(balls, key=lambda name: balls[name].radius)
            radius = float(balls[worst].radius)
            message = (
                f"{what}: precision: with {climb.bits} bits the radius of {worst} stays at"
                f" {radius:.3g}; ask for fewer digits"
            )
            if t is None:
                # Scalars have no time and no state.
                raise NotCertifiedError(message, code="precision", time=None, state={})
            raise NotCertifiedError(message, code="precision", time=float(t), state=balls)
        return balls

    def undecided(
        self, climb: Climb, what: str, t: Fraction | None, start: Formula | None
    ) -> NotCertifiedError:
        """The error of a climb that ended without balls.

        Its last certified state is that which the reason of the climb has, or the one at the start.
        """
        reason = climb.reason
        if isinstance(reason, UndecidedError) and reason.time is not None:
            message = f"{what}: {reason.code}: {reason}"
            return NotCertifiedError(
                message, code=reason.code, time=reason.time, state=reason.balls
            )
        if isinstance(reason, UndecidedError):
            code = reason.code
            message = (
                f"{what}: {code}: with {climb.bits} bits balls cannot decide a branch: {reason}"
            )
            if code == "separatrix":
                message += "; move the start off the boundary"
        else:
            code = "precision"
            message = f"{what}: precision: with {climb.bits} bits a value is not finite: {reason}"
        if t:
            certified_until = 0.0
        else:
            # Scalars, or the start itself: nothing before it is certified.
            certified_until = None
        state = self.at_start(t, start)
        return NotCertifiedError(message, code=code, time=certified_until, state=state)

    def at_start(self, t: Fraction | None, start: Formula | None) -> dict[str, Ball]:
        """The quantities at time 0, the last certified state where a branch is not decided at t.

        Empty for scalars, for a time 0, and where the start has such a branch itself.
        """
        if not t or start is None:
            return {}
        return refined(start, self.target(), self.first) or {}


@dataclass(frozen=True)
class Sensitivity:
    """Proves S(t), at the first working precision of `bits` at which it is known.

    Theorem: what `Grows.at` returns is an upper bound of S at any precision (refdem/truth/growth.py
    has the proofs and their hypotheses). So the first precision at which it returns at all is
    enough; a higher one could only make S smaller by what balls lose.
    """

    bits: Sequence[int] = GROWTH_BITS

    def at(
        self, growth: Callable[[], Grows], t: Fraction, start: Callable[[], Mapping[str, Ball]]
    ) -> float:
        """S(t) >= 1; NotCertifiedError, with the state at the start, if no precision suffices."""
        code = "precision"
        why = "no precision suffices"
        for bits in self.bits:
            with precision(bits):
                try:
                    return growth().at(t)
                except (UndecidedError, NotCertifiedError) as error:
                    # An integration to few bits may end where one to more bits continues.
                    code = error.code
                    why = str(error)
                    if isinstance(error, UndecidedError) and error.final:
                        break
        message = f"no sensitivity at t = {float(t):.17g} s: {code}: {why}"
        raise NotCertifiedError(message, code=code, time=0.0, state=start())
