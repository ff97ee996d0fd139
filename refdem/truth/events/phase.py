"""One stay in a mode: its pieces, the search for the event that ends it, and the set after that
event.

Theorem (hand-over): let every motion of the set c + {A r} cross the section g = 0 once, at a time
in T, and let V, f, grad g and the reset's Jacobian R enclose the flow Jacobian and these functions
at all those crossings. Then the map E from the set to the states after the event is differentiable,
with a Jacobian in

    X = R (1 - f grad g^T/(grad g . f)) V,

so that by the mean value theorem E(c + A r) is in E(c) + X A r, as over a step (moved.py). The
crossing of the single motion from c, and with it E(c), has a far smaller ball than those of the
set. The uncertainty of the time of the event is carried by the clock coordinate.
"""

from collections.abc import Sequence
from fractions import Fraction

from flint import arb, arb_mat

from refdem.truth.balls import arb_of, ball_of, precision, unit_matrix
from refdem.truth.events.crossing import Along, SwitchError, Watched, earliest, only_zero
from refdem.truth.events.system import Entry, Guard, Traced, unchanged
from refdem.truth.traced_field import Program, traced
from refdem.truth.validated_ivp.integration import GUARD, Chain, Piece, Steps
from refdem.truth.validated_ivp.moved import BITS, Spread, moved

RETRIES = 4
"""Tries of a window whose end lies too near a zero of a guard: each is shorter than the last."""
SHORTER = Fraction(7, 8)
"""The ratio of the widths of a window at successive tries."""
BEYOND = Fraction(1, 64)
"""The least width of a window as a part of its piece. A window may extend beyond the end of the
piece, where a zero may lie exactly, but not beyond the disc.
"""


