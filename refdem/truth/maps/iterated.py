"""Truth of an iteration: the orbit in balls, precision raised until they are small enough, S from
the products of the map's slopes.

Theorem: a step that is evaluated in balls contains the images of all points of the ball before it,
if every branch is decided for the whole ball (`BoundaryError` where it is not). So orbits need no
device but precision: a chaotic map loses a few bits a step, and they are put in at the start.

S(n) is the largest norm of d x_n/d x_m over m <= n, a product of slopes of steps; it is computed in
doubles, with a bound of all that is lost by that (`Stepped._grow`).
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from copy import copy
from fractions import Fraction
from functools import cached_property
from typing import Any, Self

import numpy as np
from flint import arb, arb_mat, ctx

from refdem.core.truth import Ball, Truth
from refdem.errors import NotCertifiedError, UsageError
from refdem.truth.balls import Guarded, UndecidedError, arb_of, ball_of, precision, refined
from refdem.truth.dual import Derivatives, flattened, unflattened
from refdem.truth.growth import BOUNDLESS, ROUNDING, Array, Norm, bounded, doubles
from refdem.truth.refiner import Size

MOST_BITS = 2**13
"""The highest working precision: enough for some 2500 bounces or 8000 doublings, a hundred times as
far as doubles can be judged; the cost grows as the square.
"""
MOST_STEPS = 2**14
"""The most steps of an orbit that does not lose bits: the same limit, in time."""
BOUNDARY_RADIUS_LOG2 = -200
"""A branch that is undecided for a ball of a radius below 2^BOUNDARY_RADIUS_LOG2 is a boundary that
is hit, and no lack of precision.
"""


UNSURE = 1e-12
"""The largest relative error of the slopes of a step in doubles; else more bits are tried."""


class BoundaryError(UndecidedError):
    """Raised where balls cannot choose a branch: `gap` is the ball whose sign is not known.

    `code` names what is hit ("corner", "tangent"), if the ball is so small that it is a hit;
    otherwise the code is "precision".
    """

    def __init__(self, code: str, gap: arb) -> None:
        is_hit = gap.is_finite() and gap.rad() < arb(2) ** BOUNDARY_RADIUS_LOG2
        super().__init__(f"{code}: {gap} has no sign", code=code if is_hit else "precision")


class Iterated(Guarded, Truth):
    """The truth of the iterates n = 0, 1, ... of a map, `at(n)` to within 10^-digits of each scale.

    A state is whatever `step` takes and returns; `word` is what an iterate is called in messages.
    """

    word: str

    scale: dict[str, Fraction]
    digits: int

    def iterate(self, scale: Mapping[str, Size], *, digits: int) -> None:
        """Sets the size of each quantity, and to how many digits it is given."""
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
        return self.proved(n, lambda: self.values(self.state(n)))

    def derivatives(self, t: Fraction, count: int) -> Derivatives:
        """The derivatives of every quantity of the iterate t by each of `count` parameters, by
        which the numbers of this truth carry their own derivatives (dual.py): each step multiplies
        them by its slope.
        """
        n = whole(t)
        flat = self.proved(n, lambda: flattened(self.values(self.state(n)), count))
        return unflattened(flat, count)

    def proved(self, n: int, formula: Callable[[], dict[str, arb]]) -> dict[str, Ball]:
        """The balls of a formula of iterate n; raises NotCertifiedError where no precision makes
        them small enough.
        """
        target = self.largest_radius()
        balls = refined(formula, target, most=MOST_BITS)
        if balls is None or any(ball.radius > target for ball in balls.values()):
            raise self.lost(n)
        return balls

    def largest_radius(self) -> Fraction:
        """The largest radius of a certified value: 10^-digits of the smallest scale, or of 1."""
        smallest = Fraction(min(Fraction(1), *self.scale.values()))
        radius: Fraction = smallest / 10**self.digits
        return radius

    def lost(self, n: int) -> NotCertifiedError:
        """The error with the reason why iterate n is not certified, and the number of the last one
        that is.
        """
        code = "precision"
        last = 0
        with precision(MOST_BITS):
            try:
                self.state(n)
            except BoundaryError as error:
                code = error.code
            # `state` has kept all iterates that it reached at this precision.
            orbit = self.kept.setdefault(MOST_BITS, {0: self.first()})
            target = arb_of(self.largest_radius()).lower()
            while last + 1 in orbit:
                values = self.values(orbit[last + 1])
                if not all(value.rad() <= target for value in values.values()):
                    break
                last += 1
            if code == "precision":
                limit = f"{MOST_BITS} bits are used up"
            else:
                limit = f"{self.word} {last + 1} meets a {code}"
            return ended(code, self.word, last, self.values(orbit[last]), limit)

    def jacobian(self, t: Fraction) -> arb_mat:
        """The derivative of iterate t by the start, in scales: the product of the steps' slopes."""
        n = whole(t)
        size = self.slope(self.state(0), self.state(1)).nrows()
        # D(n, 0) = slope(n) ... slope(2) slope(1).
        product = arb_mat(size, size, [int(i == j) for i in range(size) for j in range(size)])
        for k in range(n):
            product = self.slope(self.state(k), self.state(k + 1)) * product
        return product


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
        """One pair, or none before the first step: the derivatives of the last iterate by every
        earlier one, in doubles (n, q, q), and bounds (n) of the errors that each step made in them.
        """
        return []

    def state(self, n: int) -> Any:
        """Iterate n at the current precision, on from the last that is known."""
        orbit = self.kept.setdefault(ctx.prec, {})
        if not orbit:
            orbit[0] = self.first()
        if n in orbit:
            last = n
        else:
            last = len(orbit) - 1
        while last < n:
            if last >= MOST_STEPS:
                limit = f"more than {MOST_STEPS} are not tried"
                raise ended("time", self.word, last, self.values(orbit[last]), limit)
            after = self.step(orbit[last])
            # A ball as large as its scale would grow without bound, its exponents too.
            for name, value in self.values(after).items():
                if not value.rad() < arb_of(self.scale[name]):
                    raise BoundaryError("precision", value)
            orbit[last + 1] = after
            last += 1
        return orbit[n]

    def sensitivity(self, t: Fraction) -> float:
        """S(t): the largest sum of a row of the scaled derivative of iterate t by any earlier one.

        The start is one of them. Raises NotCertifiedError if no precision bounds the slopes.
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
        """Adds S of iterate n to those that are known.

        The derivatives of iterate n by every earlier one are the slope of this step times those of
        iterate n - 1. In doubles, a step's slope is off by at most `off` an entry and its product
        by rounding; that error is made in derivatives of norm at most S(n - 1), and multiplied by
        all steps that follow. So S is at most the largest norm, plus the sum over all steps of
        (norm of what follows) x (error of the step).
        """
        if self.grown[-1] >= BOUNDLESS:
            self.grown.append(BOUNDLESS)
            return
        step = self.slope(self.state(n - 1), self.state(n))
        slope, off = doubles(step)
        if off > UNSURE * float(np.abs(slope).max()):
            raise UndecidedError("the slope of a step is not known")
        count = len(slope)
        if self.front:
            before, errors = self.front.pop()
        else:
            before = np.zeros((0, count, count))
            errors = np.zeros(0)
        norm = Norm([1] * count)
        identity = np.eye(count)[None]
        # D(n, m) = slope D(n - 1, m) with D(n - 1, n - 1) = 1, where D(n, m) is the derivative of
        # iterate n by iterate m.
        derivatives = slope @ np.concatenate([before, identity])
        # e_n = (q off + ROUNDING |slope|) S(n - 1) bounds what this step adds to the errors; `off`
        # already bounds the norm of the error of the slope (growth.doubles).
        step_error = off * count + ROUNDING * float(norm(slope))
        errors = np.concatenate([errors, [step_error * self.grown[-1]]])
        # What follows the step to iterate k multiplies its error e_k by D(n, k), and D(n, n) = 1.
        following = np.concatenate([derivatives[1:], identity])
        with np.errstate(over="ignore", invalid="ignore"):
            # S(n) <= max over m < n of |D(n, m)| + sum over 1 <= k <= n of |D(n, k)| e_k.
            largest = float(norm(derivatives).max()) + float((norm(following) * errors).sum())
        self.grown.append(bounded(largest))
        self.front.append((derivatives, errors))


def ended(
    code: str, word: str, last: int, values: Mapping[str, arb], limit: str
) -> NotCertifiedError:
    """The error that ends an orbit: it names the last certified iterate and its quantities."""
    balls = {name: ball_of(value) for name, value in values.items()}
    listed = ", ".join(f"{name} = {float(ball.mid):.17g}" for name, ball in balls.items())
    message = f"{code}: certified up to {word} {last}, where {listed}; {limit}"
    return NotCertifiedError(message, code=code, time=float(last), state=balls)


def whole(t: Fraction) -> int:
    """The number of an iterate; raises UsageError if it is none."""
    if t.denominator != 1 or t < 0:
        raise UsageError(f"iterate {t}; expected a whole number >= 0")
    return int(t)


def vector(values: Sequence[arb]) -> arb_mat:
    """A column vector of the given values."""
    return arb_mat(len(values), 1, list(values))
