"""What all closed forms share: precision raised until it suffices, and S(t) by differences of the closed form itself.

A closed form gives three things: its quantities as balls at the current precision, the same motion from a displaced start,
and its scalars. All else is here.
"""

from abc import abstractmethod
from collections.abc import Callable, Mapping
from copy import copy
from fractions import Fraction
from functools import wraps
from typing import Any, Self, TypeVar

from flint import arb, ctx

from refdem.core.truth import Ball, Truth
from refdem.errors import NotCertifiedError
from refdem.truth.balls import UndecidedError, arb_of, precision, refined
from refdem.truth.exact import refuse_rounded

DISPLACEMENT = Fraction(1, 2**120)
"""Part of its scale by which a coordinate of the start is moved for S: its square is far below any S that matters, and a
start that is 1e-30 off a separatrix stays on its side."""
FIRST_BITS = 256
"""Working precision to begin with."""
SENSITIVITY_BITS = 384
"""Working precision for S to start with: 120 bits are lost by the difference, 200 remain."""
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


class ClosedForm(Truth):
    """A truth by formula. `digits`: radii are at most 10^-digits times the smallest scale (and 10^-digits).

    `scale` maps every quantity to the size against which its error counts. `state` names, for each coordinate of the
    start, the quantity in whose scale that coordinate is displaced.
    """

    state: tuple[str, ...]

    def __new__(cls, *given: Any, **named: Any) -> Self:
        """Refuses int and float where a constructor is annotated Fraction: 1/3 of ints is rounded, and 0.1 is not 1/10."""
        if given or named:
            refuse_rounded(cls.__init__, given, named)
        return super().__new__(cls)

    def __init__(self, scale: Mapping[str, Size], *, digits: int = 40) -> None:
        self.scale = {name: Fraction(size) for name, size in scale.items()}
        self.digits = digits
        self.kept: dict[Any, Any] = {}

    @abstractmethod
    def evaluate(self, t: arb) -> dict[str, arb]:
        """Every quantity at time t at the current precision; UndecidedError where balls cannot choose a branch."""

    @abstractmethod
    def displaced(self, axis: int, amount: Fraction) -> Self:
        """The motion from a start whose coordinate `axis` is larger by exactly `amount` [its unit]."""

    def constants(self) -> dict[str, arb]:
        """The scalars at the current precision."""
        return {}

    def bits(self) -> int:
        """Working precision to begin with."""
        return FIRST_BITS

    def sensitivity_bits(self) -> int:
        """The same for S."""
        return SENSITIVITY_BITS

    def target(self) -> Fraction:
        """The largest radius that is asked for."""
        return min([Fraction(1), *(size for size in self.scale.values() if size > 0)]) / Fraction(10) ** self.digits

    def refined(self, digits: int) -> Self:
        """The same truth with radii of at most 10^-digits."""
        other = copy(self)
        other.digits = digits
        return other

    def at(self, t: Fraction) -> dict[str, Ball]:
        """Every quantity at the exact time t [s]; raises NotCertifiedError where it cannot be proved."""
        return self._certified(lambda: self.evaluate(arb_of(t)), f"at t = {float(t):.17g} s", t)

    def scalars(self) -> dict[str, Ball]:
        """Values that do not depend on time."""
        return self._certified(self.constants, "scalars")

    def _certified(self, evaluate: Callable[[], dict[str, arb]], what: str, t: Fraction | None = None) -> dict[str, Ball]:
        """Balls within the target; NotCertifiedError: separatrix where no precision tells a branch, precision where a radius stays."""
        target = self.target()
        balls = refined(evaluate, target, self.bits())
        if balls is None:
            told = f"{what}: separatrix: balls cannot decide a branch at the highest precision; move the start off the boundary"
            raise NotCertifiedError(told, code="separatrix", time=0.0 if t else None, state=self.at_start(t))
        if any(ball.radius > target for ball in balls.values()):
            worst = max(balls, key=lambda name: balls[name].radius)
            told = f"{what}: precision: radius of {worst} stays at {float(balls[worst].radius):.3g}; ask for fewer digits"
            raise NotCertifiedError(told, code="precision", time=None if t is None else float(t), state={} if t is None else balls)
        return balls

    def at_start(self, t: Fraction | None) -> dict[str, Ball]:
        """The last state that is certified where a branch is not: that at 0; none for scalars, and where it has a branch itself."""
        return (refined(lambda: self.evaluate(arb(0)), self.target(), self.bits()) or {}) if t else {}

    def sensitivity(self, t: Fraction) -> float:
        """S(t) >= 1: the largest change of a quantity at t (in its scale) when every coordinate of the start moves by its scale.

        max over quantities i of sum over j |d quantity_i(t)/scale_i over d start_j/scale_j|, an upper bound of the balls of
        central differences; exact to the order of the displacement squared.
        """
        if ("sensitivity", t) not in self.kept:
            self.kept["sensitivity", t] = self._sensitivity(t)
        found: float = self.kept["sensitivity", t]
        return found

    def _sensitivity(self, t: Fraction) -> float:
        bits, code, why = self.sensitivity_bits(), "", ""
        while bits <= MOST_BITS:
            with precision(bits):
                try:
                    rows = self.response(t)
                    if all(row.is_finite() and row.rad() <= (row.abs_lower() + 1) * arb(1e-3) for row in rows):
                        return max(1.0, *(float(row.upper()) * (1 + 2.0**-50) for row in rows))
                    code, why = "precision", "the motion is hardly differentiable in its start"
                except UndecidedError as error:
                    code, why = getattr(error, "code", "separatrix"), str(error)
            bits *= 2
        told = f"no sensitivity at t = {float(t):.17g} s: {code}: {why}"
        raise NotCertifiedError(told, code=code, time=0.0, state=self.at_start(t))

    def response(self, t: Fraction) -> list[arb]:
        """For every quantity, the sum over the coordinates of the start of its scaled response at t."""
        columns = [self.column(axis, t) for axis in range(len(self.state))]
        return [sum((column[i] for column in columns), arb(0)) for i in range(len(columns[0]))]

    def column(self, axis: int, t: Fraction) -> list[arb]:
        """|d quantity_i(t)/scale_i over d start/scale| for one coordinate of the start, one i after another."""
        plus, minus = (displaced.evaluate(arb_of(t)) for displaced in self.pair(axis))
        return [size / arb_of(2 * DISPLACEMENT) for size in self.differences(plus, minus)]

    def differences(self, plus: dict[str, arb], minus: dict[str, arb]) -> list[arb]:
        """Sizes of the differences of two states, each in its scale; an attitude overrides this to compare as a rotation."""
        return [abs(plus[name] - minus[name]) / arb_of(self.scale[name]) for name in plus]

    def pair(self, axis: int) -> tuple[Self, Self]:
        """The motions from starts displaced by +-DISPLACEMENT scales along one coordinate."""
        if ("pair", axis) not in self.kept:
            amount = DISPLACEMENT * self.scale[self.state[axis]]
            self.kept["pair", axis] = self.displaced(axis, amount), self.displaced(axis, -amount)
        found: tuple[Self, Self] = self.kept["pair", axis]
        return found
