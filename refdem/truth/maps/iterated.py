"""Truth of an iteration: the orbit in balls, precision raised until they are small enough, S from
the products of the map's slopes.

Theorem: a step that is evaluated in balls contains the images of all points of the ball before it,
if every branch is decided for the whole ball. So orbits need no device but precision: a chaotic map
loses a few bits a step, and they are put in at the start.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from copy import copy
from fractions import Fraction
from functools import cached_property
from typing import Any, Self

import numpy as np
from flint import arb, arb_mat, ctx

from refdem.core.truth import Ball, Truth
from refdem.errors import NotCertifiedError, UsageError
from refdem.truth.balls import Guarded, UndecidedError, arb_of, ball_of, precision, refined
from refdem.truth.growth import BOUNDLESS, ROUNDING, Array, Norm, bounded, doubles
from refdem.truth.refiner import Size

MOST_BITS = 2**13
"""Some 2500 bounces or 8000 doublings: a hundred times as far as doubles can be judged; the cost
grows as the square.
"""
MOST_STEPS = 2**14
"""Of an orbit that does not lose bits: the same limit, in time instead of digits."""
SHARP = -200
"""A branch that is undecided for a ball of a radius below 2^SHARP is a boundary that is hit, and no
lack of precision.
"""


UNSURE = 1e-12
"""Part of the slopes of a step that may be unknown before its S is found at more bits."""


class BoundaryError(UndecidedError):
    """A branch that cannot be decided.

    `code` says what is hit, `gap` is the ball whose sign is not known.
    """

    def __init__(self, code: str, gap: arb) -> None:
        is_hit = gap.is_finite() and gap.rad() < arb(2) ** SHARP
        super().__init__(f"{code}: {gap} has no sign", code=code if is_hit else "precision")


class Iterated(Guarded, Truth):
    """Iterates n = 0, 1, ... of a map.

    `at(n)` to within 10^-digits of each scale. A state is whatever `step` takes and gives.
    """

    word: str

    scale: dict[str, Fraction]
    digits: int

    def iterate(self, scale: Mapping[str, Size], *, digits: int) -> None:
        """Sets the size of each quantity, and to how many digits it is told."""
        self.scale = {name: Fraction(size) for name, size in scale.items()}
        self.digits = digits

    @cached_property
    def kept(self) -> dict[int, dict[int, Any]]:
        """Iterates that are known, by precision and number."""
        return {}

    @abstractmethod
    def state(self, n: int) -> Any:
        """Iterate n at the current precision."""

    @abstractmethod
    def first(self) -> Any:
        """Iterate 0 at the current precision."""

    @abstractmethod
    def slope(self, state: Any, after: Any) -> arb_mat:
        """The derivative of one step, each number in its scale."""

    @abstractmethod
    def values(self, state: Any) -> dict[str, arb]:
        """The quantities of a state, by name."""

    def refined(self, digits: int) -> Self:
        """The same truth with radii of at most 10^-digits."""
        _ = self.kept
        other = copy(self)
        other.digits = digits
        return other

    def at(self, t: Fraction) -> Mapping[str, Ball]:
        """Every quantity of the iterate t, a whole number; raises NotCertifiedError where it cannot
        be proved.
        """
        n = whole(t)
        target = min(Fraction(1), *self.scale.values()) / 10**self.digits
        balls = refined(lambda: self.values(self.state(n)), target, most=MOST_BITS)
        if balls is None or any(ball.radius > target for ball in balls.values()):
            raise self.lost(n)
        return balls

    def lost(self, n: int) -> NotCertifiedError:
        """Why iterate n is not certified, and the last one that is."""
        code = "precision"
        last = 0
        with precision(MOST_BITS):
            try:
                self.state(n)
            except BoundaryError as error:
                code = error.code
            orbit = self.kept.setdefault(MOST_BITS, {0: self.first()})
            while last + 1 in orbit and all(
                value.rad() < arb(10) ** -self.digits
                for value in self.values(orbit[last + 1]).values()
            ):
                last += 1
            if code == "precision":
                limit = f"{MOST_BITS} bits are used up"
            else:
                limit = f"{self.word} {last + 1} meets a {code}"
            return ended(code, self.word, last, self.values(orbit[last]), limit)

    def jacobian(self, t: Fraction) -> arb_mat:
        """The derivative of iterate t by the start at the current precision, each number in its
        scale.
        """
        n = whole(t)
        size = self.slope(self.state(0), self.state(1)).nrows()
        total = arb_mat(size, size, [int(i == j) for i in range(size) for j in range(size)])
        for k in range(n):
            total = self.slope(self.state(k), self.state(k + 1)) * total
        return total


class Stepped(Guarded, ABC):
    """The part that all maps share: iterate by iterate, and S from the products of slopes."""

    scale: dict[str, Fraction]
    kept: dict[int, dict[int, Any]]
    word: str

    @abstractmethod
    def first(self) -> Any:
        """Iterate 0 at the current precision."""

    @abstractmethod
    def step(self, state: Any) -> Any:
        """The next iterate; BoundaryError where balls cannot choose a branch."""

    @abstractmethod
    def slope(self, state: Any, after: Any) -> arb_mat:
        """The derivative of one step, each number in its scale."""

    @abstractmethod
    def values(self, state: Any) -> dict[str, arb]:
        """The quantities of a state."""

    @cached_property
    def grown(self) -> list[float]:
        """S of the iterates so far."""
        return [1.0]

    @cached_property
    def front(self) -> list[tuple[Array, Array]]:
        """Derivatives of the last iterate by every earlier one, and what is wrong in them; empty
        before the first.
        """
        return []

    def state(self, n: int) -> Any:
        """Iterate n at the current precision, on from the last that is known."""
        orbit = self.kept.setdefault(ctx.prec, {})
        if not orbit:
            orbit[0] = self.first()
        if n in orbit:
            at = n
        else:
            at = len(orbit) - 1
        while at < n:
            if at >= MOST_STEPS:
                limit = f"more than {MOST_STEPS} are not tried"
                raise ended("time", self.word, at, self.values(orbit[at]), limit)
            after = self.step(orbit[at])
            for name, value in self.values(
                after
            ).items():  # a ball as large as its scale grows without bound, its exponents too
                if not value.rad() < arb_of(self.scale[name]):
                    raise BoundaryError("precision", value)
            orbit[at + 1] = after
            at += 1
        return orbit[n]

    def sensitivity(self, t: Fraction) -> float:
        """S: the largest sum of a row of the scaled derivative of iterate t by any earlier one, the
        start among them.
        """
        n = whole(t)
        bits = 256
        while len(self.grown) <= n:
            with precision(bits):
                try:
                    self._grow(len(self.grown))
                except UndecidedError as error:
                    if bits >= MOST_BITS:
                        raise NotCertifiedError(
                            f"no sensitivity: {error}", code="precision"
                        ) from None
                    bits *= 2
        return self.grown[n]

    def _grow(self, n: int) -> None:
        """Adds S of iterate n to those that are known."""
        if self.grown[-1] >= BOUNDLESS:
            self.grown.append(BOUNDLESS)
            return
        step = self.slope(self.state(n - 1), self.state(n))
        slope, off = doubles(step)
        if off > UNSURE * float(np.abs(slope).max()):
            raise UndecidedError("the slope of a step is not known")
        count = len(slope)
        if self.front:
            after, weights = self.front.pop()
        else:
            after = np.zeros((0, count, count))
            weights = np.zeros(0)
        size = Norm([1] * count)
        # The derivative of iterate n by every earlier one: that by iterate n - 1 was 1 before this
        # step.
        carried = slope @ np.concatenate([after, np.eye(count)[None]])
        wrong = off * count + ROUNDING * float(size(slope))
        weights = np.concatenate([weights, [wrong * self.grown[-1]]])
        # What comes after a step multiplies what was wrong in it (refdem/truth/growth.py).
        later = np.concatenate([carried[1:], np.eye(count)[None]])
        with np.errstate(over="ignore", invalid="ignore"):
            largest = float(size(carried).max()) + float((size(later) * weights).sum())
        self.grown.append(bounded(largest))
        self.front.append((carried, weights))


def ended(
    code: str, word: str, last: int, values: Mapping[str, arb], limit: str
) -> NotCertifiedError:
    """The honest end: code, word and number of the last certified iterate, its quantities."""
    balls = {name: ball_of(value) for name, value in values.items()}
    told = ", ".join(f"{name} = {float(ball.mid):.17g}" for name, ball in balls.items())
    message = f"{code}: certified up to {word} {last}, where {told}; {limit}"
    return NotCertifiedError(message, code=code, time=float(last), state=balls)


def whole(t: Fraction) -> int:
    """The number of an iterate; raises UsageError if it is none."""
    if t.denominator != 1 or t < 0:
        raise UsageError(f"iterate {t}; expected a whole number >= 0")
    return int(t)


def vector(values: Sequence[arb]) -> arb_mat:
    """A column vector of the given values."""
    return arb_mat(len(values), 1, list(values))
