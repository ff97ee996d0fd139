"""The collision of two spheres followed from phase to phase, at one precision: positions, their
derivatives by the start, and extremes.
"""

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Any

from flint import arb, arb_mat

from refdem.truth.balls import arb_of, precision, unit_matrix
from refdem.truth.contact_phases import LinearContact, PlanarPhases
from refdem.truth.events.crossing import Along, SwitchError, Watched, first_crossing, sign
from refdem.truth.events.directed import directed_programs, directed_start, dual_state, inner
from refdem.truth.events.motion import Followed, first_entry
from refdem.truth.events.phase import Phase
from refdem.truth.events.system import TracedModes, along, lie_derivatives
from refdem.truth.growth import inverted
from refdem.truth.traced_field import Program, traced
from refdem.truth.validated_ivp.integration import GUARD, Piece, Steps

LONGEST = 128
"""The longest contact that is followed in any case, in the phases' unit of time, which is at most
the shortest time of the law.
"""
HALF_PERIODS = 2
"""The half periods of the normal spring for which a contact is followed in any case: without
damping it lasts one, however short the times of a stiff tangential spring are.
"""
PRESSES = ("press", "slip", "slip back", "stick", "hold")
"""The modes in which the normal force presses."""


RATES = partial(lie_derivatives, highest=2)
"""The derivatives of a guard: those of a contact vanish at an entry to the second order at most."""


class TracedContact:
    """A pair's modes as programs, with programs of positions and of the quantities that have
    extremes.

    `places` has, by whether the spheres fly, the programs of the positions and of their Jacobian;
    `closing` and `steepening` have, by mode, those of the closing speed and of the rate of the
    force, each with its own rate.
    """

    def __init__(self, phases: LinearContact) -> None:
        self.phases = phases
        modes = phases.modes()
        self.modes = TracedModes(modes, phases.size, RATES)
        self.places = {
            False: traced_map(partial(phases.place, "contact"), phases.size),
            True: traced_map(partial(phases.place, "apart"), phases.size),
        }
        self.force, _ = traced_map(single(phases.force), phases.size)
        self.overlap, self.overlap_gradient = traced_map(single(phases.overlap), phases.size)
        contact = {name: mode for name, mode in modes.items() if name != "apart"}
        self.closing = {
            name: rates(phases.closing, mode.field, phases.size) for name, mode in contact.items()
        }
        self.steepening = {
            name: rates(phases.steepening, mode.field, phases.size)
            for name, mode in contact.items()
        }

    def place(self, mode: str, y: Sequence[arb]) -> list[arb]:
        """x, y, vx, vy, o1, o2, s, clock of a state; in space as SpatialPhases has them."""
        values, _ = self.places[mode == "apart"]
        return values.run(y)

    def slopes(self, mode: str, y: Sequence[arb]) -> arb_mat:
        """The derivative of `place` by the state y, as a square matrix."""
        _, jacobian = self.places[mode == "apart"]
        size = self.phases.size
        return arb_mat(size, size, jacobian.run(y))


def single(value: Callable[[Sequence[Any]], Any]) -> Callable[[Sequence[Any]], list[Any]]:
    """A function of the state as a map to one number."""
    return lambda y: [value(y)]


def traced_map(
    function: Callable[[Sequence[Any]], Sequence[Any]], size: int
) -> tuple[Program, Program]:
    """Programs of a map of a state of that size, and of its Jacobian, row by row."""
    outputs, rows = traced(function, size)
    return Program(outputs), Program([entry for row in rows for entry in row])


def rates(
    value: Callable[[Sequence[Any]], Any],
    field: Callable[[Sequence[Any]], Sequence[Any]],
    size: int,
) -> list[Program]:
    """Programs of a function of the state and of its rate along a field."""
    nodes, _ = traced(lambda y: [value(y), *field(y)], size)
    function, *field_rates = nodes
    return [Program([function]), Program([along(function, field_rates)])]


