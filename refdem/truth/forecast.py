"""Forecast of the CPU time of a motion that is integrated.

A part of the motion is integrated, and the rest is extrapolated by the number of pieces per unit of
time in the later half of that part. If a scout has integrated the motion ahead without radii
(scout.py, events/scout.py), time is replaced by the number of its steps. A motion through events
that has no scout is extrapolated by whole cycles, from entry to entry into one mode, since each
mode has its own number of pieces per unit of time.

The forecast itself may take long, so that a listener (`told_to`) gets every forecast on the way,
from a rough one after the first piece on. The first pieces are not representative where the motion
begins with a fast transient. The pieces that are made are kept, so that a forecast adds nothing to
the time of the proof. Work is counted in pieces, and a piece takes the mean time of those so far.
"""

from bisect import bisect_right
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field, replace
from fractions import Fraction
from math import log2
from time import process_time

from flint import arb

SHARE = 8
"""A forecast integrates the part 1/SHARE of the motion."""
SCOUTED_SHARE = 24
"""The same if a scout has the pieces of all modes ahead of the proof."""
PIECES = 16
"""The least number of pieces that are made for a forecast."""
WITHOUT_CYCLE = 4 * PIECES
"""The least number of pieces of a motion through events that has not completed a cycle."""
LINEAR_BITS = 128
"""B1 in the cost of a piece at b bits, 1 + b/B1 + (b/B2)^2, in units of the part that does not
depend on b.

Measured from 64 to 1536 bits for seven motions, each within a factor of 1.7 of its own cost. A
single power of b is 2 to 3 times too high from 96 to 384 bits, which motions that lose many bits
need.
"""
QUADRATIC_BITS = 220
"""B2 in the same cost."""
TOO_LARGE = -24.0
"""log2 of the largest radius of a set that can still be enclosed."""
UNSURE = 4.0
"""Bits by which the radius that is read differs from piece to piece."""
UNSURE_PART = 0.25
"""The relative uncertainty of the forecast growth of a radius.

If it is not known whether more bits are needed, half of the work with more bits is counted, which
is within a factor of 2.5 of either case; all or none of it may be wrong by their whole ratio.
"""
TRIES = 8
"""The most precisions that are considered."""

HOPELESS = 86400.0
"""Seconds, a day: forecasts of longer times need not be sharp, since the proof will not be run."""
FEW_PIECES = 4
"""The least number of pieces of any forecast: fewer may lie in a fast transient at the start."""
FAR_BEYOND = 1000
"""Factor on HOPELESS beyond which a forecast is accepted after FEW_PIECES."""

NextBits = Callable[[int, float | None], int | None]
"""The next precision [bit] after one that did not suffice, from that and the missing bits (None:
the motion was not followed to its end); None if there is no next one.
"""

Clock = Callable[[float], float]
"""A monotonic function of the time [s], in which the number of pieces is about linear."""
Swelling = Callable[[float], float]
"""log2 of the growth of an error from the start to a time by the clock."""

Listener = Callable[[float], None]
"""A function that is called with the expected CPU seconds that are left."""

_LISTENER: ContextVar[Listener | None] = ContextVar("listener", default=None)


@contextmanager
def told_to(listener: Listener) -> Iterator[None]:
    """Within this context a forecast reports to `listener` how many seconds it expects: after one
    piece of the motion, after two, four, eight, and so on.
    """
    before = _LISTENER.set(listener)
    try:
        yield
    finally:
        _LISTENER.reset(before)


def heavier(bits: int, than: int) -> float:
    """The ratio of the times of a piece with so many bits and of one with `than` bits."""

    def cost(b: int) -> float:
        return 1 + b / LINEAR_BITS + (b / QUADRATIC_BITS) ** 2

    return cost(bits) / cost(than)


@dataclass(frozen=True)
class Mark:
    """How far a motion has been followed: the time reached, pieces and CPU seconds since the start,
    log2 of the set's radius.
    """

    time: float
    pieces: int
    seconds: float
    radius: float


def seconds_themselves(t: float) -> float:
    """The clock of a motion that has none: the time [s]."""
    return t


