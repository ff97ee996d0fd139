"""A truth that is given by a formula.

Theorem: the quantities at t are what a formula of exact numbers says. A family writes the formula
(`evaluate`), its scalars (`constants`), the same motion from a displaced start (`displaced`) and
how errors of it grow (`growth`); values are proved by a refiner, S(t) by a sensitivity
(refdem/truth/refiner.py, where the hypotheses are, and where each is checked).

The classes here are abstract; their families are final.
"""

from abc import abstractmethod
from collections.abc import Callable
from copy import copy
from fractions import Fraction
from functools import cached_property, wraps
from typing import Any, Protocol, Self, TypeVar

from flint import arb, ctx

from refdem.core.truth import Ball, Truth
from refdem.truth.balls import Guarded, arb_of
from refdem.truth.growth import Grows
from refdem.truth.refiner import Refiner, Sensitivity

DISPLACEMENT = Fraction(1, 2**120)
"""Part of its scale by which a coordinate of the start is moved for differences: a start that is
1e-30 off a separatrix stays on its side."""


class Remembers(Protocol):
    """A truth that keeps what it has computed in `kept`."""

    @property
    def kept(self) -> dict[Any, Any]: ...


Owner = TypeVar("Owner", bound=Remembers)
Kept = TypeVar("Kept")


def per_precision(method: Callable[[Owner], Kept]) -> Callable[[Owner], Kept]:
    """A decorator that keeps what a method without arguments returns, once for each working
    precision.
    """

    @wraps(method)
    def evaluated_once(self: Owner) -> Kept:
        key = (method.__name__, ctx.prec)
        if key not in self.kept:
            self.kept[key] = method(self)
        result: Kept = self.kept[key]
        return result

    return evaluated_once


class ClosedForm(Guarded, Truth):
    """A truth that is given by a formula.

    `refiner` proves values and has their scales and digits; `proof_of_s` proves S. `state` names,
    for each coordinate of the start, the quantity in whose scale that coordinate is displaced.
    `reported` names the quantities that `at` returns; empty for all.
    """

    refiner: Refiner
    proof_of_s: Sensitivity = Sensitivity()
    state: tuple[str, ...]
    reported: tuple[str, ...] = ()

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

    @abstractmethod
    def growth(self) -> Grows:
        """The growth S of this motion's errors, at the current precision (refdem/truth/growth.py);
        families keep it by `per_precision`.
        """

    def constants(self) -> dict[str, arb]:
        """The scalars at the current precision."""
        return {}

    @cached_property
    def kept(self) -> dict[Any, Any]:
        """Results that are kept, by what they depend on besides the start."""
        return {}

    @property
    def scale(self) -> dict[str, Fraction]:
        """The size of each quantity, against which its error counts."""
        return dict(self.refiner.scale)

    @property
    def digits(self) -> int:
        """Radii are at most 10^-digits."""
        return self.refiner.digits

    def refined(self, digits: int) -> Self:
        """This truth with radii of at most 10^-digits; results that are kept serve both."""
        # Makes the dictionary now, so that the copy shares it.
        _ = self.kept
        other = copy(self)
        other.refiner = self.refiner.to(digits)
        return other

    def at(self, t: Fraction) -> dict[str, Ball]:
        """Every quantity at the exact time t [s]; raises NotCertifiedError where it cannot be
        proved.
        """
        balls = self.refiner.balls(
            lambda: self.evaluate(arb_of(t)), f"at t = {float(t):.17g} s", t, self.evaluated_at_0
        )
        return {name: balls[name] for name in self.reported or balls}

    def scalars(self) -> dict[str, Ball]:
        """Values that do not depend on time."""
        return self.refiner.balls(self.constants, "scalars")

    def evaluated_at_0(self) -> dict[str, arb]:
        """Every quantity at the start, at the current precision."""
        return self.evaluate(arb(0))

    def sensitivity(self, t: Fraction) -> float:
        """S(t) >= 1: no error that is made at any time s <= t is larger at t, to first order, than
        S(t) times what it was at s.

        Errors and answers are counted in scales: the largest of those of the coordinates of the
        state, and of the quantities.
        """
        if ("sensitivity", t) not in self.kept:
            self.kept["sensitivity", t] = self.proof_of_s.at(
                self.growth, t, lambda: self.refiner.at_start(t, self.evaluated_at_0)
            )
        bound: float = self.kept["sensitivity", t]
        return bound


class OnALine:
    """The part of closed forms that start at the place `x0` with the velocity `v0`."""

    x0: Fraction
    v0: Fraction
    kept: dict[Any, Any]

    def displaced(self, axis: int, amount: Fraction) -> Self:
        """The motion whose x0 (axis 0) or v0 (axis 1) is larger by `amount`."""
        other = copy(self)
        other.kept = {}
        if axis == 0:
            other.x0 = self.x0 + amount
        else:
            other.v0 = self.v0 + amount
        return other


class FromCoordinates:
    """The part of closed forms whose start is the tuple `begin`, a number for each coordinate."""

    begin: tuple[Any, ...]
    kept: dict[Any, Any]

    def displaced(self, axis: int, amount: Fraction) -> Self:
        """The motion whose start is larger by `amount` in the coordinate `axis`."""
        begin = list(self.begin)
        begin[axis] += amount
        other = copy(self)
        other.kept = {}
        other.begin = tuple(begin)
        return other