class Phase(Chain):
    """The motions of the set centre + spread from their entries into a mode; times are those since
    each motion's own entry.

    `searched` is the time up to which no guard has a zero; `ends` is the guard that ends the phase
    with a ball of the time at which it does, once it is found; `never` is True if no guard ends it.
    `entered` has balls of the state at the entry, with the clock last. `stopped` bounds the time by
    which every motion has run into a singularity of the field, once that is proved.
    """

    def __init__(
        self,
        mode: Traced,
        entry: Entry,
        centre: Sequence[arb],
        spread: Spread,
        bits: int,
        steps: Steps,
    ) -> None:
        self.bits = bits
        self.steps = steps
        self.mode = mode
        self.touching = dict(entry.touching)
        self.field = mode.field
        self.slopes = mode.slopes
        if mode.directions:
            # The parameters, and the clock after them.
            self.steady = len(mode.directions) + 1
        self.centre = list(centre)
        self.spread = spread
        self.begin()
        self.searched = Fraction(0)
        self.entered = self.hull_at_entry()
        self.never = False
        self.ends: tuple[Guard, arb] | None = None
        self.stopped: arb | None = None
        self.exit = arb_mat(0, 0)

    def hull_at_entry(self) -> list[arb]:
        """Balls of the state of every motion at its entry."""
        with precision(self.bits + GUARD):
            return self.spread.around(self.centre)

    def search(self) -> None:
        """Looks for the event in the next window; sets `ends` or `never`, or moves `searched` on.

        SwitchError where neither a zero nor its absence is proved.
        """
        if not self.pieces:
            self.advance()
            if self.mode.mode.leaves:
                self.leave()
                return
        if self.searched >= self.pieces[-1].end:
            self.look_for_stop()
            self.advance()
        piece = self.pieces[-1]
        rest = max(piece.end - self.searched, piece.length * BEYOND)
        width = min(self.mode.mode.window, rest)
        for attempt in range(RETRIES):
            high = self.searched + width * SHORTER**attempt
            try:
                crossing = self.event_in(piece, self.searched, high)
            except SwitchError as error:
                # A zero too near the end of this window is farther from the end of a shorter one.
                if error.code != "precision" or attempt == RETRIES - 1:
                    raise
                continue
            if crossing:
                name, when = crossing
                self.ends = self.mode.guard(name), when
            else:
                self.searched = high
            return

    def look_for_stop(self) -> None:
        """Sets `stopped` where the mode proves a stop from the end of the last piece, up to which
        no guard has a zero.
        """
        stops = self.mode.mode.stops
        if stops is None or self.stopped is not None:
            return
        since = stops(self.reached())
        if since is not None:
            self.stopped = arb_of(self.end) + since

    def event_in(self, piece: Piece, low: Fraction, high: Fraction) -> tuple[str, arb] | None:
        """The name of the guard that is zero first in the window (low, high] of the last piece, and
        a ball of the time since the entry at which it is; None if none is.
        """
        begin = arb_of(piece.begin)
        # The zeros that the entry declares lie at the start of the first window.
        at_entry = low == 0
        with precision(self.bits + GUARD):
            guards = [
                self.watched(piece, guard.name, self.touching.get(guard.name, 0) * at_entry)
                for guard in self.mode.mode.guards
            ]
            crossing = earliest(guards, arb_of(low) - begin, arb_of(high) - begin)
            if crossing is None:
                return None
            name, since = crossing
            return name, since + begin

    def watched(self, piece: Piece, name: str, touching: int = 0, *, whole: bool = True) -> Watched:
        """A guard with its derivatives along a piece, for the `whole` set or for its exact centre;
        times are those since the piece's begin.

        `touching` is the order of its zero at the start of the piece.
        """
        if whole:
            state = piece.at
        else:
            state = piece.centre

        def along(program: Program) -> Along:
            return lambda since: program.run(state(since))[0]

        return Watched(name, [along(program) for program in self.mode.rates[name]], touching)

    def leave(self) -> None:
        """Sets `ends` or `never` by the closed form of the mode."""
        leaves = self.mode.mode.leaves
        assert leaves is not None
        with precision(self.bits + GUARD):
            end = leaves(self.entered)
        if end is None:
            self.never = True
            return
        name, since = end
        while self.pieces[-1].end < ball_of(since).mid:
            self.advance()
        self.ends = self.mode.guard(name), since

    def after(self, then: Entry) -> tuple[list[arb], Spread]:
        """The exact centre and the set after the event that ends this phase (theorem on hand-over).

        `then` is the entry into the next mode. The Jacobian X of the theorem is kept in `exit`.
        SwitchError where the rate grad g . f of the guard is not proved to be negative.
        """
        guard, piece, since, states = self.crossing()
        size = self.mode.size
        with precision(self.bits + GUARD):
            rate = self.mode.rates[guard.name][1].run(states)[0]
            if not rate < 0:
                raise SwitchError(
                    "grazing",
                    f"{guard.name} does not cross zero at a proved rate",
                    float(since.mid()),
                )
            on_section = self.section(guard, states, rate) * self.moved_by(piece, since)
            reset = then.reset or unchanged
            reset_jacobian = arb_mat(size, size, self.mode.derivative_rows(reset).run(states))
            # X = R (1 - f grad g^T/(grad g . f)) V.
            self.exit = reset_jacobian * on_section
            # E(c), by the crossing of the single motion from c.
            centre_since = self.centre_time(piece, guard, since)
            outputs, _ = traced(reset, size, self.mode.directions)
            image = Program(outputs).run(piece.centre(centre_since))
        centre = [value.mid() for value in image]
        rounding = [value.rad() for value in image]
        bits = max(BITS, self.steps.jacobian_bits)
        return centre, moved(piece.spread, self.exit, rounding, bits)

    def crossing(self) -> tuple[Guard, Piece, arb, list[arb]]:
        """The event that ends the phase: guard, piece, a ball of the times since the piece's begin
        at which the motions of the set leave, and balls of their states there.
        """
        assert self.ends is not None
        guard, when = self.ends
        piece = self.piece(when)
        with precision(self.bits + GUARD):
            since = when - arb_of(piece.begin)
            return guard, piece, since, piece.at(since)

    def section(self, guard: Guard, states: Sequence[arb], rate: arb) -> arb_mat:
        """The projection 1 - f grad g^T/(grad g . f) of errors along the field f onto the section g
        = 0, at the `states` in which the motions cross it; `rate` is grad g . f.

        A motion with the error e meets the section later by dt = -grad g . e/(grad g . f), and has
        there the error e + f dt.
        """
        gradient = self.mode.gradients[guard.name].run(states)
        rates = self.field.run(states)
        size = len(states)
        # Row i, column j: f_i (grad g)_j/(grad g . f).
        return unit_matrix(size) - arb_mat(
            size, size, [f * g / rate for f in rates for g in gradient]
        )

    def centre_time(self, piece: Piece, guard: Guard, since: arb) -> arb:
        """The time at which the exact centre of the piece crosses the guard: a ball within that of
        the set, `since`.
        """
        along_centre = self.watched(piece, guard.name, whole=False)
        return only_zero(along_centre, arb(since.lower()), arb(since.upper()))
