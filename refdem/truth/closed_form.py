"""A truth that is given by a formula.

Theorem: the quantities at t are what a formula of exact numbers says. A family writes the formula
(`evaluate`), its scalars (`constants`), the same motion from a displaced start (`displaced`) and
how errors of it grow (`growth`); values are proved by a refiner, S(t) by a sensitivity
(refdem/truth/refiner.py, where the hypotheses are, and where each is checked).

The classes here are abstract; their families are final.
"""

from abc import abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import wraps
from typing import Any, ClassVar, Protocol, Self, TypeVar

from flint import arb, ctx

from refdem.core.truth import Ball, Truth
from refdem.truth.balls import Guarded, arb_of
from refdem.truth.dual import Derivatives, flattened, unflattened
from refdem.truth.growth import Grows
from refdem.truth.refiner import Refiner, Sensitivity

DISPLACEMENT = Fraction(1, 2**120)
"""Part of its scale by which a coordinate of the start is moved for differences: a start that is
1e-30 off a separatrix stays on its side."""


class Remembers(Protocol):
    """A truth that keeps what it has computed in `kept`."""

    @property
    def kept(self) -> dict[Any, Any]: ...


Displaced = Callable[[Any, int, Fraction], Any]
"""The method `displaced` of a closed form."""
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


@dataclass(frozen=True)
class ClosedForm(Guarded, Truth):
    """A truth that is given by a formula, as a record of exact numbers.

    `refiner` proves values and has their scales and digits; `proof_of_s` proves S. `reported` names
    the quantities that `at` returns; empty for all. `kept` has results that are kept, by what they
    depend on besides the record.
    """

    refiner: Refiner
    kept: dict[Any, Any] = field(default_factory=dict, init=False, compare=False, repr=False)
    reported: ClassVar[tuple[str, ...]] = ()
    proof_of_s = Sensitivity()

    @property
    @abstractmethod
    def state(self) -> tuple[str, ...]:
        """For each coordinate of the start, the quantity in whose scale it is displaced."""

    @abstractmethod
    def evaluate(self, t: arb) -> dict[str, arb]:
        """Every quantity at time t at the current precision.

        UndecidedError where balls cannot choose a branch.
        """

    @abstractmethod
    def displaced(self, axis: int, amount: Fraction, /) -> Self:
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
        other = replace(self, refiner=self.refiner.to(digits))
        vars(other)["kept"] = self.kept
        return other

    def at(self, t: Fraction) -> dict[str, Ball]:
        """Every quantity at the exact time t [s]; raises NotCertifiedError where it cannot be
        proved.
        """
        balls = self.refiner.balls(
            lambda: self.evaluate(arb_of(t)), f"at t = {float(t):.17g} s", t, self.evaluated_at_0
        )
        return {name: balls[name] for name in self.reported or balls}

    def derivatives(self, t: Fraction, count: int) -> Derivatives:
        """The derivatives at t of every quantity by each of `count` parameters, by which the
        numbers of this truth carry their own derivatives (dual.py).
        """

        def formula() -> dict[str, arb]:
            values = self.evaluate(arb_of(t))
            return flattened({name: values[name] for name in self.reported or values}, count)

        flat = self.refiner.balls(formula, f"derivatives at t = {float(t):.17g} s", t)
        return unflattened(flat, count)

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


def displaced_fields(*names: str) -> Displaced:
    """The method `displaced` of closed forms whose start is these fields, one for each
    coordinate.
    """

    def displaced(self: Any, axis: int, amount: Fraction) -> Any:
        """The motion from a start whose coordinate `axis` is larger by exactly `amount`."""
        name = names[axis]
        return replace(self, **{name: getattr(self, name) + amount})

    return displaced


def displaced_tuple(name: str) -> Displaced:
    """The method `displaced` of closed forms whose start is one field, a tuple with a number for
    each coordinate.
    """

    def displaced(self: Any, axis: int, amount: Fraction) -> Any:
        """The motion from a start whose coordinate `axis` is larger by exactly `amount`."""
        return replace(self, **{name: larger(getattr(self, name), axis, amount)})

    return displaced


def displaced_part(name: str) -> Displaced:
    """The method `displaced` of closed forms whose start is that of one field, which can be
    displaced itself.
    """

    def displaced(self: Any, axis: int, amount: Fraction) -> Any:
        """The motion from a start whose coordinate `axis` is larger by exactly `amount`."""
        part = getattr(self, name).displaced(axis, amount)
        return replace(self, **{name: part})

    return displaced


def larger(start: tuple[Any, ...], axis: int, amount: Fraction) -> tuple[Any, ...]:
    """The coordinates of a start, of which that of `axis` is larger by exactly `amount`."""
    return (*start[:axis], start[axis] + amount, *start[axis + 1 :])
