"""Certified motion of rigid round bodies through one impact: straight lines, the impulses of
rigid_impact.py, straight lines.

Notation: r, v, omega of each body, in this order, are the state; n is the unit normal from the
first body to what it meets, and c > 0 the closing speed there. The time of the impact, the places
and the normal there lie in a field Q(sqrt(q)) (surds.py), so that whether friction is cut is
decided exactly. With friction that is not cut the velocities afterwards lie in it too.

S: an error dx before the impact moves its time by dt = n.(dr2 - dr1)/c. So the derivative across
the impact is

    Xi = DP (1 + f- (d t/d x)) - f+ (d t/d x),

P being the map of the impulses and f = (v, 0, 0) the rates before and after (the saltation matrix;
Aizerman and Gantmacher 1958). DP comes from the formulas of the impulses by the chain rule. Exactly
where friction is just enough P has a kink, and S is the larger one of both sides.
"""

from collections.abc import Iterator, Mapping, Sequence
from copy import copy
from fractions import Fraction
from functools import cached_property
from typing import Any, Protocol, Self

from flint import arb, arb_mat

from refdem.truth.balls import UndecidedError, arb_of
from refdem.truth.closed_form import ClosedForm, per_precision
from refdem.truth.growth import Grows, Growth, Norm, Stretch, narrow, smooth
from refdem.truth.refiner import Refiner, Size
from refdem.truth.rigid_impact import Impact, ImpactLaw, Motion, RoundBody, dot, impact_of
from refdem.truth.slopes import parameters
from refdem.truth.surds import Surd

METHOD = (
    "time of impact by the quadratic, impulses in closed form; friction is decided in exact"
    " arithmetic of one square root"
)
WITNESS = (
    "impulses from the balance equations of both bodies by elimination, time of impact by bisection"
    " (refdem/truth/witnesses/rigid_impacts.py)"
)
TOLD_APART = Fraction(1, 2**40)
"""Part of the time of impact within which a sample counts as at the impact: binary64 tells times
apart to 2^-52, and an engine's own time of impact is rounded a few times.
"""
OF_BODY = 9
"""Numbers of the state of a body: r, v, omega."""


def motions(numbers: Sequence[Any]) -> list[Motion]:
    """The motions of bodies, from all of their numbers in order."""
    found = []
    for begin in range(0, len(numbers), OF_BODY):
        own = numbers[begin : begin + OF_BODY]
        found.append(Motion(own[:3], own[3:6], own[6:]))
    return found


def flat(states: Sequence[Motion]) -> list[Any]:
    """All numbers of some motions in order."""
    return [number for state in states for number in state.numbers()]


class Meeting(Protocol):
    """Where and when round bodies meet: two spheres, or one and a wall."""

    def time(self, states: Sequence[Motion]) -> Surd:
        """When bodies that start so meet [s], in exact numbers; UndecidedError if they do not."""

    def normal(self, places: Sequence[Sequence[Any]]) -> list[Any]:
        """The unit normal n (3,) from the first body to what it meets, at the impact, in numbers of
        the kind of the places: exact ones, balls, or balls with derivatives.
        """