class ContactMotion(Followed):
    """The motion of two spheres through a contact, with its end, its largest overlap and force.

    A number of `parameters` are coordinates of its modes (events/directed.py).
    """

    def __init__(self, traced_contact: TracedContact, bits: int, parameters: int = 0) -> None:
        self.traced = traced_contact
        self.parameters = parameters
        phases = traced_contact.phases
        with precision(bits):
            start = directed_start(self.start(), parameters)
            entry = first_entry(lambda y: phases.first(inner(y, parameters)), start)
            if not parameters:
                self.begin(traced_contact.modes, start, entry, bits, None)
                return
            modes = directed_programs(phases.modes(), phases.size, RATES, parameters)
            self.begin(modes, start, entry, bits, Steps(jacobian_bits=bits))

    def start(self) -> list[arb]:
        """Balls of the state at touch."""
        return [value() for value in self.traced.phases.start()]

    def name(self, phase: Phase) -> str:
        """The name of the mode that a phase is in."""
        return next(name for name, mode in self.modes.items() if mode is phase.mode)

    def place(self, t: arb) -> list[arb]:
        """x, y, vx, vy, o1, o2, s, clock at the time t."""
        phase = self.phase(t)
        if self.parameters:
            state = dual_state(self, t, self.start(), self.parameters)
        else:
            state = self.at(t)
        with precision(self.bits + GUARD):
            return self.traced.place(self.name(phase), state)

    def slopes(self, t: arb) -> arb_mat:
        """The derivative of `place` by the state at t."""
        phase = self.phase(t)
        state = self.at(t)
        with precision(self.bits + GUARD):
            return self.traced.slopes(self.name(phase), state)

    def jump_at_touch(self) -> arb_mat:
        """The jump matrix at touch, in the coordinates of the first mode.

        An error of the overlap a makes the spheres touch earlier by da/u, u being the closing
        speed; for so much longer the contact acts, at the rates f, instead of the free flight, at
        the rates f_0:

            1 + (f - f_0) (grad a)^T/u.
        """
        phase = self.phases[0]
        name = self.name(phase)
        state = phase.entered
        size = phase.mode.size
        with precision(self.bits + GUARD):
            in_contact = phase.field.run(state)
            in_flight = self.free_rates(name, state)
            closing = self.traced.closing[name][0].run(state)[0]
            by_overlap = self.traced.overlap_gradient.run(state)
            # 1 + (f - f_0) (grad a)^T/u, with the overlap a, u = da/dt.
            rows = [
                [(acts - flies) * slope / closing for slope in by_overlap]
                for acts, flies in zip(in_contact, in_flight, strict=True)
            ]
            jump = unit_matrix(size) + arb_mat(rows)
            if self.traced.phases.rests and not self.traced.phases.kt:
                jump = self.slip_stopped(state) * jump
            return jump

    def slip_stopped(self, state: Sequence[arb]) -> arb_mat:
        """What friction makes of an error at once where nothing slips and no spring gives way.

        With the slip s and the rates d of the state by friction, 1 - d (grad s)^T/(grad s . d): the
        impulse along d that stops the slip.
        """
        phases = self.traced.phases
        assert isinstance(phases, PlanarPhases)
        size = phases.size
        along_friction = Program(traced(phases.by_friction, size)[0]).run(state)
        by_state = traced_map(single(phases.slip), size)[1].run(state)
        rate = sum((a * b for a, b in zip(by_state, along_friction, strict=True)), arb(0))
        # 1 - d (grad s)^T/(grad s . d): an error of the slip s is taken back along d.
        rows = [[d * slope / rate for slope in by_state] for d in along_friction]
        return unit_matrix(size) - arb_mat(rows)

    def free_rates(self, name: str, state: Sequence[arb]) -> list[arb]:
        """The rates of a state in the coordinates of a mode of contact if nothing acted: places
        move with the velocities, and the clock goes.
        """
        # (d place/d state)^-1 times the rates of `place`: positions move with v, velocities and
        # spins are constant, the clock has the rate 1.
        place = self.traced.place(name, state)
        directions = self.traced.phases.directions
        rates = [arb(0)] * len(place)
        rates[:directions] = place[directions : 2 * directions]
        rates[-1] = arb(1)
        slopes = self.traced.slopes(name, state)
        column = inverted(slopes) * arb_mat(len(rates), 1, rates)
        return [row[0] for row in column.table()]

    def restitution(self) -> arb:
        """The restitution: the speed along the normal where the force ends over that at touch."""
        first = self.phases[0]
        last = self.phases[-2]
        _, _, _, states_at_end = last.crossing()
        closing_at_end, _ = self.traced.closing[self.name(last)]
        closing_at_touch, _ = self.traced.closing[self.name(first)]
        with precision(self.bits + GUARD):
            # e = -u(end)/u(touch), with the closing speed u.
            parting_speed = -closing_at_end.run(states_at_end)[0]
            ratio: arb = parting_speed / closing_at_touch.run(first.entered)[0]
            return ratio

    def part(self) -> None:
        """Follows the motion until the spheres are apart; SwitchError if that takes too long."""
        # The half period of the normal spring, in units of time, is pi/sqrt(k).
        half_period = arb.pi() / arb_of(self.traced.phases.k).sqrt()
        longest = arb(LONGEST).max(HALF_PERIODS * half_period)
        while self.name(self.phases[-1]) != "apart":
            last = self.phases[-1]
            if last.entered[-1] + arb_of(last.searched) > longest:
                raise SwitchError(
                    "time",
                    "the contact does not end within the time that is integrated",
                    float(longest),
                ).at(last.entered)
            self.follow()

    def stretches(self) -> Iterator[tuple[str, Piece, arb, arb]]:
        """The mode, the piece, and begin and end [unit of time, since the piece's begin] of what of
        it belongs to the contact, for all pieces in order of time.
        """
        for phase in self.phases[:-1]:
            assert phase.ends is not None
            _, when = phase.ends
            for piece in phase.pieces:
                if piece is phase.piece(when):
                    # The event ends the phase within this piece.
                    yield self.name(phase), piece, arb(0), when - arb_of(piece.begin)
                    break
                end = min(piece.end, phase.searched)
                yield self.name(phase), piece, arb(0), arb_of(end - piece.begin)

    def deepest(self) -> arb:
        """The largest overlap a: that where its rate, the closing speed, is first zero.

        SwitchError where that is not proved.
        """
        with precision(self.bits + GUARD):
            for name, piece, low, high in self.stretches():
                turn = first_crossing(watched(piece, self.traced.closing[name]), low, high)
                if turn is not None:
                    overlap: arb = self.traced.overlap.run(piece.at(turn))[0]
                    return overlap
        raise SwitchError("precision", "no turn of the overlap is proved", 0.0)

    def hardest(self) -> arb | None:
        """The largest normal force F = K a + C u: that at touch, or where F first begins to fall.

        None where F is not proved to fall from there on.
        """
        force = self.traced.force.run
        with precision(self.bits + GUARD):
            start = self.phases[0].entered
            # F is largest at touch if F' <= 0 there, otherwise at the first zero of F'; that is
            # proved where F' has no further zero while the force presses.
            rate_at_touch = self.traced.steepening["press"][0].run(start)[0]
            if sign(rate_at_touch, "dF/dt at touch") > 0:
                largest = None
            else:
                largest = force(start)[0]
            for name, piece, low, high in self.stretches():
                if name not in PRESSES:
                    break
                rate_of_force = self.traced.steepening[name]
                begin = low
                touching = 0
                if largest is None:
                    # F rises so far: its top is where the rate is first zero.
                    top = first_crossing(watched(piece, rate_of_force), low, high)
                    if top is None:
                        continue
                    largest = force(piece.at(top))[0]
                    begin = top
                    touching = 1
                falling = watched(piece, rate_of_force, touching, sense=-1)
                if first_crossing(falling, begin, high) is not None:
                    return None
            return largest


def watched(
    piece: Piece, programs: Sequence[Program], touching: int = 0, *, sense: int = 1
) -> Watched:
    """A function of the state, with its rate, along a piece; negated if `sense` is -1.

    `touching` is the order of its zero at the start.
    """

    def along_piece(program: Program) -> Along:
        return lambda t: sense * program.run(piece.at(t))[0]

    return Watched("an extreme", [along_piece(program) for program in programs], touching)
