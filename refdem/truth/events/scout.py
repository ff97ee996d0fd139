"""A motion through events followed ahead of its proof, without radii: which modes it comes through,
and how many pieces a proof will make in each.

A mode has a number of pieces to a step of its scout (refdem/truth/scout.py) that is its own: about
one where a box flies, eight where a corner of it slides. So the first pieces of each mode are made
from the place where the scout enters it, and counted. No proof depends on it.
"""

from bisect import bisect_right
from collections.abc import Sequence
from operator import itemgetter

from flint import arb

from refdem.truth.balls import UndecidedError, arb_of, precision
from refdem.truth.events.motion import Followed
from refdem.truth.events.phase import Phase
from refdem.truth.events.system import Entry, Guard, Traced
from refdem.truth.scout import BITS, Scout
from refdem.truth.traced_field import Program, traced
from refdem.truth.validated_ivp.moved import at_start

LOOKS = 4
"""Places in a step at which guards are evaluated: two zeros between them are missed."""
HALVINGS = 40
"""The number of bisections of the part of a step in which a guard changes its sign."""
PROBES = 2
"""Pieces that are made in a mode to find the number of pieces per step."""


def can_be_scouted(motion: Followed) -> bool:
    """Whether all modes of a motion are integrated: a mode whose end has a closed form takes nearly
    no time, so that the work of such a motion is forecast by its cycles.
    """
    return not any(traced.mode.leaves for traced in motion.modes.values())


