"""A Truth by validated integration through events: quantities and event times as balls, S(t) with
the jump matrices.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from fractions import Fraction
from functools import partial
from itertools import count
from math import ceil, log2
from typing import Any, Self, TypeVar

from flint import arb, arb_mat, ctx

from refdem.core.truth import Ball
from refdem.errors import NotCertifiedError
from refdem.truth.balls import UndecidedError, arb_of, ball_of, largest, precision
from refdem.truth.closed_form import ClosedForm, Size, per_precision
from refdem.truth.events.crossing import SwitchError
from refdem.truth.events.motion import HybridMotion, at_fixed_time, first_entry
from refdem.truth.events.phase import Phase
from refdem.truth.events.system import Entry, Mode, State, Traced, derivative_rows
from refdem.truth.forecast import Course, follow
from refdem.truth.growth import Grows, Growth, Norm, Stretch, smooth
from refdem.truth.traced_field import Program, traced
from refdem.truth.validated_flow import Quantities
from refdem.truth.validated_ivp.integration import GUARD, Piece

LADDER = (192, 256, 384, 512, 768, 1024, 1536)
"""Bits, one after another until the radius is met; a motion that asks for more is not certified."""
Found = TypeVar("Found")
LOSS = 24
"""Bits below those of the target that no motion is certified with."""


class HybridFlow(ClosedForm):
    """The motion of a system that switches, for t >= 0.

    `start` has, for each coordinate, an exact number or a function that gives its ball; the last is
    the clock. `first(y)` gives the entry into the first mode from balls of the start, whose reset
    must be None. `quantities(y)` has quantities by name, those of
    `state` among them; `moved` has the coordinates of the start that S displaces, each in the scale
    of its quantity of `state`.
    """

    method = (
        "validated integration from event to event: signs by bisection, times by interval Newton,"
        " sets through the jump matrix"
    )
    witness = "none"

    def __init__(
        self,
        modes: Mapping[str, Mode],
        start: Sequence[Fraction | int | Callable[[], arb]],
        first: Callable[[State], Entry],
        quantities: Quantities,
        scale: Mapping[str, Size],
        *,
        state: Sequence[str],
        moved: Sequence[int],
        digits: int = 40,
    ) -> None:
        super().__init__(scale, digits=digits)
        self.modes = {name: Traced(mode, len(start)) for name, mode in modes.items()}
        self.begin, self.first, self.state, self.moved = (
            list(start),
            first,
            tuple(state),
            tuple(moved),
        )
        self.names: list[str] = []
        outputs, slopes = traced(lambda y: self.listed(quantities(y)), len(self.begin))
        self.values, self.slopes = (
            Program(outputs),
            Program([entry for row in slopes for entry in row]),
        )

    def listed(self, found: Mapping[str, Any]) -> list[Any]:
        """The quantities one after another, as `names` lists them."""
        self.names = list(found)
        return list(found.values())

    def displaced(self, axis: int, amount: Fraction) -> Self:
        """Raises NotCertifiedError: S comes from the variational equation, with the jump matrices,
        not from neighbouring starts.
        """
        raise NotCertifiedError(
            "a motion through events is not displaced: its S comes from the variational equation;"
            " ask for `sensitivity`"
        )

    def motion(self, bits: int) -> HybridMotion:
        """The motion at a precision, as far as it has been followed."""
        if ("motion", bits) not in self.kept:
            with precision(bits):
                balls = [value() if callable(value) else arb_of(value) for value in self.begin]
                self.kept["motion", bits] = HybridMotion(
                    self.modes, balls, first_entry(self.first, balls), bits
                )
        found: HybridMotion = self.kept["motion", bits]
        return found

    def named(self, y: Sequence[arb]) -> dict[str, arb]:
        """The quantities of a state, by name."""
        return dict(zip(self.names, self.values.run(y), strict=True))

    def at(self, t: Fraction) -> dict[str, Ball]:
        return self.climbed(
            lambda motion: self.named(motion.at(arb_of(t))), f"at t = {float(t):.17g} s"
        )

    def evaluate(self, t: arb) -> dict[str, arb]:
        return self.named(self.motion(LADDER[0]).at(t))

    def events_until(self, t: Fraction) -> list[tuple[str, str | None, Ball]]:
        """Names, modes entered and times [s] of the events before t."""

        def found(motion: HybridMotion) -> dict[str, arb]:
            motion.at(arb_of(t))
            return {
                f"{event.name} {event.mode} {n}": event.time
                for n, event in enumerate(motion.events)
                if event.time < arb_of(t)
            }

        balls = self.climbed(found, f"events until {float(t):.17g} s")
        told = [(label.split(), ball) for label, ball in balls.items()]
        return [
            (name, mode if mode in self.modes else None, ball) for (name, mode, _), ball in told
        ]

    def climbed(self, evaluate: Callable[[Any], dict[str, arb]], what: str) -> dict[str, Ball]:
        """Balls at the lowest precision at which all radii are small enough.

        NotCertifiedError with code, time and last state.
        """
        target = self.target()

        def within(motion: Any) -> dict[str, Ball]:
            balls = {name: ball_of(value) for name, value in evaluate(motion).items()}
            if any(ball.radius > target for ball in balls.values()):
                raise SwitchError(
                    "precision",
                    f"radius stays at {float(max(b.radius for b in balls.values())):.3g}",
                    0.0,
                )
            return balls

        return self.followed(within, what, self.needed())

    def followed(
        self, evaluate: Callable[[Any], Found], what: str, ladder: Sequence[int] = LADDER
    ) -> Found:
        """What is found from the motion at the lowest precision of the ladder.

        NotCertifiedError with code, time and last state.
        """
        error = SwitchError("precision", "no precision suffices", 0.0)
        for bits in ladder:
            with precision(bits):
                try:
                    return evaluate(self.motion(bits))
                except SwitchError as one:
                    error = one
                    if error.final:
                        break
                except UndecidedError as one:
                    error = SwitchError("precision", str(one), 0.0)
        raise self.uncertified(error, what)

    def needed(self) -> list[int]:
        """The bits of the ladder that can meet the digits; NotCertifiedError if none can."""
        least = ceil(1 / self.target()).bit_length() + LOSS
        found = [bits for bits in LADDER if bits >= least]
        if not found:
            raise NotCertifiedError(
                f"{self.digits} digits ask for more than {LADDER[-1]} bits; ask for fewer",
                code="precision",
            )
        return found

    def forecast(self, t: Fraction, digits: int) -> float:
        """CPU seconds that `at(t)` to so many digits is about to cost; what is followed for it is
        kept.
        """
        asked = self.refined(digits)
        course = Course(asked.needed()[0])
        try:
            work = asked.foreseen(t, course)
        except NotCertifiedError:
            return 0.0
        return course.seconds_for(work)

    def foreseen(self, t: Fraction, course: Course) -> float:
        """The windows that are left to be searched until the radius at t is what is asked for, in
        windows of the course's precision.
        """
        # log2 of a number that may be below all doubles.
        target = log2(self.target().numerator) - log2(self.target().denominator)
        time = float(t)
        motion = self.motion(course.bits)
        followed = 0

        def next_bits(bits: int, lacking: float | None) -> int | None:
            return next((rung for rung in LADDER if rung > bits), None)

        def step() -> bool:
            nonlocal followed
            followed += 1
            try:
                motion.follow()
            except UndecidedError:
                return False
            return not motion.over()

        def state() -> tuple[Fraction, int, arb]:
            return motion.reached(), followed, largest(motion.phases[-1].spread.radii())

        def work() -> float:
            return course.work_to(time, target, next_bits)

        if motion.over():
            return 0.0
        follow(course, state, step, t, work)
        # What is over, or ends, costs nothing more.
        if motion.over():
            return 0.0
        return work()

    def uncertified(self, error: SwitchError, what: str) -> NotCertifiedError:
        """The error that reports why certification ends, and where."""
        if error.state:
            state = {name: ball_of(value) for name, value in self.named(error.state).items()}
        else:
            state = {}
        if error.state:
            time = float(error.state[-1].mid())
        else:
            time = None
        if time is not None:
            told = f"; certified up to t = {time:.17g} s"
        else:
            told = ""
        return NotCertifiedError(
            f"{what}: {error.code}: {error}{told}", code=error.code, time=time, state=state
        )

    @per_precision
    def growth(self) -> Grows:
        """The growth S from event to event, by the variational equation and the jump matrices."""
        motion = self.motion(ctx.prec)
        readings = partial(self.readings, motion)
        return Growth(
            self.stretches(motion),
            Norm(self.parts()),
            readings,
            self.struck(),
            step=Fraction(1, 2**10),
        )

    def _sensitivity(self, t: Fraction) -> float:
        """The sensitivity S(t) at the precisions of the motion, whose pieces are there already."""
        return self.followed(
            lambda motion: self.growth().at(t), f"S at t = {float(t):.17g} s", self.needed()
        )

    def stretches(self, motion: HybridMotion) -> Iterator[Stretch]:
        """The pieces of a motion, made as they are asked for; the last of a phase ends with an
        event.
        """
        for number in count():
            while number >= len(motion.phases):
                if motion.ended:
                    return
                motion.follow()
            yield from self.pieces_of(motion, number)

    def pieces_of(self, motion: HybridMotion, number: int) -> Iterator[Stretch]:
        """The Taylor pieces of a phase, one after the other."""
        phase = motion.phases[number]
        for index in count():
            while index >= len(phase.pieces):
                if phase.never:
                    phase.advance()
                else:
                    motion.follow()
            piece = phase.pieces[index]
            while not (phase.never or phase.ends or phase.searched >= piece.end):
                motion.follow()
            begin = phase.entered[-1] + arb_of(piece.begin)
            errors = partial(self.errors, motion, phase, piece)
            if phase.ends and phase.crossing()[1] is piece:
                while len(motion.events) <= number:
                    motion.follow()
                if number + 1 < len(motion.phases):
                    after = motion.phases[number + 1]
                else:
                    after = None
                yield Stretch(
                    begin,
                    phase.crossing()[2],
                    errors,
                    partial(self.handed_on, motion, phase, after),
                )
                return
            yield smooth(begin, arb_of(piece.length), errors, joins=True)

    def errors(self, motion: HybridMotion, phase: Phase, piece: Piece, since: arb) -> arb_mat:
        """What errors at the begin of a piece, in the coordinates of its mode, are afterwards in
        those of `chart`.

        Errors leave the clock alone, whose rate no state changes.
        """
        with precision(motion.bits + GUARD):
            inner = phase.moved_by(piece, since)
            return self.chart(motion, phase, piece.at(since)) * self.beside(inner)

    def handed_on(self, motion: HybridMotion, phase: Phase, after: Phase | None) -> arb_mat:
        """What errors at the begin of a phase's last piece are after the event that ends it, at one
        time for all motions of the set.
        """
        guard, piece, since, states = phase.crossing()
        size = phase.mode.size
        with precision(motion.bits + GUARD):
            rate = phase.mode.rates[guard.name][1].run(states)[0]
            section = phase.section(guard, states, rate) * phase.moved_by(piece, since)
            if after is None:
                return self.chart(motion, phase, states) * self.beside(section)
            reset = guard.then(states).reset or (lambda y: list(y))
            jump = arb_mat(size, size, derivative_rows(reset, size).run(states)) * section
            return self.chart(motion, after, after.entered) * self.beside(
                at_fixed_time(after, after.entered) * jump
            )

    def beside(self, inner: arb_mat) -> arb_mat:
        """A derivative of the coordinates of a mode, of those that `chart` takes: here of those
        that S displaces.
        """
        table = inner.table()
        return arb_mat([[table[i][j] for j in self.moved] for i in self.moved])

    def chart(self, motion: HybridMotion, phase: Phase, state: Sequence[arb]) -> arb_mat:
        """The derivative of the coordinates in which errors are counted, in scales, by those that
        `beside` leaves, in a state.
        """
        count = len(self.state)
        return arb_mat(
            [
                [1 / size if i == j else arb(0) for j in range(count)]
                for i, size in enumerate(self.own_scales())
            ]
        )

    def own_scales(self) -> list[arb]:
        """Scales of the coordinates that S displaces."""
        return [arb_of(self.scale[name]) for name in self.state]

    def parts(self) -> list[int]:
        """How many coordinates are measured together (Norm)."""
        return [1] * len(self.state)

    def struck(self) -> Sequence[int] | None:
        """The coordinates of `chart` in which errors are made; None for all."""
        return None

    def readings(self, motion: HybridMotion, t: arb) -> arb_mat:
        """d quantity_i(t)/scale_i over d coordinate_j(t)/scale_j."""
        y = motion.at(t)
        slopes = self.slopes.run(y)
        rows = [slopes[i : i + len(y)] for i in range(0, len(slopes), len(y))]
        moved = list(zip(self.moved, self.own_scales(), strict=True))
        sizes = [arb_of(self.scale[name]) for name in self.names]
        return arb_mat(
            [
                [row[j] * own / size for j, own in moved]
                for row, size in zip(rows, sizes, strict=True)
            ]
        )
