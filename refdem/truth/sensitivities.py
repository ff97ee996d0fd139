"""Certified sensitivities: the derivative of every quantity by every number of a case, in balls.

Theorem: a truth whose numbers are dual (dual.py) gives the derivatives of its quantities by the
chain rule, through every formula, branch and event that it is made of.

Hypotheses, and where each is checked:

* every number on which a quantity depends carries its derivatives, and the branch that is taken at
  the parameters is that of a neighbourhood of them: `unbracketed`, by differences of certified
  values at two distances, which share no code with the derivatives;
* the balls are finite and small: the refiner of the truth (refiner.py).
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from math import ceil
from typing import Protocol, Self, runtime_checkable

from refdem.core.parameters import Exact, Parameters
from refdem.core.truth import Ball, Truth
from refdem.errors import NotCertifiedError, RefdemError
from refdem.truth.dual import Derivatives, ExactDual

NO_NUMBERS = frozenset({"duration", "samples"})
"""Parameters that choose the times at which a motion is sampled and do not change the motion."""
DISTANCE = Fraction(1, 2**24)
"""Part of itself by which a number is moved for differences; 2^-24 of its unit if it is 0.

Where a quantity changes by much more than the number (a chaotic map), it is as much smaller: such
quantities are far from linear over larger distances.
"""
DIGITS = 24
"""Digits of the values whose differences are taken: those of the differences are 16. They are more
as distances are smaller.
"""
BESIDE = Fraction(1, 2**20)
"""Part of itself by which a number that lies on a border is moved for the derivative on one side;
2^-20 of its unit if it is 0. Differences about it stay on that side: they are taken over 2^-24 of
this.
"""
SPARE = 4
"""The factor by which a derivative may be further from the nearer difference than that is from the
farther one: the error of a central difference falls by 4 as its distance is halved, that of one to
one side by 2.
"""


@dataclass(frozen=True)
class Number:
    """One number of a case: the parameter that has it, and its place in a vector."""

    parameter: str
    place: int | None = None

    @property
    def name(self) -> str:
        """The name for people: `v0`, or `v0.1` of a vector."""
        if self.place is None:
            return self.parameter
        return f"{self.parameter}.{self.place}"

    def of(self, p: Mapping[str, Exact]) -> Fraction:
        """The exact value of the number."""
        value = p[self.parameter]
        if isinstance(value, tuple) and self.place is not None:
            value = value[self.place]
        assert isinstance(value, Fraction)
        return value

    def set_in(self, p: Parameters, value: Fraction) -> Parameters:
        """The parameters with another value of the number."""
        if self.place is None:
            return p.replaced({self.parameter: value})
        vector = p[self.parameter]
        assert isinstance(vector, tuple)
        changed = (*vector[: self.place], value, *vector[self.place + 1 :])
        return p.replaced({self.parameter: changed})


@runtime_checkable
class Differentiable(Protocol):
    """A truth that has derivatives by the parameters that its numbers carry."""

    def derivatives(self, t: Fraction, count: int) -> Derivatives:
        """The derivatives at t of every quantity by each of `count` parameters."""

    def refined(self, digits: int) -> Self:
        """The same truth to other digits."""


@runtime_checkable
class HasEquation(Protocol):
    """A closed form in functions that have no dual numbers, as the elliptic ones."""

    def by_equation(self) -> Truth:
        """The same quantities from the equation of motion, to the same digits."""


@dataclass(frozen=True)
class Beside:
    """The derivatives of every quantity by a number, at a `place` beside its value."""

    place: Fraction
    of: Mapping[str, Ball]


@dataclass(frozen=True)
class Sensitivities:
    """Derivatives at one time: `of[quantity][number]` is a ball [unit of the quantity over that of
    the number]. `missing` has the reason for each number by which there is no derivative, `beside`
    the derivatives just below and just above the value of that number, where they are asked for.
    """

    t: Fraction
    of: Mapping[str, Mapping[str, Ball]]
    missing: Mapping[str, str]
    beside: Mapping[str, Sequence[Beside]]


def numbers_of(p: Parameters) -> Iterator[Number]:
    """The numbers of a case that a quantity may depend on smoothly: all that are no counts."""
    for name, value in p.items():
        if name in NO_NUMBERS or p.declared[name].whole:
            continue
        if isinstance(value, Fraction):
            yield Number(name)
        elif isinstance(value, tuple):
            for place, entry in enumerate(value):
                if isinstance(entry, Fraction):
                    yield Number(name, place)


def sensitivities(
    make: Callable[[Parameters], Truth], p: Parameters, t: Fraction, digits: int
) -> Sensitivities:
    """The derivatives at t [s] of every quantity of a truth by every number of its parameters, to
    radii of 10^-digits.

    Raises NotCertifiedError where derivatives cannot be proved.
    """
    (found,) = sensitivities_at(make, p, [t], digits)
    beside = {
        number.name: list(on_either_side(make, p, number, t, digits))
        for number in numbers_of(p)
        if number.name in found.missing
    }
    return replace(found, beside=beside)


def sensitivities_at(
    make: Callable[[Parameters], Truth], p: Parameters, times: Sequence[Fraction], digits: int
) -> list[Sensitivities]:
    """The same at several times [s], without those `beside` a number: every motion is followed once
    for all times.
    """
    numbers = list(numbers_of(p))
    derivatives = at_times(make, p, numbers, times, digits)
    missing = unbracketed(derivatives, make, p, numbers, times)
    found = []
    for t, of_time, missing_then in zip(times, derivatives, missing, strict=True):
        of: dict[str, dict[str, Ball]] = {}
        for quantity, slopes in of_time.items():
            by_number = zip(numbers, slopes, strict=True)
            of[quantity] = {
                one.name: slope for one, slope in by_number if one.name not in missing_then
            }
        found.append(Sensitivities(t, of, missing_then, {}))
    return found


def by_formula(
    make: Callable[[Parameters], Truth],
    p: Parameters,
    numbers: Sequence[Number],
    t: Fraction,
    digits: int,
) -> Derivatives:
    """The derivatives at t [s] of every quantity by these numbers, as the branch that the motion
    takes at the parameters gives them.

    Raises NotCertifiedError where they cannot be proved.
    """
    (derivatives,) = at_times(make, p, numbers, [t], digits)
    return derivatives


def at_times(
    make: Callable[[Parameters], Truth],
    p: Parameters,
    numbers: Sequence[Number],
    times: Sequence[Fraction],
    digits: int,
) -> list[Derivatives]:
    """The same at several times, from one truth, which keeps what it has integrated."""
    moved = p
    for k, number in enumerate(numbers):
        unit = [int(k == other) for other in range(len(numbers))]
        moved = number.set_in(moved, ExactDual(number.of(p), unit))
    truth = make(moved).refined(digits)
    if isinstance(truth, HasEquation):
        truth = truth.by_equation()
    if not isinstance(truth, Differentiable):
        raise NotCertifiedError(
            f"derivatives of this truth by its parameters are not certified yet: {truth.method}"
        )
    try:
        return [truth.derivatives(t, len(numbers)) for t in times]
    except TypeError as error:
        # A dual number was passed to a function for which it has no rule of differentiation.
        raise NotCertifiedError(
            f"derivatives of this truth by its parameters are not certified yet: {error}"
        ) from None


def on_either_side(
    make: Callable[[Parameters], Truth], p: Parameters, number: Number, t: Fraction, digits: int
) -> Iterator[Beside]:
    """The derivatives by a number just below and just above its value, where there is a motion and
    its derivatives are bracketed there.
    """
    value = number.of(p)
    unit = abs(value) or Fraction(1)
    for side in (-BESIDE, BESIDE):
        place = value + side * unit
        try:
            there = number.set_in(p, place)
            derivatives = by_formula(make, there, [number], t, digits)
            direction = Direction({number: side})
            (reason,) = disagreements([derivatives], make, there, [number], direction, [t])
        except (RefdemError, ValueError, ArithmeticError):
            continue
        if reason is None:
            yield Beside(place, {quantity: slope for quantity, (slope,) in derivatives.items()})


@dataclass(frozen=True)
class Direction:
    """A direction in which numbers are moved together: how far each is, for a distance of 1."""

    steps: Mapping[Number, Fraction]

    @property
    def unit(self) -> Fraction:
        """How far its only number is moved; 1 where there are several."""
        if len(self.steps) > 1:
            return Fraction(1)
        (step,) = self.steps.values()
        return step

    def moved(self, p: Parameters, distance: Fraction) -> Parameters:
        """The parameters at this distance."""
        for number, step in self.steps.items():
            p = number.set_in(p, number.of(p) + distance * step)
        return p

    def derivative(self, slopes: Mapping[Number, Ball]) -> Ball:
        """The derivative in this direction, from those by each number."""
        mid = sum((slopes[number].mid * step for number, step in self.steps.items()), Fraction(0))
        radius = sum(slopes[number].radius * abs(step) for number, step in self.steps.items())
        return Ball(mid, Fraction(radius))


def unbracketed(
    derivatives: Sequence[Derivatives],
    make: Callable[[Parameters], Truth],
    p: Parameters,
    numbers: Sequence[Number],
    times: Sequence[Fraction],
) -> list[dict[str, str]]:
    """At each time, the numbers to whose derivatives differences of certified values do not tend as
    their distance falls, each with the observed limit.

    Numbers that are 0 are moved one by one: friction and a slip that leave 0 together change the
    motion by as much as either of them moves, although neither does alone. All others are moved at
    once, each by its own part; where that does not agree, they are moved one by one as well.
    """
    missing: list[dict[str, str]] = [{} for _ in times]
    if not numbers:
        return missing
    steps = {}
    for k, number in enumerate(numbers):
        # Step k of n is |x_k| (1 + k/(7 + n)), with 1 for |x_k| = 0: no two numbers change by the
        # same part of themselves, so that errors do not cancel.
        steps[number] = (abs(number.of(p)) or Fraction(1)) * (1 + Fraction(k, 7 + len(numbers)))
    together = {number: step for number, step in steps.items() if number.of(p) != 0}
    unclear: list[int] = []
    if together:
        reasons = disagreements(derivatives, make, p, numbers, Direction(together), times)
        unclear = [place for place, reason in enumerate(reasons) if reason is not None]
    for number, step in steps.items():
        alone = Direction({number: step})
        if number in together:
            places = unclear
        else:
            places = list(range(len(times)))
        if not places:
            continue
        derivatives_there = [derivatives[place] for place in places]
        times_there = [times[place] for place in places]
        of_number = disagreements(derivatives_there, make, p, numbers, alone, times_there)
        for place, reason in zip(places, of_number, strict=True):
            if reason is not None:
                missing[place][number.name] = reason
    return missing


def disagreements(
    derivatives: Sequence[Derivatives],
    make: Callable[[Parameters], Truth],
    p: Parameters,
    numbers: Sequence[Number],
    direction: Direction,
    times: Sequence[Fraction],
) -> list[str | None]:
    """At each time, None if differences in a direction tend to the derivative in it, else the
    observed limit.
    """
    expected_at = []
    growth = 1
    for of_time in derivatives:
        expected_of = {
            quantity: direction.derivative(dict(zip(numbers, slopes, strict=True)))
            for quantity, slopes in of_time.items()
        }
        expected_at.append(expected_of)
        growth = max([growth, *(ceil(abs(ball.mid)) for ball in expected_of.values())])
    # A distance smaller by `growth` loses log10(growth) digits, about a third of its bits.
    distance = DISTANCE / growth
    digits = DIGITS + growth.bit_length() // 3
    far = Differences(make, p, direction, distance, digits)
    near = Differences(make, p, direction, distance / 2, digits)
    return [
        disagreement(expected_of, direction, far.quotients(t), near.quotients(t))
        for t, expected_of in zip(times, expected_at, strict=True)
    ]


def disagreement(
    expected_of: Mapping[str, Ball],
    direction: Direction,
    far: Mapping[str, Ball] | None,
    near: Mapping[str, Ball] | None,
) -> str | None:
    """None if quotients at two distances tend to what is expected, else the observed limit."""
    if far is None or near is None:
        return "no motion beside it is certified"
    for quantity, expected in expected_of.items():
        if quantity not in far or quantity not in near:
            # A body that does not spin has no such quantity.
            continue
        apart = abs(far[quantity].mid - near[quantity].mid)
        rounding = far[quantity].radius + near[quantity].radius + expected.radius
        # |D - Q(h/2)| > SPARE (|Q(h) - Q(h/2)| + radii), Q(h) being the difference quotient.
        if abs(expected.mid - near[quantity].mid) > SPARE * (apart + rounding):
            seen = float(near[quantity].mid / direction.unit)
            computed = float(expected.mid / direction.unit)
            return (
                f"differences of certified values tend to {seen:.6g} for"
                f" {quantity}, and the formula at the parameters gives {computed:.6g}: the"
                " motion is of another kind on one side, or the formula does not carry the number"
            )
    return None


class Differences:
    """Differences of values that are certified to some digits, over their distance in a direction;
    the truth at each place is made once, and keeps what it has integrated.
    """

    def __init__(
        self,
        make: Callable[[Parameters], Truth],
        p: Parameters,
        direction: Direction,
        distance: Fraction,
        digits: int,
    ) -> None:
        self.make = make
        self.p = p
        self.direction = direction
        self.distance = distance
        self.digits = digits
        self.truths: dict[Fraction, Truth] = {}

    def truth(self, place: Fraction) -> Truth:
        """The truth at a distance in the direction."""
        if place not in self.truths:
            truth = self.make(self.direction.moved(self.p, place))
            self.truths[place] = truth.refined(self.digits)
        return self.truths[place]

    def quotients(self, t: Fraction) -> dict[str, Ball] | None:
        """The quotients at t between both sides, or to one side where the other has no motion; None
        where neither has.
        """
        sides: list[tuple[Fraction, Mapping[str, Ball]]] = []
        for place in (self.distance, -self.distance, Fraction(0)):
            try:
                balls = self.truth(place).at(t)
            except (RefdemError, ValueError, ArithmeticError):
                continue
            sides.append((place, balls))
            if len(sides) == 2:
                break
        if len(sides) < 2:
            return None
        (upper, above), (lower, below) = sides
        width = upper - lower
        quotients = {}
        for name in above.keys() & below.keys():
            ball = above[name]
            other = below[name]
            radius = (ball.radius + other.radius) / abs(width)
            # (f(upper) - f(lower))/(upper - lower); the radii of both values add.
            quotients[name] = Ball((ball.mid - other.mid) / width, radius)
        return quotients