class RigidCollision(ClosedForm):
    """One impact of one or two bodies; the state and the quantities are r, v, omega of each."""

    method = METHOD
    witness = WITNESS

    def __init__(
        self,
        scale: Mapping[str, Size],
        bodies: Sequence[RoundBody],
        law: ImpactLaw,
        meeting: Meeting,
        start: Sequence[Fraction],
    ) -> None:
        self.refiner = Refiner.of(scale)
        self.state = tuple(scale)
        self.bodies = bodies
        self.law = law
        self.meeting = meeting
        self.start = start

    @cached_property
    def moment(self) -> Surd:
        """When they meet [s], in exact numbers."""
        return self.meeting.time(motions(self.start))

    @cached_property
    def impact(self) -> Impact:
        """The impact in exact numbers."""
        return impact_of(self.bodies, self.law)

    @cached_property
    def side_of_limit(self) -> int:
        """1 where Coulomb's law cuts the tangential impulse, 0 where it is just enough, -1 below,
        exactly.
        """
        states = [state.after(self.moment) for state in motions(self.start)]
        closing, slip = self.impact.approach(
            self.meeting.normal([state.r for state in states]), states
        )
        return self.impact.excess(closing, slip)

    @per_precision
    def before(self) -> list[Motion]:
        """The states in balls right before the impact."""
        moment = self.moment.ball()
        starts = motions([arb_of(number) for number in self.start])
        return [state.after(moment) for state in starts]

    @per_precision
    def after(self) -> list[Motion]:
        """The states in balls right after the impact."""
        impact = self.impact.in_numbers(arb_of)
        states = self.before()
        normal = self.meeting.normal([state.r for state in states])
        return impact.parted(normal, states, is_cut=self.side_of_limit > 0)

    def evaluate(self, t: arb) -> dict[str, arb]:
        moment = self.moment.ball()
        since = t - moment
        near = moment * arb_of(TOLD_APART)
        if since < -near:
            starts = motions([arb_of(number) for number in self.start])
            return self.named([state.after(t) for state in starts])
        if since > near:
            return self.named([state.after(since) for state in self.after()])
        raise UndecidedError(
            f"t is that of the impact, {moment.str(20)} s, at which velocities jump; ask for"
            " another time, or for another number of samples",
            code="jump",
            final=True,
        )

    def named(self, states: Sequence[Motion]) -> dict[str, arb]:
        """The quantities by name, of some states."""
        return dict(zip(self.state, flat(states), strict=True))

    def displaced(self, axis: int, amount: Fraction) -> Self:
        other = copy(self)
        for name in ("kept", "moment", "side_of_limit"):
            other.__dict__.pop(name, None)
        other.start = [x + amount * (i == axis) for i, x in enumerate(self.start)]
        return other

    def constants(self) -> dict[str, arb]:
        """impact_time [s], the impulses along and across the normal [N s], and the energy lost
        [J].
        """
        impact = self.impact.in_numbers(arb_of)
        states = self.before()
        closing, slip = impact.approach(self.meeting.normal([state.r for state in states]), states)
        slip_squared = dot(slip, slip)
        k = impact.tangential_factor(closing, slip, is_cut=self.side_of_limit > 0)
        # Of the relative motion m_n c^2/2 + m_t s^2/2 what is left is e^2 of the first part and
        # (1 - k/m_t)^2 of the second.
        e = arb_of(self.law.restitution)
        normal_mass = impact.normal_factor / (1 + e)
        tangential_mass = impact.stopping / arb_of(1 + self.law.tangential_restitution)
        left = 1 - k / tangential_mass
        lost_along = normal_mass * closing * closing * (1 - e * e) / 2
        lost_across = tangential_mass * slip_squared * (1 - left * left) / 2
        return {
            "impact_time": self.moment.ball(),
            "normal_impulse": impact.normal_impulse(closing),
            "tangential_impulse": k * length(slip_squared),
            "energy_lost": lost_along + lost_across,
        }

    @per_precision
    def growth(self) -> Grows:
        sides = [self.side_of_limit > 0]
        if self.side_of_limit == 0:
            sides.append(True)
        size = Norm([1] * len(self.state))
        step = narrow(self.rate_of_flight())
        found: list[Grows] = [
            Growth(self.stretches(is_cut=side), size, step=step) for side in sides
        ]
        return Largest(found)

    def rate_of_flight(self) -> arb:
        """The largest rate [1/s] at which an error of a velocity, in its scale, moves a place, in
        its own.
        """
        rates = []
        for place, speed in self.flights():
            rates.append(self.ratio(place, speed))
        return arb_of(max(rates))

    def flights(self) -> Iterator[tuple[int, int]]:
        """The numbers of each place in the state and of its velocity."""
        for begin in range(0, len(self.state), OF_BODY):
            for axis in range(3):
                yield begin + axis, begin + 3 + axis

    def ratio(self, row: int, column: int) -> Fraction:
        """The scale of one coordinate over that of another."""
        return self.scale[self.state[column]] / self.scale[self.state[row]]

    def stretches(self, *, is_cut: bool) -> Iterator[Stretch]:
        """Two free flights, with the impact between them."""
        count = len(self.state)
        moving = [
            (place, speed, arb_of(self.ratio(place, speed))) for place, speed in self.flights()
        ]

        def flight(t: arb) -> arb_mat:
            found = identity(count)
            for place, speed, ratio in moving:
                found[place, speed] = t * ratio
            return found

        impact = self.saltation(is_cut=is_cut)
        yield smooth(arb(0), self.moment.ball(), flight, jump=impact, affine=True)
        yield smooth(self.moment.ball(), None, flight, affine=True)

    def saltation(self, *, is_cut: bool) -> arb_mat:
        """The derivative across the impact, in scales: Xi = DP (1 + f- tau) - f+ tau, with tau = d
        t/d x.
        """
        count = len(self.state)
        states = self.before()
        sloped = motions(parameters(flat(states)))
        impact = self.impact.in_numbers(arb_of)
        normal = self.meeting.normal([state.r for state in sloped])
        parted = flat(impact.parted(normal, sloped, is_cut=is_cut))
        derivative = arb_mat([list(number.slopes) for number in parted])
        moved = identity(count) + outer(rates(states), self.time_slopes())
        after = rates(motions([number.value for number in parted]))
        raw = derivative * moved - outer(after, self.time_slopes())
        scaled = identity(count)
        for row in range(count):
            for column in range(count):
                scaled[row, column] = raw[row, column] * arb_of(self.ratio(row, column))
        return scaled

    def time_slopes(self) -> list[arb]:
        """The derivatives of the time of impact by the state right before it: n.(dr2 - dr1)/c."""
        states = self.before()
        impact = self.impact.in_numbers(arb_of)
        normal = self.meeting.normal([state.r for state in states])
        closing, _ = impact.approach(normal, states)
        found = [arb(0)] * len(self.state)
        for number in range(len(states)):
            side = 2 * number - 1
            for axis in range(3):
                found[OF_BODY * number + axis] = normal[axis] * side / closing
        return found


class Largest:
    """S of a motion that two flows tell, one to either side of a kink: the larger one of both."""

    def __init__(self, sides: Sequence[Grows]) -> None:
        self.sides = sides

    def at(self, t: Fraction) -> float:
        """The bound S(t) >= 1 on the growth of an error."""
        return max(side.at(t) for side in self.sides)


def rates(states: Sequence[Motion]) -> list[arb]:
    """The rates of the state in free flight: f = (v, 0, 0) of each body."""
    found = []
    for state in states:
        found += [*state.v, *[arb(0)] * 6]
    return found


def outer(column: Sequence[arb], row: Sequence[arb]) -> arb_mat:
    """The matrix of all products of two vectors."""
    return arb_mat([[a * b for b in row] for a in column])


def identity(count: int) -> arb_mat:
    """The unit matrix of so many rows."""
    return arb_mat([[arb(int(i == j)) for j in range(count)] for i in range(count)])


def length(square: arb) -> arb:
    """The root of a square; of one that may be 0 all roots that it may have."""
    if square > 0:
        return square.sqrt()
    return arb(0).union(square.abs_upper().sqrt())
