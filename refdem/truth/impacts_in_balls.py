"""The list of impacts of free round bodies in balls, where every impact brings a square root of its
own.

The pair that meets next is the one whose ball of times lies before those of all others. Every such
comparison holds for whole balls; where one does not, UndecidedError is raised and the precision is
increased. So the order of the list is proved at every precision at which there is a list. Balls
never prove that two times are equal: motions in which they are, as in a rack that is hit along its
line of symmetry, end with this error at every precision.
"""

from collections.abc import Sequence
from fractions import Fraction

from flint import arb, ctx

from refdem.truth.balls import UndecidedError, arb_of
from refdem.truth.impact_sequence import Encounter, Moment, motions
from refdem.truth.rigid_impact import Motion
from refdem.truth.surds import sign


class GrazingError(UndecidedError):
    """Raised if balls do not decide whether bodies collide or pass each other; a collision is not
    before `earliest` [s].

    It does not matter where another impact of theirs comes first.
    """

    def __init__(self, earliest: arb) -> None:
        super().__init__(
            "whether two spheres meet or pass each other is not decided", code="grazing"
        )
        self.earliest = earliest


class ImpactsInBalls:
    """The impacts of free bodies that start so, in order, up to `most` moments: one list for each
    working precision, made as far as requested.
    """

    gravity = None

    def __init__(
        self, encounters: Sequence[Encounter], start: Sequence[Fraction], most: int
    ) -> None:
        self.encounters = encounters
        self.start = start
        self.most = most
        self.lists: dict[int, _ListOfPrecision] = {}

    def begun_at(self, start: Sequence[Fraction]) -> "ImpactsInBalls":
        """The list of the same bodies from another start."""
        return ImpactsInBalls(self.encounters, start, self.most)

    def number(self, k: int) -> Moment | None:
        """The moment number k, from 0, at the working precision; None if bodies meet at fewer of
        them.
        """
        bits = ctx.prec
        if bits not in self.lists:
            self.lists[bits] = _ListOfPrecision(self.encounters, self.start)
        known = self.lists[bits]
        while len(known.moments) <= min(k, self.most - 1) and not known.is_complete:
            known.follow()
        if k < len(known.moments):
            return known.moments[k]
        return None

    def all(self) -> list[Moment]:
        """All moments at the working precision, up to `most`."""
        k = 0
        found = []
        while (moment := self.number(k)) is not None:
            found.append(moment)
            k += 1
        return found


class _ListOfPrecision:
    """The list at one working precision.

    `states` are those right after the last moment, which was at `now` [s]. `coming` has the times
    [s] of the meetings of pairs as they move now, `doubtful` the earliest ones of those that may
    pass each other; an impact changes those of its own bodies.
    """

    def __init__(self, encounters: Sequence[Encounter], start: Sequence[Fraction]) -> None:
        self.encounters = encounters
        self.states = motions([arb_of(number) for number in start])
        self.now = arb(0)
        self.moments: list[Moment] = []
        self.is_complete = False
        self.coming: dict[int, arb] = {}
        self.doubtful: dict[int, arb] = {}
        self.ask_again(range(len(self.states)))

    def ask_again(self, bodies: Sequence[int]) -> None:
        """Looks anew for the meetings of some bodies, from the states as they are."""
        for number, encounter in enumerate(self.encounters):
            if not set(bodies) & set(encounter.bodies):
                continue
            self.coming.pop(number, None)
            self.doubtful.pop(number, None)
            try:
                wait = encounter.meeting.time(encounter.of(self.states))
            except GrazingError as grazing:
                self.doubtful[number] = self.now + grazing.earliest
                continue
            if wait is not None:
                self.coming[number] = self.now + wait

    def earliest(self) -> int:
        """The number of the pair whose ball of times has the smallest midpoint."""
        numbers = list(self.coming)
        first = numbers[0]
        for number in numbers[1:]:
            if self.coming[number].mid() < self.coming[first].mid():
                first = number
        return first

    def follow(self) -> None:
        """Appends the moment after the last one, or finds that there is none; UndecidedError if
        balls do not decide which impact is the next one.
        """
        if not self.coming and not self.doubtful:
            self.is_complete = True
            return
        if not self.coming:
            raise GrazingError(next(iter(self.doubtful.values())))
        # This moment is proved to be the next one if its ball of times lies before all others.
        number = self.earliest()
        time = self.coming[number]
        encounter = self.encounters[number]
        for other, later in self.coming.items():
            if other == number or time < later:
                continue
            rival = self.encounters[other].bodies
            raise UndecidedError(
                f"bodies {_words(encounter.bodies)} and bodies {_words(rival)} meet at times of"
                f" which no ball tells which is the first, near t = {time.str(8)} s",
                code="corner",
            )
        # A pair that may pass each other does not matter if it cannot meet before this moment.
        for earliest in self.doubtful.values():
            if not time < earliest:
                raise GrazingError(earliest)
        wait = time - self.now
        if sign(wait) <= 0:
            raise UndecidedError("an impact comes at the time of the one before it", code="corner")
        arrived = [state.after(wait) for state in self.states]
        impact = encounter.impact.in_numbers(arb_of)
        side = _side_of_limit(encounter, arrived)
        self.states = encounter.parted(arrived, impact, is_cut=side > 0)
        self.moments.append(Moment(time, wait, arrived, (encounter,), (side,)))
        self.now = time
        self.ask_again(encounter.bodies)


def _side_of_limit(encounter: Encounter, states: Sequence[Motion]) -> int:
    """1 where Coulomb's law cuts the tangential impulse, -1 where less of it is enough."""
    meeting = encounter.of(states)
    impact = encounter.impact.in_numbers(arb_of)
    normal = encounter.meeting.normal([state.r for state in meeting])
    return impact.excess(*impact.approach(normal, meeting))


def _words(bodies: Sequence[int]) -> str:
    """The numbers of bodies in words."""
    return " and ".join(str(body) for body in bodies)
