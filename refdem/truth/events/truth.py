"""A truth by validated integration through events.

Theorem: the quantities at t are those of the motion that follows the field of its mode until the
first zero of one of its guards, and continues from the entry that this guard defines; it is
enclosed from event to event, with ball enclosures of the times of events. S(t) is bounded by the
products of enclosures of the flow's derivative over the pieces, times the jump matrix at each
event.

Hypotheses, and where each is checked:

* the solution exists in each mode and is enclosed: as for ValidatedFlow (validated_flow.py);
* no guard has a zero before the one that ends the mode, and that zero is met by every motion of the
  set, once, with a rate that is not zero: bisection and interval Newton (crossing.py);
* no two guards vanish at the same time: `earliest` (crossing.py), which raises `corner` otherwise;
* the entry is the same for every motion of the set: `Guard.then` decides by `sign`, of balls that
  hold all of them; each derivative that an entry declares to be 0 is checked to have a ball that
  holds 0 (`touches`, crossing.py);
* the set after the event holds every motion: the theorem on hand-over (phase.py);
* t is not within the uncertainty of an event: `HybridMotion.phase` (motion.py).
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from copy import copy
from dataclasses import KW_ONLY, dataclass, field, replace
from fractions import Fraction
from functools import cached_property, partial
from itertools import count
from math import ceil, log2
from typing import Any, ClassVar, Generic, Protocol, Self, TypeVar

from flint import arb, arb_mat, ctx

from refdem.core.truth import Ball, Truth
from refdem.errors import NotCertifiedError
from refdem.truth.balls import Guarded, UndecidedError, arb_of, ball_of, precision
from refdem.truth.closed_form import per_precision
from refdem.truth.dual import Derivatives, flattened, unflattened
from refdem.truth.events.crossing import SwitchError
from refdem.truth.events.directed import directed_programs, directed_start, dual_state, inner
from refdem.truth.events.following import Following
from refdem.truth.events.motion import Followed, HybridMotion, at_fixed_time, first_entry
from refdem.truth.events.phase import Phase
from refdem.truth.events.system import (
    Entry,
    Mode,
    State,
    TracedModes,
    lie_derivatives,
    unchanged,
)
from refdem.truth.forecast import Course, follow
from refdem.truth.growth import Fundamental, Grows, Growth, Norm, Retimed, Stretch, smooth
from refdem.truth.refiner import Refiner
from refdem.truth.validated_flow import AHEAD, Quantities, TracedReading, balls_of
from refdem.truth.validated_ivp.integration import GUARD, Piece, Steps

LADDER = (192, 256, 384, 512, 768, 1024, 1536)
"""Working precisions [bit], tried in this order until all radii are small enough; a motion that
needs more bits is not certified.
"""
LOSS = 24
"""The bits that every motion is expected to lose: precisions with fewer bits than those of the
target and these are not tried.
"""
METHOD = (
    "validated integration from event to event: signs by bisection, times by interval Newton,"
    " sets through the jump matrix"
)
Found = TypeVar("Found")
Motion = TypeVar("Motion", bound=Followed, covariant=True)


class Switching(Protocol[Motion]):
    """A system that switches between modes: the interface that a proof through events requires."""

    @property
    def clock_unit(self) -> Fraction | None:
        """Seconds in a unit of the clock of its motions; None where they are given in seconds."""

    def motion_at(self, bits: int, parameters: int = 0) -> Motion:
        """The motion, to be followed at a precision; with a number of parameters as coordinates
        (directed.py).
        """

    def last_state(self, state: Sequence[arb]) -> tuple[dict[str, arb], float]:
        """The quantities and the time [s] of a state with which a motion ended."""

    def beside(self, inner: arb_mat) -> arb_mat:
        """The Jacobian of the coordinates from which `chart` computes, made from `inner`, the
        Jacobian of the coordinates of a mode.
        """

    def chart(self, motion: Any, phase: Phase, state: Sequence[arb]) -> arb_mat:
        """The Jacobian, at a state, of the coordinates in which errors are measured (each over its
        scale) by the coordinates of `beside`.
        """

    def parts(self) -> list[int]:
        """The number of coordinates in each part that the norm measures together (Norm)."""

    def struck(self) -> Sequence[int] | None:
        """The coordinates of `chart` in which errors are made; None for all."""

    def readings(self, motion: Any, t: arb) -> arb_mat:
        """d quantity_i(t)/scale_i over d coordinate_j(t)/scale_j."""

    def approach(self, motion: Any) -> Iterable[Stretch]:
        """The stretches of time before the first phase, in the coordinates of `chart`: those before
        the event with which a motion begins.
        """


@dataclass(frozen=True)
class EventProof(Guarded, Generic[Motion]):
    """The refiner and the sensitivity of a motion through events: it proves values, and S(t).

    The motion of `system` is followed anew at each precision of the ladder, until the radii that
    `refiner` requires are met. `label` begins every message; `parameters` is the number of
    parameters that are coordinates of the motion; `kept` has motions and bounds.
    """

    system: Switching[Motion]
    refiner: Refiner
    label: str = ""
    parameters: int = 0
    kept: dict[Any, Any] = field(default_factory=dict, init=False, compare=False, repr=False)

    def to(self, digits: int) -> Self:
        """The same proof for other digits; the motions that were followed serve both."""
        return self.sharing(refiner=self.refiner.to(digits))

    def sharing(self, **changes: Any) -> Self:
        """The proof with changes, with the same motions."""
        other = replace(self, **changes)
        vars(other)["kept"] = self.kept
        return other

    def motion(self, bits: int) -> Motion:
        """The motion at a precision, as far as it has been followed."""
        key = ("motion", bits, self.parameters)
        if key not in self.kept:
            self.kept[key] = self.system.motion_at(bits, self.parameters)
        motion: Motion = self.kept[key]
        return motion

    def derivatives(
        self, evaluate: Callable[[Motion], dict[str, arb]], what: str, count: int
    ) -> Derivatives:
        """The derivatives by `count` parameters of the quantities that `evaluate` gives as dual
        balls of a motion (dual.py).
        """
        proof = self.sharing(parameters=count)
        flat = proof.climbed(lambda motion: flattened(evaluate(motion), count), what)
        return unflattened(flat, count)

    def climbed(self, evaluate: Callable[[Any], dict[str, arb]], what: str) -> dict[str, Ball]:
        """The balls that `evaluate` gives of the motion, at the lowest precision at which all radii
        are small enough.

        NotCertifiedError about `what`, with code, time and last state, where none is.
        """
        target = self.refiner.target()

        def within(motion: Any) -> dict[str, Ball]:
            balls = {name: ball_of(value) for name, value in evaluate(motion).items()}
            if any(ball.radius > target for ball in balls.values()):
                largest_radius = float(max(ball.radius for ball in balls.values()))
                raise SwitchError("precision", f"radius stays at {largest_radius:.3g}", 0.0)
            return balls

        return self.followed(within, what, self.needed())

    def followed(
        self, evaluate: Callable[[Any], Found], what: str, ladder: Sequence[int] = LADDER
    ) -> Found:
        """What `evaluate` returns for the motion, at the lowest precision of the ladder at which it
        does not raise.

        NotCertifiedError about `what`, with code, time and last state, where it always raises.
        """
        last_error = SwitchError("precision", "no precision suffices", 0.0)
        for bits in ladder:
            with precision(bits):
                try:
                    return evaluate(self.motion(bits))
                except SwitchError as error:
                    last_error = error
                    if error.final:
                        break
                except UndecidedError as error:
                    last_error = SwitchError("precision", str(error), 0.0)
        raise self.uncertified(last_error, what)

    def needed(self) -> list[int]:
        """The precisions of the ladder that can meet the digits; NotCertifiedError if none can."""
        # About log2(1/target) bits for the digits, and those that every motion loses.
        least = ceil(1 / self.refiner.target()).bit_length() + LOSS
        ladder = [bits for bits in LADDER if bits >= least]
        if not ladder:
            raise NotCertifiedError(
                f"{self.refiner.digits} digits ask for more than {LADDER[-1]} bits; ask for fewer",
                code="precision",
            )
        return ladder

    def forecast(self, t: Fraction, digits: int) -> float:
        """CPU seconds that a value at t (in units of the clock) to so many digits is expected to
        cost; the part of the motion that is followed for the forecast is kept.
        """
        asked = self.to(digits)
        course = Course(asked.needed()[0], has_events=True)
        try:
            work = asked.foreseen(t, course)
        except NotCertifiedError:
            return 0.0
        return course.seconds_for(work)

    def foreseen(self, t: Fraction, course: Course) -> float:
        """The number of pieces that are still to be made until the radius at t meets the target,
        counted in pieces of the course's precision.

        The search of windows is not counted: it costs little in comparison with a piece.
        """
        # log2 of a fraction that may underflow as a double.
        target = log2(self.refiner.target().numerator) - log2(self.refiner.target().denominator)
        time = float(t)
        motion = self.motion(course.bits)
        following = Following(motion, course, t)

        def next_bits(bits: int, lacking: float | None) -> int | None:
            return next((rung for rung in LADDER if rung > bits), None)

        def work() -> float:
            """The work that is left, by a scout that makes AHEAD steps for each window."""
            following.look_ahead(AHEAD)
            return course.work_to(time, target, next_bits)

        if motion.over():
            return 0.0
        follow(course, following.state, following.step, t, work)
        # No piece is made after the end of a motion, or after an error that more bits cannot avoid.
        if motion.over() or following.is_final:
            return 0.0
        return work()

    def uncertified(self, error: SwitchError, what: str) -> NotCertifiedError:
        """The error that ends the proof of `what`, with the last certified state if known."""
        message = f"{self.label}{what}: {error.code}: {error}"
        if not error.state:
            return NotCertifiedError(message, code=error.code)
        values, time = self.system.last_state(inner(error.state, self.parameters))
        state = {name: ball_of(value) for name, value in values.items()}
        message = f"{message}; certified up to t = {time:.17g} s"
        return NotCertifiedError(message, code=error.code, time=time, state=state)

    @per_precision
    def growth(self) -> Grows:
        """The growth S from event to event, by the variational equation and the jump matrices."""
        motion = self.motion(ctx.prec)
        growth = Growth(
            self.stretches(motion),
            Norm(self.system.parts()),
            partial(self.system.readings, motion),
            self.system.struck(),
            step=Fraction(1, 2**10),
        )
        unit = self.system.clock_unit
        if unit is None:
            return growth
        return Retimed(growth, unit)

    def sensitivity(self, t: Fraction) -> float:
        """S(t) [t in s], at the precisions of the motion, whose pieces are there already."""
        if ("sensitivity", t) not in self.kept:
            what = f"S at t = {float(t):.17g} s"
            self.kept["sensitivity", t] = self.followed(
                lambda motion: self.growth().at(t), what, self.needed()
            )
        bound: float = self.kept["sensitivity", t]
        return bound

    def stretches(self, motion: Followed) -> Iterator[Stretch]:
        """The pieces of a motion as stretches, made on demand; the last one of a phase
        ends with an event.
        """
        yield from self.system.approach(motion)
        for number in count():
            while number >= len(motion.phases):
                if motion.ended:
                    return
                motion.follow()
            yield from self.pieces_of(motion, number)

    def pieces_of(self, motion: Followed, number: int) -> Iterator[Stretch]:
        """The pieces of the phase of that number as stretches, in order of time.

        The motion is followed as far as each of them needs: past the piece, or through the event
        that ends it.
        """
        phase = motion.phases[number]
        for index in count():
            while index >= len(phase.pieces):
                if phase.never:
                    phase.advance()
                else:
                    motion.follow()
            piece = phase.pieces[index]
            # Whether an event lies in the piece is known once all of it has been searched.
            while not (phase.never or phase.ends or phase.searched >= piece.end):
                motion.follow()
            begin = phase.entered[-1] + arb_of(piece.begin)
            errors = partial(self.errors, motion, phase, piece)
            if phase.ends and phase.crossing()[1] is piece:
                yield self.last_stretch(motion, number, begin, errors)
                return
            yield smooth(begin, arb_of(piece.length), errors, joins=True)

    def last_stretch(
        self, motion: Followed, number: int, begin: arb, errors: Fundamental
    ) -> Stretch:
        """The stretch of a phase's last piece, which ends with an event: its handover contains the
        jump matrix.
        """
        phase = motion.phases[number]
        while len(motion.events) <= number:
            motion.follow()
        if number + 1 < len(motion.phases):
            after = motion.phases[number + 1]
        else:
            # The motion ends with the event.
            after = None
        _, _, length, _ = phase.crossing()
        return Stretch(begin, length, errors, partial(self.handed_on, motion, phase, after))

    def errors(self, motion: Followed, phase: Phase, piece: Piece, since: arb) -> arb_mat:
        """M of a piece: errors in the coordinates of `chart`, `since` [s] after its start, by
        errors in the coordinates of its mode at its start.

        An error does not change the clock, whose rate is 1 in every state.
        """
        # M = C beside(V), with the flow Jacobian V of the piece and the Jacobian C of `chart`.
        with precision(motion.bits + GUARD):
            inner = phase.moved_by(piece, since)
            return self.system.chart(motion, phase, piece.at(since)) * self.system.beside(inner)

    def handed_on(self, motion: Followed, phase: Phase, after: Phase | None) -> arb_mat:
        """The errors after the event that ends a phase, at one time for all motions of the set, by
        those at the start of the phase's last piece.

            C beside((1 - f2 e^T) R (1 - f grad g^T/(grad g . f)) V)

        V is the flow Jacobian of the last piece; the factor after it, with the field f of the mode
        that ends, projects errors onto the section g = 0 of its guard; R is the Jacobian of the
        reset. The first factor, with the field f2 of the mode that follows and the unit vector e of
        the clock, turns errors at each motion's own event into errors at one time. C is the
        Jacobian of `chart`. `after` is the phase that follows; where the motion ends it is None,
        and the factors 1 - f2 e^T and R are left out.
        """
        guard, piece, since, states = phase.crossing()
        size = phase.mode.size
        with precision(motion.bits + GUARD):
            guard_rate = phase.mode.rates[guard.name][1].run(states)[0]
            # (1 - f grad g^T/(grad g . f)) V.
            on_section = phase.section(guard, states, guard_rate) * phase.moved_by(piece, since)
            if after is None:
                return self.system.chart(motion, phase, states) * self.system.beside(on_section)
            reset = guard.then(states).reset or unchanged
            reset_jacobian = arb_mat(size, size, phase.mode.derivative_rows(reset).run(states))
            # R (1 - f grad g^T/(grad g . f)) V, then 1 - f2 e^T times that.
            jump = reset_jacobian * on_section
            inner = at_fixed_time(after, after.entered) * jump
            chart = self.system.chart(motion, after, after.entered)
            return chart * self.system.beside(inner)


@dataclass(frozen=True)
class HybridFlow(Guarded, Truth):
    """The motion of a system that switches, for t >= 0, as a record of what the system is.

    `begin` has, for each coordinate, an exact number or a function that gives its ball; the last is
    the clock. `first(y)` gives the entry into the first mode from balls of the start; its reset
    must be None. `quantities(y)` has quantities by name, those of `state` among them, and `refiner`
    the size of each; `moved` has the coordinates of the start that S displaces, each in the scale
    of its quantity of `state`.

    Optional parts: `finished` turns the values of `quantities` into those that `at` returns (by
    default they are the same); `still` names quantities whose value is exactly 0 where `quantities`
    does not give them; `extremes` gives the scalars.
    """

    clock_unit: ClassVar[None] = None
    method = METHOD

    modes: Mapping[str, Mode] | TracedModes
    begin: Sequence[Fraction | int | Callable[[], arb]]
    first: Callable[[State], Entry]
    quantities: Quantities
    refiner: Refiner
    _: KW_ONLY
    state: Sequence[str]
    moved: Sequence[int]
    witness: str = "none"
    finished: Callable[[dict[str, arb]], dict[str, arb]] = lambda values: values
    still: Sequence[str] = ()
    extremes: "Callable[[HybridFlow], dict[str, Ball]]" = lambda flow: {}

    @cached_property
    def programs(self) -> TracedModes:
        """The modes as programs, by name; modes that are traced already are taken as they are."""
        if isinstance(self.modes, TracedModes):
            return self.modes
        return TracedModes(self.modes, len(self.begin), lie_derivatives)

    @cached_property
    def reading(self) -> TracedReading:
        """The quantities as programs of a state."""
        return TracedReading(self.quantities, len(self.begin))

    @cached_property
    def proof(self) -> EventProof[HybridMotion]:
        """The proof of values and of S; it keeps the motions that it has followed."""
        return EventProof(self, self.refiner)

    @property
    def scale(self) -> Mapping[str, Fraction]:
        """The size of each quantity, against which its error counts."""
        return self.refiner.scale

    def refined(self, digits: int) -> Self:
        """The same truth with radii of at most 10^-digits; programs and motions serve both."""
        other = copy(self)
        vars(other).update(refiner=self.refiner.to(digits), proof=self.proof.to(digits))
        return other

    def at(self, t: Fraction) -> dict[str, Ball]:
        """Every quantity at the exact time t [s]; raises NotCertifiedError where it cannot be
        proved.
        """
        if t < 0:
            raise NotCertifiedError(f"t = {float(t):.17g} s is before the start")
        values = self.proof.climbed(
            lambda motion: self.named(motion.at(arb_of(t))), f"at t = {float(t):.17g} s"
        )
        zeros = {name: Ball(Fraction(0), Fraction(0)) for name in self.still}
        return zeros | values

    def derivatives(self, t: Fraction, count: int) -> Derivatives:
        """The derivatives at t of every quantity by each of the `count` parameters by which the
        numbers of this truth carry derivatives (directed.py).
        """

        def quantities_at_t(motion: HybridMotion) -> dict[str, arb]:
            # The derivatives that the start carries enter by the chain rule (directed.py).
            return self.named(dual_state(motion, arb_of(t), balls_of(self.begin), count))

        what = f"derivatives at t = {float(t):.17g} s"
        derivatives = self.proof.derivatives(quantities_at_t, what, count)
        zero = Ball(Fraction(0), Fraction(0))
        return dict.fromkeys(self.still, (zero,) * count) | derivatives

    def scalars(self) -> dict[str, Ball]:
        """Values that do not depend on time."""
        return self.extremes(self)

    def sensitivity(self, t: Fraction) -> float:
        """S(t), with the jump matrix at each event."""
        return self.proof.sensitivity(t)

    def forecast(self, t: Fraction, digits: int) -> float:
        """CPU seconds that `at(t)` to so many digits is expected to cost."""
        return self.proof.forecast(t, digits)

    def motion(self, bits: int) -> HybridMotion:
        """The motion at a precision, as far as it has been followed."""
        return self.proof.motion(bits)

    def motion_at(self, bits: int, parameters: int = 0) -> HybridMotion:
        """The motion, to be followed at a precision; with a number of parameters as coordinates
        (directed.py).
        """
        with precision(bits):
            start = directed_start(balls_of(self.begin), parameters)
            entry = first_entry(lambda y: self.first(inner(y, parameters)), start)
            if not parameters:
                return HybridMotion(self.programs, start, entry, bits)
            programs = self.programs
            modes = directed_programs(programs.modes, programs.size, programs.rates, parameters)
            return HybridMotion(modes, start, entry, bits, Steps(jacobian_bits=bits))

    def displaced(self, axis: int, amount: Fraction) -> Self:
        """Raises NotCertifiedError: S comes from the variational equation, with the jump matrices,
        not from neighbouring starts.
        """
        raise NotCertifiedError(
            "a motion through events is not displaced: its S comes from the variational equation;"
            " ask for `sensitivity`"
        )

    def named(self, y: Sequence[arb]) -> dict[str, arb]:
        """The quantities of a state, by name."""
        return self.finished(self.reading.values(y))

    def last_state(self, state: Sequence[arb]) -> tuple[dict[str, arb], float]:
        """The quantities and the time [s] of a state with which a motion ended."""
        return self.named(state), float(state[-1].mid())

    def events_until(self, t: Fraction) -> list[tuple[str, str | None, Ball]]:
        """The name, the mode entered and the time [s] of each event before t."""

        events: list[tuple[str, str | None]] = []

        def times_of_events(motion: HybridMotion) -> dict[str, arb]:
            # `at` follows the motion past t.
            motion.at(arb_of(t))
            before = [event for event in motion.events if event.time < arb_of(t)]
            events[:] = [(event.name, event.mode) for event in before]
            return {str(number): event.time for number, event in enumerate(before)}

        balls = self.proof.climbed(times_of_events, f"events until {float(t):.17g} s")
        return [
            (name, mode, ball) for (name, mode), ball in zip(events, balls.values(), strict=True)
        ]

    def beside(self, inner: arb_mat) -> arb_mat:
        """The rows and columns of a mode's derivative for the coordinates that S displaces, which
        `chart` takes.
        """
        table = inner.table()
        return arb_mat([[table[i][j] for j in self.moved] for i in self.moved])

    def chart(self, motion: HybridMotion, phase: Phase, state: Sequence[arb]) -> arb_mat:
        """The diagonal matrix of 1/scale: errors of the displaced coordinates are measured in
        units of their scales.
        """
        scales = self.displaced_scales()
        count = len(scales)
        matrix = arb_mat(count, count)
        for i, scale in enumerate(scales):
            # C = diag(1/scale_i).
            matrix[i, i] = 1 / scale
        return matrix

    def displaced_scales(self) -> list[arb]:
        """The scales of the coordinates that S displaces."""
        return [arb_of(self.scale[name]) for name in self.state]

    def parts(self) -> list[int]:
        """The number of coordinates in each part of the norm: every coordinate is measured
        alone.
        """
        return [1] * len(self.state)

    def struck(self) -> None:
        """Errors are made in all coordinates of `chart`."""

    def approach(self, motion: HybridMotion) -> tuple[()]:
        """None: the start is no event."""
        return ()

    def readings(self, motion: HybridMotion, t: arb) -> arb_mat:
        """d quantity_i(t)/scale_i over d coordinate_j(t)/scale_j."""
        # (dq_i/dy_j) scale_j/scale_i.
        slopes = self.reading.slopes(motion.at(t))
        moved = list(zip(self.moved, self.displaced_scales(), strict=True))
        rows = []
        for name, row in slopes.items():
            scale = arb_of(self.scale[name])
            rows.append([row[j] * scale_of_state / scale for j, scale_of_state in moved])
        return arb_mat(rows)
