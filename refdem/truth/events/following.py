"""A motion through events that is followed for a forecast of what its proof costs (forecast.py)."""

from fractions import Fraction

from flint import arb

from refdem.truth.balls import UndecidedError, arb_of, largest, precision
from refdem.truth.events.motion import Followed
from refdem.truth.events.scout import PROBES, EventScout, can_be_scouted
from refdem.truth.forecast import FEW_PIECES, SCOUTED_SHARE, Course, seconds_themselves
from refdem.truth.validated_ivp.integration import GUARD


class Following:
    """The motion and the course on which its steps are marked.

    The work left of a motion that can be scouted is estimated by its scout, which has entered the
    later modes before; that of another motion by its cycles so far. The motion is followed to `t`
    (by its own clock); `is_final` is True if it ended before, in a way that more bits do not
    change.
    """

    def __init__(self, motion: Followed, course: Course, t: Fraction) -> None:
        self.motion = motion
        self.t = t
        self.course = course
        self.scout: EventScout | None = None
        # The largest ratio so far of the radius that `at` gives to that of the set.
        self.excess = arb(1)
        self.is_final = False
        self.is_scouted = can_be_scouted(motion)
        course.has_events = not self.is_scouted

    def step(self) -> bool:
        """Follows the motion by one window; False where it is over or cannot be followed."""
        passed = len(self.motion.events)
        try:
            self.motion.follow()
        except UndecidedError as error:
            self.is_final = error.final
            return False
        if self.motion.is_stopped_before(arb_of(self.t)):
            self.is_final = True
            return False
        # The mark of this step is added after the step and gets this number.
        number = len(self.course.marks)
        self.course.entries += [(event.mode, number) for event in self.motion.events[passed:]]
        return not self.motion.over()

    def state(self) -> tuple[Fraction, int, arb]:
        """The time [s] reached, the pieces made, and the radius that `at` is expected to give.

        That is the radius of the set times the largest ratio of both radii so far: the ratio
        depends on the mode, and t may lie in another one.
        """
        motion = self.motion
        pieces = sum(len(phase.pieces) for phase in motion.phases)
        of_set = largest(motion.phases[-1].spread.radii())
        read = read_radius(motion)
        # The radius of the set times the largest ratio of both radii so far.
        if of_set > 0:
            self.excess = max(self.excess, read / of_set)
            read = of_set * self.excess
        return motion.reached(), pieces, read

    def look_ahead(self, steps: int) -> None:
        """Advances the scout by so many steps, up to t, once the motion has PROBES pieces.

        Where the scout has reached t, few pieces suffice for a forecast. If it cannot continue (a
        Taylor series that terminates has no finite radius of convergence), the remaining work is
        estimated by cycles.
        """
        if not self.is_scouted:
            return
        if self.scout is None and len(self.motion.phases[-1].pieces) >= PROBES:
            self.scout = EventScout(self.motion)
        if self.scout is None:
            return
        t = float(self.t)
        self.scout.go_on(steps, t)
        course = self.course
        if self.scout.is_over or self.scout.times[-1] >= t:
            course.least = FEW_PIECES
            course.share = SCOUTED_SHARE
        elif self.scout.ended:
            self.is_scouted = False
            course.has_events = True
            course.clock = seconds_themselves
            return
        course.clock = self.scout.clock


def read_radius(motion: Followed) -> arb:
    """The largest radius of a state that `at` gives at the end of what has been followed: within a
    piece the set is bounded by Gronwall's inequality, which gives more than the set at its end.
    """
    phase = motion.phases[-1]
    if not phase.pieces:
        return largest(phase.spread.radii())
    piece = phase.pieces[-1]
    with precision(phase.bits + GUARD):
        state = piece.at(arb_of(piece.length))
    return largest([value.rad() for value in state])
