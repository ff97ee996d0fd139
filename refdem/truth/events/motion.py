"""A motion from mode to mode, at one precision, as far as requested; phases are kept.

The motions of a set enter a mode at times c that need not be equal: c is the clock coordinate of
each at its entry, and its state at the time t is that of its own time t - c since the entry.
"""

from bisect import bisect_right
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

from flint import arb, arb_mat

from refdem.truth.balls import Guarded, UndecidedError, arb_of, ball_of, precision, unit_matrix
from refdem.truth.events.crossing import SwitchError
from refdem.truth.events.phase import Phase
from refdem.truth.events.system import Entry, State, Traced
from refdem.truth.validated_ivp.integration import GUARD, Steps
from refdem.truth.validated_ivp.moved import Spread, at_start

THIN = 2.0**-100
"""The largest radius of a thin set. Where a thin set cannot be followed past a boundary, it is so
close to the boundary that more digits would seldom help.
"""


@dataclass(frozen=True)
class Event:
    """The end of a phase: the guard's name, the mode entered (None: the motion ends), a ball of the
    time [s], and balls of the state after the event and its reset.
    """

    name: str
    mode: str | None
    time: arb
    state: list[arb]


class Followed(Guarded):
    """A motion from mode to mode, as far as it has been followed; phases are kept."""

    def begin(
        self,
        modes: Mapping[str, Traced],
        start: Sequence[arb],
        entry: Entry,
        bits: int,
        steps: Steps | None,
    ) -> None:
        """Enters the first mode, by `entry`, with the set of all states in the balls `start`."""
        self.modes = modes
        self.bits = bits
        self.steps = steps or Steps()
        self.events: list[Event] = []
        self.phases: list[Phase] = []
        self.ended = False
        centre = [value.mid() for value in start]
        self.enter(entry, centre, at_start([value.rad() for value in start]))

    def enter(self, entry: Entry, centre: Sequence[arb], spread: Spread) -> None:
        """Begins the phase of an entry with the set centre + spread, to which its reset has been
        applied; or ends the motion.
        """
        if entry.mode is None:
            self.ended = True
        else:
            self.phases.append(
                Phase(self.modes[entry.mode], entry, centre, spread, self.bits, self.steps)
            )

    def at(self, t: arb) -> list[arb]:
        """Balls of the state at the time t [s]."""
        phase = self.phase(t)
        with precision(self.bits + GUARD):
            # Times of a phase count from each motion's own entry: t - c.
            return phase.at(t - phase.entered[-1])

    def jacobian(self, t: arb) -> arb_mat:
        """Enclosure of the derivative of the state at time t by that at the start."""
        phase = self.phase(t)
        with precision(self.bits + GUARD):
            since = t - phase.entered[-1]
            # (1 - f e^T) V, with the flow Jacobian V since the start at each motion's own time.
            return at_fixed_time(phase, phase.at(since)) * phase.jacobian(since)

    def phase(self, t: arb) -> Phase:
        """The phase in which all motions of the set are at the time t [s]; phases up to it are
        made.

        SwitchError where the motion has ended before t, or t lies within the uncertainty of an
        event.
        """
        while self.is_open(t):
            self.follow()
            if self.is_stopped_before(t):
                raise self.stop()
        clocks = [float(phase.entered[-1].mid()) for phase in self.phases]
        # The clocks are midpoints of balls: t can lie in the phase found by them or next to it.
        nearest = bisect_right(clocks, float(t.mid()))
        for index in range(max(0, nearest - 2), min(len(self.phases), nearest + 2)):
            if self.holds_throughout(index, t):
                return self.phases[index]
        if self.ended and self.events and t > self.events[-1].time:
            last = self.events[-1]
            message = f"the motion ends with {last.name}"
            raise SwitchError("end", message, float(t.mid())).at(last.state)
        states_before = [phase.entered for phase in self.phases if phase.entered[-1] < t]
        if states_before:
            certified = states_before[-1]
        else:
            certified = self.phases[0].entered
        message = f"t = {t.str(8)} s lies within the uncertainty of an event"
        raise SwitchError("precision", message, float(t.mid())).at(certified)

    def holds_throughout(self, index: int, t: arb) -> bool:
        """True if every motion of the set is in the phase of that number at t."""
        phase = self.phases[index]
        if index == 0:
            has_begun = t >= phase.entered[-1]
        else:
            has_begun = t > phase.entered[-1]
        return has_begun and (phase.ends is None or t < self.end_of(index))

    def reached(self) -> Fraction:
        """The time [s], about, up to which the motion has been followed."""
        last = self.phases[-1]
        return ball_of(last.entered[-1]).mid + last.searched

    def over(self) -> bool:
        """True if nothing is left to follow: the motion ended, or its last phase never does."""
        return self.ended or self.phases[-1].never

    def is_stopped_before(self, t: arb) -> bool:
        """True if every motion of the set has been proved to run into a singularity before t."""
        phase = self.phases[-1]
        if phase.stopped is None:
            return False
        # True where t is later than every time in the ball of the sum.
        return bool(t > phase.entered[-1] + phase.stopped)

    def stop(self) -> SwitchError:
        """The end of a motion whose last phase has been proved to stop."""
        phase = self.phases[-1]
        assert phase.stopped is not None
        stopped = phase.entered[-1] + phase.stopped
        time = float(stopped.upper())
        message = f"the motion runs into a singularity by t = {time:.8g} s"
        return self.with_last_state(phase, SwitchError("singular", message, time))

    def is_open(self, t: arb) -> bool:
        """True if the last phase has not been followed past t."""
        phase = self.phases[-1]
        if self.over():
            return False
        if phase.ends is not None:
            return not t < self.end_of(len(self.phases) - 1)
        # No guard has a zero up to `searched`, a time since the entry.
        return not arb_of(phase.searched) > t - phase.entered[-1]

    def end_of(self, index: int) -> arb:
        """The time at which the phase of that number ends.

        It is known also for an event that could not be passed, so that times before it stay
        certified.
        """
        if index < len(self.events):
            return self.events[index].time
        phase = self.phases[index]
        assert phase.ends is not None
        return phase.entered[-1] + phase.ends[1]

    def follow(self) -> None:
        """Follows the last phase by a window, or through the event that ends it.

        SwitchError, with the last certified state, where that is not proved.
        """
        phase = self.phases[-1]
        try:
            if phase.ends is None:
                phase.search()
            if phase.ends is not None:
                self.pass_event(phase)
        except SwitchError as error:
            raise self.with_last_state(phase, error) from None
        except UndecidedError as error:
            if phase.stopped is not None:
                raise self.stop() from None
            ended = SwitchError(error.code, str(error), float(phase.searched))
            raise self.with_last_state(phase, ended) from None

    def pass_event(self, phase: Phase) -> None:
        """Moves the set through the event that ends a phase, into the next mode."""
        guard, _, _, states = phase.crossing()
        with precision(self.bits + GUARD):
            entry = guard.then(states)
        centre, spread = phase.after(entry)
        self.enter(entry, centre, spread)
        radii = spread.radii()
        with precision(self.bits + GUARD):
            state = [value + arb(0, radius) for value, radius in zip(centre, radii, strict=True)]
        self.events.append(Event(guard.name, entry.mode, state[-1], state))

    def with_last_state(self, phase: Phase, error: SwitchError) -> SwitchError:
        """The same error with the state at the last time of the phase that is certified."""
        with precision(self.bits + GUARD):
            if phase.pieces:
                state = phase.at(arb_of(min(phase.searched, phase.pieces[-1].end)))
            else:
                state = phase.entered
        return error.at(state, thin=all(radius < THIN for radius in phase.spread.radii()))


