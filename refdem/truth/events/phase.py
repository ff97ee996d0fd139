"""One stay in a mode: its pieces, the search for what ends it, and the set that it hands on through
the event.

Theorem (hand-over): let every motion of the set c + {A r} cross the section g = 0 once, at a time
in T, and let V, f, grad g and the reset's Jacobian R hold their values for all of them there. Then
the map from the set to the state after the event is differentiable with a Jacobian in R (1 - f grad
g / (grad g . f)) V, so the mean value theorem moves the set as it does over a step: to the image of
c, whose own crossing is known far better, plus that Jacobian times A r. The uncertain time of the
event is in the clock's coordinate.
"""

from collections.abc import Sequence
from fractions import Fraction

from flint import arb, arb_mat

from refdem.truth.balls import arb_of, ball_of, precision
from refdem.truth.events.crossing import Along, SwitchError, Watched, earliest, only_zero
from refdem.truth.events.system import Entry, Guard, Traced, derivative_rows
from refdem.truth.traced_field import Program, traced
from refdem.truth.validated_ivp.integration import GUARD, Chain, Piece, Steps
from refdem.truth.validated_ivp.moved import Spread, identity, moved

RETRIES = 4
"""Of a window whose end lies too near a zero: each is a little shorter."""
SHORTER = Fraction(7, 8)
BEYOND = Fraction(1, 64)
"""Of a piece: a window reaches at least so far, also beyond its end (but not its disc's), where a
zero may lie exactly.
"""


class Phase(Chain):
    """The motions of the set centre + spread from their entries into a mode; times are those since
    each motion's own entry.
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
        self.centre = list(centre)
        self.spread = spread
        self.begin()
        self.searched = Fraction(0)
        self.entered = self.hull_at_entry()
        self.never = False
        self.ends: tuple[Guard, arb] | None = None
        self.exit = arb_mat(0, 0)

    def hull_at_entry(self) -> list[arb]:
        """Balls of the state of every motion at its entry."""
        with precision(self.bits + GUARD):
            return [
                value + arb(0, radius)
                for value, radius in zip(self.centre, self.spread.radii(), strict=True)
            ]

    def search(self) -> None:
        """Looks for the event in the next window; sets `ends` or `never`, or moves `searched`
        on.
        """
        if not self.pieces:
            self.advance()
            if self.mode.mode.leaves and self.leave():
                return
        if self.searched >= self.pieces[-1].end:
            self.advance()
        piece = self.pieces[-1]
        width = min(self.mode.mode.window, max(piece.end - self.searched, piece.length * BEYOND))
        for attempt in range(RETRIES):
            high = self.searched + width * SHORTER**attempt
            try:
                found = self.found(piece, self.searched, high)
            except SwitchError as error:
                if error.code != "precision" or attempt == RETRIES - 1:
                    raise
                continue
            if found:
                self.ends = self.mode.guard(found[0]), found[1]
            else:
                self.searched = high
            return

    def found(self, piece: Piece, low: Fraction, high: Fraction) -> tuple[str, arb] | None:
        """The first guard to be zero in a window of the last piece, and a ball of when, since the
        entry.
        """
        begin = arb_of(piece.begin)
        fresh = low == 0
        with precision(self.bits + GUARD):
            guards = [
                self.watched(piece, guard.name, self.touching.get(guard.name, 0) * fresh)
                for guard in self.mode.mode.guards
            ]
            found = earliest(guards, arb_of(low) - begin, arb_of(high) - begin)
            if found:
                return (found[0], found[1] + begin)
            return None

    def watched(self, piece: Piece, name: str, touching: int = 0, *, whole: bool = True) -> Watched:
        """A guard along a piece, for the whole set or for its exact centre; times are those since
        the piece's begin.
        """
        if whole:
            state = piece.at
        else:
            state = piece.centre

        def along(program: Program) -> Along:
            return lambda since: program.run(state(since))[0]

        return Watched(name, [along(program) for program in self.mode.rates[name]], touching)

    def leave(self) -> bool:
        """Ends the mode where its closed form says; True unless it has none of use."""
        leaves = self.mode.mode.leaves
        assert leaves is not None
        with precision(self.bits + GUARD):
            told = leaves(self.entered)
        if told is None:
            self.never = True
            return True
        name, since = told
        while self.pieces[-1].end < ball_of(since).mid:
            self.advance()
        self.ends = self.mode.guard(name), since
        return True

    def after(self, then: Entry) -> tuple[list[arb], Spread]:
        """Exact centre and set after the event that ends this phase; the Jacobian of the whole
        phase's last step is kept.
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
            whole = self.section(guard, states, rate) * self.moved_by(piece, since)
            reset = then.reset or (lambda y: list(y))
            rows = derivative_rows(reset, size).run(states)
            jacobian = self.exit = arb_mat(size, size, rows) * whole
            middle = self.centre_time(piece, guard, since)
            image = Program(traced(reset, size)[0]).run(piece.centre(middle))
        return [value.mid() for value in image], moved(
            piece.spread, jacobian, [value.rad() for value in image]
        )

    def crossing(self) -> tuple[Guard, Piece, arb, list[arb]]:
        """Guard, piece, times since its begin, and balls of the states, at which the motions of the
        set leave.
        """
        assert self.ends is not None
        guard, when = self.ends
        piece = self.piece(when)
        with precision(self.bits + GUARD):
            since = when - arb_of(piece.begin)
            return guard, piece, since, piece.at(since)

    def section(self, guard: Guard, states: Sequence[arb], rate: arb) -> arb_mat:
        """1 - f grad g / (grad g . f)."""
        gradient = self.mode.gradients[guard.name].run(states)
        rates = self.field.run(states)
        size = len(states)
        return identity(size) - arb_mat(size, size, [f * g / rate for f in rates for g in gradient])

    def centre_time(self, piece: Piece, guard: Guard, since: arb) -> arb:
        """When the exact centre of the piece crosses: a ball within that of the set."""
        return only_zero(
            self.watched(piece, guard.name, whole=False), arb(since.lower()), arb(since.upper())
        )
