"""The collision of two spheres from phase to phase, at one precision: places, their derivatives by
the start, and extremes.
"""

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Any

from flint import arb, arb_mat

from refdem.truth.balls import arb_of, precision
from refdem.truth.contact_phases import LinearContact
from refdem.truth.events.crossing import Along, SwitchError, Watched, first_crossing, sign
from refdem.truth.events.motion import Followed, first_entry
from refdem.truth.events.phase import Phase
from refdem.truth.events.system import Traced, along, lie_derivatives
from refdem.truth.traced_field import Program, traced
from refdem.truth.validated_ivp.integration import GUARD, Piece

LONGEST = 128
"""Units of time, each at most the shortest of the law: a contact that has not ended by then is
left.
"""
PRESSES = ("press", "slip", "slip back", "stick", "hold")


HIGHEST = 2
"""Guards of a contact vanish at an entry to the second order at most."""


class TracedContact:
    """A pair's modes as programs, with those of the places and of what has extremes."""

    def __init__(self, phases: LinearContact) -> None:
        self.phases = phases
        modes = phases.modes()
        self.modes = {
            name: Traced(mode, phases.size, partial(lie_derivatives, highest=HIGHEST))
            for name, mode in modes.items()
        }
        self.places = {
            flies: traced_map(partial(phases.place, "apart" if flies else "contact"), phases.size)
            for flies in (False, True)
        }
        self.force, self.overlap = (
            Program(traced(single(value), phases.size)[0])
            for value in (phases.force, phases.overlap)
        )
        contact = {name: mode for name, mode in modes.items() if name != "apart"}
        self.closing = {
            name: rates(phases.closing, mode.field, phases.size) for name, mode in contact.items()
        }
        self.steepening = {
            name: rates(phases.steepening, mode.field, phases.size)
            for name, mode in contact.items()
        }

    def place(self, mode: str, y: Sequence[arb]) -> list[arb]:
        """x, y, vx, vy, o1, o2, s, clock; in space as SpatialPhases says."""
        return self.places[mode == "apart"][0].run(y)

    def slopes(self, mode: str, y: Sequence[arb]) -> arb_mat:
        """The derivatives of the quantities by the state, as a square matrix."""
        return arb_mat(self.phases.size, self.phases.size, self.places[mode == "apart"][1].run(y))


def single(value: Callable[[Sequence[Any]], Any]) -> Callable[[Sequence[Any]], list[Any]]:
    """A function of the state as a map to one number."""
    return lambda y: [value(y)]


def traced_map(
    function: Callable[[Sequence[Any]], Sequence[Any]], size: int
) -> tuple[Program, Program]:
    """A map of a state of that size, and its Jacobian row by row."""
    outputs, rows = traced(function, size)
    return Program(outputs), Program([entry for row in rows for entry in row])


def rates(
    value: Callable[[Sequence[Any]], Any],
    field: Callable[[Sequence[Any]], Sequence[Any]],
    size: int,
) -> list[Program]:
    """A function of the state and its rate along a field."""
    nodes, _ = traced(lambda y: [value(y), *field(y)], size)
    return [Program([nodes[0]]), Program([along(nodes[0], nodes[1:])])]


class ContactMotion(Followed):
    """A motion that knows when the spheres part, how deep they press, and how hard."""

    def __init__(self, traced_contact: TracedContact, bits: int) -> None:
        self.traced = traced_contact
        with precision(bits):
            start = [value() for value in traced_contact.phases.start()]
            entry = first_entry(traced_contact.phases.first, start)
            self.begin(traced_contact.modes, start, entry, bits, None)

    def name(self, phase: Phase) -> str:
        """The name of the mode that a phase is in."""
        return next(name for name, mode in self.modes.items() if mode is phase.mode)

    def place(self, t: arb) -> list[arb]:
        """x, y, vx, vy, o1, o2, s, clock at the time t."""
        phase = self.phase(t)
        state = self.at(t)
        with precision(self.bits + GUARD):
            return self.traced.place(self.name(phase), state)

    def slopes(self, t: arb) -> arb_mat:
        """The derivative of these by the state at t."""
        phase = self.phase(t)
        state = self.at(t)
        with precision(self.bits + GUARD):
            return self.traced.slopes(self.name(phase), state)

    def restitution(self) -> arb:
        """Speed along the normal where the force ends over that at touch."""
        closing = {name: programs[0].run for name, programs in self.traced.closing.items()}
        first = self.phases[0]
        last = self.phases[-2]
        with precision(self.bits + GUARD):
            found: arb = (
                -closing[self.name(last)](last.crossing()[3])[0]
                / closing[self.name(first)](first.entered)[0]
            )
            return found

    def part(self) -> None:
        """Follows the motion until the spheres are apart; SwitchError if that takes too long."""
        while self.name(self.phases[-1]) != "apart":
            last = self.phases[-1]
            if last.entered[-1] + arb_of(last.searched) > LONGEST:
                raise SwitchError(
                    "time", "the contact does not end within the time that is integrated", LONGEST
                ).at(last.entered)
            self.follow()

    def stretches(self) -> Iterator[tuple[str, Piece, arb, arb]]:
        """Mode, piece, begin and end of each piece of the contact since its own begin; the last one
        ends with a phase.
        """
        for phase in self.phases[:-1]:
            assert phase.ends is not None
            for piece in phase.pieces:
                end = min(piece.end, phase.searched)
                final = phase.ends[1] - arb_of(piece.begin)
                if piece is phase.piece(phase.ends[1]):
                    high = final
                else:
                    high = arb_of(end - piece.begin)
                yield self.name(phase), piece, arb(0), high
                if high is final:
                    break

    def deepest(self) -> arb:
        """The largest overlap: where its rate is first zero."""
        with precision(self.bits + GUARD):
            for name, piece, low, high in self.stretches():
                turn = first_crossing(watched(piece, self.traced.closing[name]), low, high)
                if turn is not None:
                    found: arb = self.traced.overlap.run(piece.at(turn))[0]
                    return found
        raise SwitchError("precision", "no turn of the overlap is proved", 0.0)

    def hardest(self) -> arb | None:
        """The largest normal force (K a + C u), at the start or where it first falls.

        None where it is not proved to fall from there on.
        """
        force = self.traced.force.run
        with precision(self.bits + GUARD):
            start = self.phases[0].entered
            rises = sign(self.traced.steepening["press"][0].run(start)[0], "dF/dt at touch") > 0
            if rises:
                most = None
            else:
                most = force(start)[0]
            for name, piece, low, high in self.stretches():
                if name not in PRESSES:
                    break
                begin = low
                touching = 0
                if most is None:
                    top = first_crossing(watched(piece, self.traced.steepening[name]), low, high)
                    if top is None:
                        continue
                    most = force(piece.at(top))[0]
                    begin = top
                    touching = 1
                if (
                    first_crossing(
                        watched(piece, self.traced.steepening[name], touching, sense=-1),
                        begin,
                        high,
                    )
                    is not None
                ):
                    return None
            return most


def watched(
    piece: Piece, programs: Sequence[Program], touching: int = 0, *, sense: int = 1
) -> Watched:
    """A function of the state (or its negative) along a piece."""

    def seen(program: Program) -> Along:
        return lambda t: sense * program.run(piece.at(t))[0]

    return Watched("an extreme", [seen(program) for program in programs], touching)
