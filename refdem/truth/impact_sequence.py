"""Certified motion of rigid round bodies through any number of impacts: flights, free or under
uniform gravity, and between them the impulses of rigid_impact.py.

Notation: r, v, omega of each body, in this order, are the state; n is the unit normal from the
first body to what it meets, and c > 0 the closing speed there.

The list of impacts is made in exact arithmetic, of rationals or of one square root (surds.py):
which pair is the next to meet, whether two meetings come at one time, and whether friction is cut
are decided, not estimated. Impacts of different bodies at one time commute; those that share a body
are refused, because what comes out depends on their order. The states are then carried in balls.
Where every impact brings a square root of its own, the list is made in balls (impacts_in_balls.py).

S: an error dx right before an impact moves its time by dt = n.(dr2 - dr1)/c. So the derivative
across the impact is

    Xi = DP (1 + f- (d t/d x)) - f+ (d t/d x),

P being the map of the impulses and f = (v, g, 0) the rates before and after (the saltation matrix;
Aizerman and Gantmacher 1958). DP comes from the formulas of the impulses by the chain rule. An
error in a flight obeys dr' = dv, with uniform gravity or without it. Exactly where friction is just
enough P has a kink, and S is the largest one of all choices of sides.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from itertools import combinations, product
from typing import Any, Protocol, Self

from flint import arb, arb_mat

from refdem.truth.balls import UndecidedError, arb_of, unit_matrix
from refdem.truth.closed_form import ClosedForm, larger, per_precision
from refdem.truth.dual import parameters
from refdem.truth.growth import Grows, Growth, Norm, Stretch, narrow, smooth
from refdem.truth.refiner import Refiner, Size
from refdem.truth.rigid_impact import Impact, Motion
from refdem.truth.surds import Number, sign
from refdem.truth.vectors import dot

TOLD_APART = Fraction(1, 2**40)
"""Part of the time of impact within which a sample counts as at the impact: binary64 resolves times
to 2^-52, and an engine's own time of impact is rounded a few times.
"""
OF_BODY = 9
"""Numbers of the state of a body: r, v, omega."""
MOST_KINKS = 6
"""Impacts at which friction is just enough, of which S takes all choices of sides."""


def motions(numbers: Sequence[Any]) -> list[Motion]:
    """The motions of bodies, from all of their numbers in order."""
    states = []
    for begin in range(0, len(numbers), OF_BODY):
        of_body = numbers[begin : begin + OF_BODY]
        states.append(Motion(of_body[:3], of_body[3:6], of_body[6:]))
    return states


def flat(states: Sequence[Motion]) -> list[Any]:
    """All numbers of some motions in order."""
    return [number for state in states for number in state.numbers()]


class Meeting(Protocol):
    """Where and when round bodies meet: two spheres, or one and a wall."""

    def time(self, states: Sequence[Motion]) -> Any | None:
        """When bodies that move so meet next [s], in numbers of the kind of the states: exact ones,
        or balls. None if they do not, and UndecidedError where that is not a proper impact.
        """

    def normal(self, places: Sequence[Sequence[Any]]) -> list[Any]:
        """The unit normal n (3,) from the first body to what it meets, at the impact, in numbers of
        the kind of the places: exact ones, balls, or balls with derivatives.
        """


@dataclass(frozen=True)
class Encounter:
    """Bodies that may meet, by their numbers: two, or one that meets a wall."""

    bodies: tuple[int, ...]
    impact: Impact
    meeting: Meeting

    def of(self, states: Sequence[Motion]) -> list[Motion]:
        """The states of these bodies."""
        return [states[body] for body in self.bodies]

    def side_of_limit(self, states: Sequence[Motion]) -> int:
        """1 where Coulomb's law cuts the tangential impulse, 0 where it is just enough, -1 below,
        of exact states at the impact.
        """
        meeting = self.of(states)
        normal = self.meeting.normal([state.r for state in meeting])
        return self.impact.excess(*self.impact.approach(normal, meeting))

    def parted(self, states: Sequence[Motion], impact: Impact, *, is_cut: bool) -> list[Motion]:
        """The states of all bodies right after the impact, whose numbers are of the kind of the
        states.
        """
        meeting = self.of(states)
        normal = self.meeting.normal([state.r for state in meeting])
        after = list(states)
        parted = impact.parted(normal, meeting, is_cut=is_cut)
        for body, state in zip(self.bodies, parted, strict=True):
            after[body] = state
        return after


@dataclass(frozen=True)
class Moment:
    """A time [s] at which bodies meet, with the states of all right before it, in numbers of one
    kind: exact ones, or balls.

    `wait` [s] is the time since the moment before it, or since the start. `encounters` are all that
    come at this time, no two of which share a body; `sides` has for each the side of Coulomb's
    limit on which it is.
    """

    time: Any
    wait: Any
    states: Sequence[Motion]
    encounters: tuple[Encounter, ...]
    sides: tuple[int, ...]

    @cached_property
    def parted(self) -> list[Motion]:
        """The exact states of all bodies right after it, from exact ones before it."""
        states = list(self.states)
        for encounter, side in zip(self.encounters, self.sides, strict=True):
            states = encounter.parted(states, encounter.impact, is_cut=side > 0)
        return states


class Impacts(Protocol):
    """A list of impacts in order, up to `most` moments, of bodies that start so and may meet in
    `encounters`.
    """

    @property
    def encounters(self) -> Sequence[Encounter]: ...

    @property
    def start(self) -> Sequence[Fraction]:
        """All numbers of all bodies at the start."""

    @property
    def gravity(self) -> Sequence[Fraction] | None: ...

    @property
    def most(self) -> int: ...

    def number(self, k: int) -> Moment | None:
        """The moment number k, from 0; None if bodies meet at fewer of them."""

    def all(self) -> list[Moment]:
        """All moments, up to `most`."""

    def begun_at(self, start: Sequence[Fraction]) -> "Impacts":
        """The list of the same bodies from another start."""


class ImpactList:
    """The impacts of bodies that start so, in order and in exact arithmetic. They are computed on
    demand, up to `most` moments.
    """

    def __init__(
        self,
        encounters: Sequence[Encounter],
        start: Sequence[Fraction],
        gravity: Sequence[Fraction] | None,
        most: int,
    ) -> None:
        self.encounters = encounters
        self.start = start
        self.gravity = gravity
        self.most = most
        self.moments: list[Moment] = []
        self.is_complete = False

    def number(self, k: int) -> Moment | None:
        """The moment number k, from 0; None if bodies meet at fewer of them."""
        while len(self.moments) <= k and not self.is_complete:
            following = self.following()
            if following is None:
                self.is_complete = True
            else:
                self.moments.append(following)
        if k < len(self.moments):
            return self.moments[k]
        return None

    def all(self) -> list[Moment]:
        """All moments, up to `most`."""
        while self.number(len(self.moments)) is not None:
            pass
        return self.moments

    def begun_at(self, start: Sequence[Fraction]) -> "ImpactList":
        """The list of the same bodies from another start."""
        return ImpactList(self.encounters, start, self.gravity, self.most)

    def following(self) -> Moment | None:
        """The moment after the last one; UndecidedError if impacts that share a body come at one
        time.
        """
        if len(self.moments) == self.most:
            return None
        states = motions(self.start)
        begin: Number = Fraction(0)
        if self.moments:
            states = self.moments[-1].parted
            begin = self.moments[-1].time
        waits: list[tuple[Number, Encounter]] = []
        for encounter in self.encounters:
            wait = encounter.meeting.time(encounter.of(states))
            if wait is not None:
                waits.append((wait, encounter))
        if not waits:
            return None
        # The shortest wait, compared exactly, and all encounters that have it.
        first = waits[0][0]
        for wait, _ in waits:
            if sign(wait - first) < 0:
                first = wait
        due = tuple(encounter for wait, encounter in waits if sign(wait - first) == 0)
        self.refuse_chains(due, first)
        arrived = [state.after(first, self.gravity) for state in states]
        sides = tuple(encounter.side_of_limit(arrived) for encounter in due)
        return Moment(first + begin, first, arrived, due, sides)

    def refuse_chains(self, due: Sequence[Encounter], wait: Number) -> None:
        """Raises UndecidedError if two of the impacts that are due share a body, or if they come at
        the time of those before them.
        """
        for one, other in combinations(due, 2):
            shared = set(one.bodies) & set(other.bodies)
            if shared:
                raise UndecidedError(
                    f"body {min(shared)} meets two others at one time, and what comes out depends"
                    " on the order of the two impacts",
                    code="corner",
                    final=True,
                )
        if self.moments and sign(wait) == 0:
            raise UndecidedError(
                f"body {due[0].bodies[0]} is hit while it still touches another one, and what comes"
                " out depends on the order of their impacts",
                code="corner",
                final=True,
            )


class Family(Protocol):
    """What a kind of motion adds to its list of impacts; `method` and `witness` are those of a
    truth.
    """

    @property
    def method(self) -> str:
        """The words for how values are proved."""

    @property
    def witness(self) -> str:
        """The words for what confirms them."""

    def constants(self, motion: "ImpactSequence") -> dict[str, arb]:
        """The scalars of a motion at the current precision."""

    def refuse_unlisted(self, motion: "ImpactSequence", t: arb) -> None:
        """Raises UndecidedError where impacts after the last one of the list may come before t."""


@dataclass(frozen=True)
class ImpactSequence(ClosedForm):
    """A motion through a list of impacts; `coordinates` are the places in the full state of the
    quantities that are reported, in their order.

    The other coordinates keep their values: the motion is on a line, or in a plane.
    """

    impacts: Impacts
    coordinates: Sequence[int]
    family: Family
    method: str
    witness: str

    @cached_property
    def state(self) -> tuple[str, ...]:
        """The quantities, in their order."""
        return tuple(self.scale)

    @classmethod
    def of(
        cls, scale: Mapping[str, Size], impacts: Impacts, coordinates: Sequence[int], family: Family
    ) -> Self:
        """The motion of quantities with these scales, proved by the method of the family."""
        refiner = Refiner.of(scale)
        return cls(refiner, impacts, coordinates, family, family.method, family.witness)

    @property
    def start(self) -> Sequence[Fraction]:
        """All numbers of all bodies at the start."""
        return self.impacts.start

    def gravity(self) -> list[arb] | None:
        """The uniform gravity in balls."""
        if self.impacts.gravity is None:
            return None
        return [arb_of(part) for part in self.impacts.gravity]

    def moment_number(self, k: int) -> Moment:
        """The moment number k, which there must be."""
        moment = self.impacts.number(k)
        assert moment is not None
        return moment

    @per_precision
    def known_after(self) -> list[list[Motion]]:
        """The states in balls right after the first moments, as far as requested."""
        return []

    def starts(self) -> list[Motion]:
        """The states in balls at the start."""
        return motions([arb_of(number) for number in self.start])

    def before(self, k: int = 0) -> list[Motion]:
        """The states in balls right before moment k."""
        moment = self.moment_number(k)
        if k == 0:
            states = self.starts()
        else:
            states = self.after(k - 1)
        gravity = self.gravity()
        return [state.after(arb_of(moment.wait), gravity) for state in states]

    def after(self, k: int = 0) -> list[Motion]:
        """The states in balls right after moment k."""
        known = self.known_after()
        while len(known) <= k:
            number = len(known)
            moment = self.moment_number(number)
            states = self.before(number)
            for encounter, side in zip(moment.encounters, moment.sides, strict=True):
                impact = encounter.impact.in_numbers(arb_of)
                states = encounter.parted(states, impact, is_cut=side > 0)
            known.append(states)
        return known[k]

    def evaluate(self, t: arb) -> dict[str, arb]:
        states = self.starts()
        since = t
        k = 0
        while (moment := self.impacts.number(k)) is not None:
            impact_time = arb_of(moment.time)
            later = t - impact_time
            near = impact_time * arb_of(TOLD_APART)
            if later < -near:
                break
            if not later > near:
                raise UndecidedError(
                    f"t is that of the impact, {impact_time.str(20)} s, at which velocities jump;"
                    " ask for another time, or for another number of samples",
                    code="jump",
                    final=True,
                )
            states = self.after(k)
            since = later
            k += 1
        if k == self.impacts.most:
            self.family.refuse_unlisted(self, t)
        gravity = self.gravity()
        return self.named([state.after(since, gravity) for state in states])

    def constants(self) -> dict[str, arb]:
        """The scalars of the family."""
        return self.family.constants(self)

    @property
    def side_of_limit(self) -> int:
        """1 where Coulomb's law cuts the tangential impulse of the first impact, 0 where it is just
        enough, -1 below, exactly.
        """
        return self.moment_number(0).sides[0]

    def named(self, states: Sequence[Motion]) -> dict[str, arb]:
        """The quantities by name, of some states."""
        numbers = flat(states)
        told = [numbers[place] for place in self.coordinates]
        return dict(zip(self.state, told, strict=True))

    def displaced(self, axis: int, amount: Fraction) -> Self:
        """The motion whose quantity number `axis` is larger by `amount` at the start."""
        start = larger(tuple(self.start), self.coordinates[axis], amount)
        return replace(self, impacts=self.impacts.begun_at(start))

    def energy_lost(self, k: int) -> arb:
        """The energy lost in the impacts of moment k [J]."""
        moment = self.moment_number(k)
        states = self.before(k)
        lost = arb(0)
        for encounter, side in zip(moment.encounters, moment.sides, strict=True):
            lost += work_lost(encounter, states, is_cut=side > 0)
        return lost

    @per_precision
    def growth(self) -> Grows:
        kinks = 0
        if not all(encounter.impact.is_smooth for encounter in self.impacts.encounters):
            kinks = sum(moment.sides.count(0) for moment in self.impacts.all())
        if kinks > MOST_KINKS:
            raise UndecidedError(
                f"friction is just enough in {kinks} impacts; S is known for {MOST_KINKS} at most",
                code="corner",
                final=True,
            )
        size = Norm([1] * len(self.state))
        step = narrow(self.rate_of_flight())
        # S is the largest one of all 2^kinks choices of sides.
        choices: list[Grows] = []
        for sides in product([False, True], repeat=kinks):
            choices.append(Growth(self.stretches(sides), size, step=step))
        return Largest(choices)

    def rate_of_flight(self) -> arb:
        """The largest rate [1/s] at which an error of a velocity, in its scale, moves a place, in
        its own.
        """
        rates = []
        for place, speed in self.flights():
            rates.append(self.ratio(place, speed))
        return arb_of(max(rates))

    def flights(self) -> Iterator[tuple[int, int]]:
        """The number of every reported position among the coordinates, and that of its velocity."""
        for number, place in enumerate(self.coordinates):
            if place % OF_BODY < 3:
                yield number, self.coordinates.index(place + 3)

    def ratio(self, row: int, column: int) -> Fraction:
        """The scale of one coordinate over that of another."""
        return self.scale[self.state[column]] / self.scale[self.state[row]]

    def stretches(self, kinks: Sequence[bool]) -> Iterator[Stretch]:
        """The flights, with the impacts at their ends; for every impact in which friction is just
        sufficient, `kinks` is True if it counts as limited by Coulomb's law.
        """
        count = len(self.state)
        moving = [
            (place, speed, arb_of(self.ratio(place, speed))) for place, speed in self.flights()
        ]

        def flight(t: arb) -> arb_mat:
            derivative = unit_matrix(count)
            # dr(t) = dr(0) + t dv(0), in scales.
            for place, speed, ratio in moving:
                derivative[place, speed] = t * ratio
            return derivative

        coming = iter(kinks)
        begin: Number = Fraction(0)
        k = 0
        while (moment := self.impacts.number(k)) is not None:
            jump = None
            for encounter, side in zip(moment.encounters, moment.sides, strict=True):
                is_cut = side > 0
                if side == 0:
                    is_cut = next(coming)
                across = self.saltation(encounter, self.before(k), is_cut=is_cut)
                # Impacts of different bodies commute.
                if jump is None:
                    jump = across
                else:
                    jump = across * jump
            length = arb_of(moment.wait)
            yield smooth(arb_of(begin), length, flight, jump=jump, affine=True)
            begin = moment.time
            k += 1
        yield smooth(arb_of(begin), None, flight, affine=True)

    def saltation(self, encounter: Encounter, states: Sequence[Motion], *, is_cut: bool) -> arb_mat:
        """The saltation matrix of one impact, in scales.

            Xi = DP (1 + f- tau) - f+ tau

        DP is the derivative of the states after the impact by those before it, f- and f+ are the
        rates of the state before and after it (`rates`), and tau = dt/dx is the derivative of the
        time of impact by the state before it (`time_slopes_of`).
        """
        meeting = encounter.of(states)
        count = OF_BODY * len(meeting)
        sloped = motions(parameters(flat(meeting)))
        impact = encounter.impact.in_numbers(arb_of)
        normal = encounter.meeting.normal([state.r for state in sloped])
        parted = flat(impact.parted(normal, sloped, is_cut=is_cut))
        derivative = arb_mat([list(number.slopes) for number in parted])
        time_slopes = time_slopes_of(encounter, meeting)
        gravity = self.gravity()
        # Xi = DP (1 + f- tau) - f+ tau
        moved = unit_matrix(count) + outer(rates(meeting, gravity), time_slopes)
        after = rates(motions([number.value for number in parted]), gravity)
        raw = derivative * moved - outer(after, time_slopes)
        # The bodies of this impact, among the coordinates that are reported.
        places: dict[int, int] = {}
        for number, body in enumerate(encounter.bodies):
            for part in range(OF_BODY):
                places[OF_BODY * body + part] = OF_BODY * number + part
        scaled = unit_matrix(len(self.state))
        for row, full_row in enumerate(self.coordinates):
            for column, full_column in enumerate(self.coordinates):
                if full_row in places and full_column in places:
                    entry = raw[places[full_row], places[full_column]]
                    scaled[row, column] = entry * arb_of(self.ratio(row, column))
        return scaled


class Largest:
    """S of a motion with kinks: the largest S of the flows for all choices of sides of kinks."""

    def __init__(self, sides: Sequence[Grows]) -> None:
        self.sides = sides

    def at(self, t: Fraction) -> float:
        """The bound S(t) >= 1 on the growth of an error."""
        return max(side.at(t) for side in self.sides)


def work_lost(encounter: Encounter, states: Sequence[Motion], *, is_cut: bool) -> arb:
    """The energy [J] that one impact loses, of the states of all bodies in balls right before it.

        W = (1 - e^2) m_n c^2/2 + (1 - (1 - k/m_t)^2) m_t s^2/2

    with the restitution e, closing speed c, slip s, the impulse k s across the normal, and the
    effective masses m_n along and m_t across the normal.
    """
    meeting = encounter.of(states)
    impact = encounter.impact.in_numbers(arb_of)
    normal = encounter.meeting.normal([state.r for state in meeting])
    closing, slip = impact.approach(normal, meeting)
    slip_squared = dot(slip, slip)
    k = impact.tangential_factor(closing, slip, is_cut=is_cut)
    # normal_factor = (1 + e) m_n, stopping = (1 + b) m_t with the tangential restitution b.
    e = arb_of(encounter.impact.restitution)
    normal_mass = impact.normal_factor / (1 + e)
    tangential_mass = impact.stopping / arb_of(1 + encounter.impact.tangential_restitution)
    left = 1 - k / tangential_mass
    # (1 - e^2) m_n c^2/2 and (1 - (1 - k/m_t)^2) m_t s^2/2
    lost_along = normal_mass * closing * closing * (1 - e * e) / 2
    lost_across = tangential_mass * slip_squared * (1 - left * left) / 2
    return arb(lost_along + lost_across)


def time_slopes_of(encounter: Encounter, meeting: Sequence[Motion]) -> list[arb]:
    """The derivatives of the time of impact by the state right before it: n.(dr2 - dr1)/c."""
    impact = encounter.impact.in_numbers(arb_of)
    normal = encounter.meeting.normal([state.r for state in meeting])
    closing, _ = impact.approach(normal, meeting)
    slopes = [arb(0)] * (OF_BODY * len(meeting))
    for number in range(len(meeting)):
        # dt = n . (dr2 - dr1)/c: the sign is -1 for the first body, 1 for the second one.
        side = 2 * number - 1
        for axis in range(3):
            slopes[OF_BODY * number + axis] = normal[axis] * side / closing
    return slopes


def rates(states: Sequence[Motion], gravity: Sequence[arb] | None) -> list[arb]:
    """The rates of the state in flight: f = (v, g, 0) of each body."""
    falling: Sequence[arb] = [arb(0)] * 3
    if gravity is not None:
        falling = gravity
    found = []
    for state in states:
        found += [*state.v, *falling, *[arb(0)] * 3]
    return found


def outer(column: Sequence[arb], row: Sequence[arb]) -> arb_mat:
    """The matrix of all products of two vectors."""
    return arb_mat([[a * b for b in row] for a in column])