class HybridMotion(Followed):
    """The motion of the set about `start` (balls at the working precision) that begins with
    `entry`.
    """

    def __init__(
        self,
        modes: Mapping[str, Traced],
        start: Sequence[arb],
        entry: Entry,
        bits: int,
        steps: Steps | None = None,
    ) -> None:
        self.begin(modes, start, entry, bits, steps)


def first_entry(first: Callable[[State], Entry], start: State) -> Entry:
    """The entry `first(start)`; where it is not decided by balls, the SwitchError has the start as
    its last certified state.
    """
    try:
        return first(start)
    except SwitchError as error:
        raise error.at(start) from None


def at_fixed_time(phase: Phase, state: Sequence[arb]) -> arb_mat:
    """The matrix 1 - f e^T, which turns errors at one time since each motion's own entry into
    errors at one time t.

    e is the unit vector of the clock, the last coordinate. A motion that enters later by dc has
    moved for a time shorter by dc, which changes its state at t by -f dc. `state` has balls of the
    states, at which the field f is evaluated.
    """
    rates = phase.field.run(state)
    size = phase.mode.size
    # f e^T: the field in the column of the clock.
    by_clock = arb_mat(size, size)
    for i, rate in enumerate(rates):
        by_clock[i, size - 1] = rate
    return unit_matrix(size) - by_clock