class EventScout:
    """The steps of a motion from the place that its proof has reached, which has made PROBES pieces
    of its mode there.

    `times` [s] has the ends of the steps, `pieces` the forecast number of pieces up to each.
    `ended` is True if no step follows the last one; `is_over` if the motion ends there, or is
    singular.
    """

    def __init__(self, motion: Followed) -> None:
        self.motion = motion
        # The number of pieces in a step, by the id of the mode.
        self.pieces_per_step: dict[int, float] = {}
        self.ended = False
        self.is_over = False
        phase = motion.phases[-1]
        self.times = [float(motion.reached())]
        self.pieces = [0.0]
        # The last piece may extend beyond an event that has not been searched for.
        with precision(phase.bits):
            state = phase.at(arb_of(phase.searched))
        self.enter(phase.mode, Entry(None), state)

    def enter(self, mode: Traced, entry: Entry, state: Sequence[arb]) -> None:
        """Goes on in a mode from a state, which has no radii."""
        self.mode = mode
        self.entry = entry
        self.scout = Scout(mode.field, mode.slopes, state, self.times[-1], range(len(state)))
        self.state = self.scout.y
        self.pieces_at_entry = self.pieces[-1]

    def go_on(self, steps: int, t: float) -> None:
        """Makes so many steps more, fewer where the time t [s] is reached or the motion ends."""
        for _ in range(steps):
            if self.ended or self.times[-1] >= t:
                break
            try:
                self.advance()
            except UndecidedError:
                self.ended = True
            if self.is_stopped_before(t):
                self.ended = True
                self.is_over = True

    def is_stopped_before(self, t: float) -> bool:
        """Whether the motion from the place that the scout has reached is proved to run into a
        singularity before t [s], so that a proof goes no further.
        """
        stops = self.mode.mode.stops
        if stops is None:
            return False
        since = stops(self.scout.y)
        return since is not None and self.times[-1] + float(since) < t

    def advance(self) -> None:
        """Makes a step, or the part of one up to an event, which it passes."""
        scout = self.scout
        steps_before = len(scout.times)
        scout.advance()
        self.ended = scout.ended
        self.is_over = scout.is_singular
        if len(scout.times) == steps_before:
            return
        length = scout.times[-1] - scout.times[-2]
        with precision(BITS):
            event = self.event_in(length)
            if event is None:
                self.note(length, length)
            else:
                guard, since = event
                self.note(since, length)
                self.pass_event(guard, self.state_after(since))

    def note(self, length: float, whole: float) -> None:
        """Notes `length` [s] of a step that is `whole` [s] long, and its pieces."""
        mode = id(self.mode)
        if mode not in self.pieces_per_step:
            # Pieces per second in the probe times the length of the step [s].
            self.pieces_per_step[mode] = pace_of(self.probed(length)) * whole
        self.times.append(self.times[-1] + length)
        # A part of a step counts in proportion to its length.
        self.pieces.append(self.pieces[-1] + self.pieces_per_step[mode] * length / whole)

    def probed(self, length: float) -> Phase:
        """The first pieces in the mode that has been entered, as a proof makes them there; what
        `length` [s] does not need is not made.
        """
        last = self.motion.phases[-1]
        if self.mode is last.mode and len(last.pieces) >= PROBES:
            return last
        spread = at_start(last.spread.radii())
        probe = Phase(self.mode, self.entry, self.state, spread, last.bits, last.steps)
        while len(probe.pieces) < PROBES and probe.end < length:
            probe.advance()
        return probe

    def event_in(self, length: float) -> tuple[Guard, float] | None:
        """The guard that changes its sign first in the last step, of that length [s], and the time
        [s] since its start; None if none is seen to.
        """
        before = 0.0
        for look in range(1, LOOKS + 1):
            after = length * look / LOOKS
            # A guard is positive inside its mode.
            guards = [guard for guard in self.mode.mode.guards if self.is_past(guard, after)]
            if guards:
                crossings = [(self.crossing(guard, before, after), guard) for guard in guards]
                since, guard = min(crossings, key=itemgetter(0))
                return guard, since
            before = after
        return None

    def is_past(self, guard: Guard, since: float) -> bool:
        """Whether a guard is negative `since` [s] after the start of the last step."""
        value = self.mode.rates[guard.name][0].run(self.state_after(since))[0]
        return bool(value < 0)

    def crossing(self, guard: Guard, before: float, after: float) -> float:
        """The time [s] in the last step at which a guard changes its sign, by bisection."""
        for _ in range(HALVINGS):
            middle = (before + after) / 2
            if self.is_past(guard, middle):
                after = middle
            else:
                before = middle
        return after

    def state_after(self, since: float) -> list[arb]:
        """The state `since` [s] after the start of the last step."""
        return self.scout.moved_on(self.scout.polynomials, since)

    def pass_event(self, guard: Guard, state: Sequence[arb]) -> None:
        """Enters the next mode through a guard. A phase has at least one piece."""
        self.pieces[-1] = max(self.pieces[-1], self.pieces_at_entry + 1)
        entry = guard.then(state)
        if entry.mode is None:
            self.ended = True
            self.is_over = True
            return
        if entry.reset is not None:
            outputs, _ = traced(entry.reset, len(state))
            state = Program(outputs).run(state)
        self.ended = False
        self.enter(self.motion.modes[entry.mode], entry, [value.mid() for value in state])

    def clock(self, t: float) -> float:
        """About how many pieces a proof makes from the place where the scout began to the time t
        [s], less than none before it; beyond the last step at the pace of the later half.
        """
        times = self.times
        last = len(times) - 1
        if not last:
            return t
        if t > times[-1] and self.is_over:
            return self.pieces[-1]
        if t > times[-1]:
            # From the last step that begins in the first half of the time.
            first = bisect_right(times, (times[0] + times[-1]) / 2) - 1
            second = last
        else:
            second = max(1, min(bisect_right(times, t), last))
            first = second - 1
        pace = (self.pieces[second] - self.pieces[first]) / (times[second] - times[first])
        # Linear in t between the ends of two steps, or beyond the last one.
        return self.pieces[second] + pace * (t - times[second])


def pace_of(phase: Phase) -> float:
    """Pieces a second of a phase so far."""
    return len(phase.pieces) / float(phase.end)