def no_swelling(t: float) -> float:
    """The swelling of a motion that foresees none: always 0."""
    return 0.0


@dataclass
class Course:
    """A motion as far as it was followed at some precision.

    At least `least` pieces, and the part 1/`share` of the rest, are made before a forecast is used.
    `clock` maps a time [s] to one in which the cost of the motion is uniform, and all times of the
    methods are in it. `swelling` predicts the growth of an existing error. `entries` has, for each
    event passed, the mode that it entered and the number of the mark there; `has_events` is True if
    there may be events that no clock predicts.
    """

    bits: int
    marks: list[Mark] = field(default_factory=list)
    clock: Clock = seconds_themselves
    swelling: Swelling = no_swelling
    has_events: bool = False
    least: int = PIECES
    share: int = SHARE
    entries: list[tuple[str | None, int]] = field(default_factory=list)

    def cycle_entries(self) -> list[Mark]:
        """The marks at the entries into the mode that has been entered most often, of those the
        last one to be entered; empty if no mode was entered twice, or if a clock predicts the
        events.
        """
        if not self.has_events:
            return []
        by_mode: dict[str | None, list[Mark]] = {}
        for mode, number in self.entries:
            by_mode.setdefault(mode, []).append(self.marks[number])
        most = max(by_mode.values(), key=lambda marks: (len(marks), marks[-1].time), default=[])
        if len(most) < 2:
            return []
        return most

    def has_pace(self) -> bool:
        """Whether what was followed shows the pace of the motion: of one through events, a cycle,
        or many pieces.
        """
        made = self.marks[-1].pieces - self.marks[0].pieces
        return not self.has_events or made >= WITHOUT_CYCLE or bool(self.cycle_entries())

    def thin(self) -> list[Mark]:
        """The marks before the set became too large: what it does from there on, more and more
        pieces for less and less time, a proof with more bits does not.
        """
        count = next(
            (number for number, mark in enumerate(self.marks) if mark.radius > TOO_LARGE),
            len(self.marks),
        )
        if count < 2:
            return self.marks
        return self.marks[:count]

    def later_half(self) -> tuple[Mark, Mark]:
        """The mark at which half of the time had passed, and the last one, both by the clock; those
        at the entries into one mode where there are cycles.
        """
        marks = self.cycle_entries() or self.thin()
        last = replace(marks[-1], time=self.clock(marks[-1].time))
        middle = (self.clock(marks[0].time) + last.time) / 2
        # The marks are in rising order of time, and of their times by the clock.
        number = bisect_right(marks, middle, key=lambda mark: self.clock(mark.time))
        half = marks[max(0, number - 1)]
        return replace(half, time=self.clock(half.time)), last

    def pieces_to(self, t: float) -> float:
        """How many pieces are left, at the pace of the later half."""
        half, last = self.later_half()
        passed = last.time - half.time
        if passed <= 0:
            return 0.0
        return (last.pieces - half.pieces) * max(0.0, t - last.time) / passed

    def pieces_since(self) -> int:
        """How many pieces were made since the last entry, from which the pace is counted on."""
        return self.marks[-1].pieces - self.later_half()[1].pieces

    def growth_to(self, t: float) -> float:
        """log2 of the growth of the radius per unit of the clock, from the last mark to t.

        An existing error grows as `swelling` predicts. The errors that a proof adds, its own and
        those by sets that wrap the motion, continue to grow at the rate of the later half.
        """
        half, last = self.later_half()
        passed = last.time - half.time
        ahead = t - last.time
        growth = 0.0
        # The first pieces of a set that begins as a point do not show how it grows.
        made = self.marks[-1].pieces - self.marks[0].pieces
        if passed > 0 and made >= PIECES:
            swelled = self.swelling(last.time) - self.swelling(half.time)
            # The growth per unit of the clock, less that of an existing error.
            growth = (last.radius - half.radius - swelled) / passed
        if ahead > 0:
            growth += (self.swelling(t) - self.swelling(last.time)) / ahead
        return growth

    def radius_at(self, t: float) -> float:
        """log2 of the radius that is foreseen at t."""
        last = self.later_half()[1]
        return last.radius + self.growth_to(t) * max(0.0, t - last.time)

    def time_of(self, radius: float, t: float) -> float:
        """When the radius is that large, at the rate of growth to t; infinite if never."""
        last = self.later_half()[1]
        growth = self.growth_to(t)
        if growth > 0:
            return last.time + (radius - last.radius) / growth
        return float("inf")

    def work_to(self, t: float, target: float, next_bits: NextBits) -> float:
        """Pieces of this precision that are left until the radius at t [s] is 2^target, those of
        higher precisions at their own weight.
        """
        last = self.later_half()[1]
        t = self.clock(t)
        bits = self.bits
        end = min(t, max(last.time, self.time_of(TOO_LARGE, t)))
        work = max(0.0, self.pieces_to(end) - self.pieces_since())
        chance = 1.0
        for _ in range(TRIES):
            # log2 of the radius is smaller by the number of additional bits.
            thinner = bits - self.bits
            ends = self.time_of(TOO_LARGE + thinner, t) < t
            lacking = self.radius_at(t) - thinner - target
            if not ends:
                chance *= self.chance_of_lacking(lacking, t)
            if not chance:
                break
            more = next_bits(bits, None if ends else max(0.0, lacking))
            if more is None:
                break
            bits = more
            reached = min(t, self.time_of(TOO_LARGE + bits - self.bits, t))
            pieces = last.pieces + self.pieces_to(reached)
            work += chance * pieces * heavier(bits, self.bits)
        return work

    def chance_of_lacking(self, lacking: float, t: float) -> float:
        """The part of the work with more bits that is counted where that many bits are foreseen to
        be lacking at t: rising from 0 to 1 where the two differ by no more than the forecast does.
        """
        last = self.later_half()[1]
        # (1 + lacking/unsure)/2, between 0 and 1.
        unsure = UNSURE + UNSURE_PART * abs(self.radius_at(t) - last.radius)
        return min(1.0, max(0.0, (1.0 + lacking / unsure) / 2))

    def is_enough(self, made: int, left: float, seconds: float) -> bool:
        """True if the pieces `made` suffice to estimate what is `left` [pieces, CPU seconds]."""
        if made < self.least:
            return made >= FEW_PIECES and seconds > FAR_BEYOND * HOPELESS
        return made * self.share >= left or seconds > HOPELESS

    def seconds_for(self, work: float) -> float:
        """CPU seconds for so many pieces, at what those so far took."""
        half, last = self.later_half()
        pieces = last.pieces - half.pieces
        if pieces:
            return work * (last.seconds - half.seconds) / pieces
        return 0.0


def follow(
    course: Course,
    state: Callable[[], tuple[Fraction, int, arb]],
    step: Callable[[], bool],
    t: Fraction,
    work: Callable[[], float],
) -> None:
    """Follows a motion by steps, marking each, until t, until `step` returns False, or until enough
    is known.

    `state` has the time reached, the pieces made and the radius of the set; `work` is the remaining
    work by the course, in pieces.
    """
    spent = 0.0
    tell = _LISTENER.get() or (lambda seconds: None)
    telling = 1

    def mark() -> Mark:
        reached, pieces, radius = state()
        if 1e-300 < float(radius) < 1e300:
            size = log2(float(radius))
        else:
            size = -1000.0
        return Mark(float(reached), pieces, spent, size)

    def timed_step() -> bool:
        """Makes a step, and counts what it took: not what `work` takes."""
        nonlocal spent
        begun = process_time()
        goes_on = step()
        spent += process_time() - begun
        return goes_on

    course.marks.append(mark())
    while course.marks[-1].time < t and timed_step():
        course.marks.append(mark())
        pieces_made = course.marks[-1].pieces - course.marks[0].pieces
        left = work()
        seconds = course.seconds_for(left)
        if pieces_made >= telling:
            tell(seconds)
            telling = 2 * pieces_made
        if course.has_pace() and course.is_enough(pieces_made, left, seconds):
            break
