"""A truth of a collision under the linear law, followed from event to event.

Theorem: the quantities at t are those of the motion through the phases of the contact
(contact_phases.py in the plane, spatial_phases.py out of it), by validated integration through
events (events/truth.py, where the hypotheses are, and where each is checked). Phases are told in
units of their own, which are exact; so S is that of the phases, read in the scales of both bodies.

This class is abstract; what collides is final: two spheres, three, one and a wall.
"""

from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence
from copy import copy
from fractions import Fraction
from math import pi, sqrt
from typing import Any, Self

from flint import arb, arb_mat

from refdem.core.truth import Ball, Truth
from refdem.errors import NotCertifiedError
from refdem.truth.balls import Guarded, arb_of
from refdem.truth.contact_motion import ContactMotion, TracedContact
from refdem.truth.contact_phases import LinearContact
from refdem.truth.events.phase import Phase
from refdem.truth.events.truth import EventProof
from refdem.truth.reals import Number
from refdem.truth.refiner import Refiner, Size

Formula = Callable[[], dict[str, arb]]
"""Quantities as balls at the current precision."""


class Collision(Guarded, Truth):
    """The motion through a contact, in the units of its phases, as quantities of the bodies."""

    phases: LinearContact
    proof: EventProof[ContactMotion]
    effective_mass: Number

    def collide(
        self,
        scale: Mapping[str, Size],
        phases: LinearContact,
        effective_mass: Number,
        *,
        digits: int,
    ) -> None:
        """Sets what is followed, and to how many digits."""
        self.phases = phases
        self.effective_mass = effective_mass
        self.proof = EventProof(self, Refiner.of(scale, digits=digits), "two-spheres ")

    @abstractmethod
    def units(self) -> list[Fraction]:
        """The units of positions, velocities and spins of a motion [m, m/s, 1/s]."""

    @abstractmethod
    def quantities(self, relative: Sequence[arb]) -> dict[str, arb]:
        """Every quantity from what a motion says, in SI units."""

    @abstractmethod
    def drifting(self) -> Sequence[int]:
        """The relative coordinates that have a counterpart of the centre of mass: places, then
        velocities.
        """

    @abstractmethod
    def bodies(self) -> arb_mat:
        """The coordinates `counted`, and what only the mode knows, by the coordinates of the mode
        and those of the centre of mass.
        """

    @abstractmethod
    def counted(self) -> Sequence[str]:
        """The quantities in which errors are made and counted."""

    @abstractmethod
    def formula_at(self, t: Fraction) -> Formula | None:
        """The quantities at t where a formula has them; None where the motion is followed."""

    @abstractmethod
    def formula_of_scalars(self) -> Formula | None:
        """The scalars where a formula has them; None where the motion is followed."""

    @abstractmethod
    def extremes(self, motion: ContactMotion) -> dict[str, arb]:
        """The scalars of a motion."""

    @property
    def scale(self) -> Mapping[str, Fraction]:
        """The size of each quantity, against which its error counts."""
        return self.proof.refiner.scale

    @property
    def clock_unit(self) -> Fraction:
        """Seconds in a unit of the clock of the phases."""
        return self.phases.time

    def refined(self, digits: int) -> Self:
        """The same truth with radii of at most 10^-digits."""
        other = copy(self)
        other.proof = self.proof.to(digits)
        return other

    def at(self, t: Fraction) -> dict[str, Ball]:
        """Every quantity at the exact time t [s]; raises NotCertifiedError where it cannot be
        proved.
        """
        if t < 0:
            raise NotCertifiedError("two-spheres: t < 0 is before the start")
        what = f"at t = {float(t):.17g} s"
        formula = self.formula_at(t)
        if formula is not None:
            return self.proof.refiner.balls(formula, what)
        return self.proof.climbed(
            lambda motion: self.quantities(self.in_si(motion.place(self.clock(t)))), what
        )

    def scalars(self) -> dict[str, Ball]:
        """Values that do not depend on time."""
        formula = self.formula_of_scalars()
        if formula is not None:
            return self.proof.refiner.balls(formula, "scalars")
        return self.proof.climbed(self.extremes, "scalars")

    def sensitivity(self, t: Fraction) -> float:
        """S(t), with the jump matrix at each event; where nothing slips it leaves friction out: a
        slip that a small displacement starts is soon stuck again.
        """
        return self.proof.sensitivity(t)

    def forecast(self, t: Fraction, digits: int) -> float:
        """The forecast of the contact, half a period of its spring, which the scalars ask for
        whatever t is; what comes after it costs nothing.
        """
        if self.formula_of_scalars() is not None:
            return 0.0
        half_period = Fraction(pi / sqrt(float(self.phases.k)))
        return self.proof.forecast(half_period, digits)

    def motion(self, bits: int) -> ContactMotion:
        """The motion at a precision, as far as it has been followed."""
        return self.proof.motion(bits)

    def motion_at(self, bits: int) -> ContactMotion:
        """The motion, to be followed at a precision."""
        return ContactMotion(self.traced(), bits)

    def traced(self) -> TracedContact:
        """The phases of the contact as programs."""
        kept: dict[Any, Any] = self.proof.kept
        if "traced" not in kept:
            kept["traced"] = TracedContact(self.phases)
        found: TracedContact = kept["traced"]
        return found

    def clock(self, t: Fraction) -> arb:
        """A time in units of the phases'."""
        return arb_of(t / self.phases.time)

    def in_si(self, place: Sequence[arb]) -> list[arb]:
        """What a motion says of places, velocities and spins, in SI units."""
        return [value * arb_of(unit) for value, unit in zip(place, self.units(), strict=False)]

    def last_state(self, state: Sequence[arb]) -> tuple[dict[str, arb], float]:
        """The quantities and the time [s] of a state with which a motion ended."""
        place = self.traced().place("contact", state)
        time = float(place[-1].mid()) * float(self.phases.time)
        return self.quantities(self.in_si(place)), time

    def contact_extremes(self, motion: ContactMotion) -> dict[str, arb]:
        """duration, restitution, max_overlap, and max_force where it is proved."""
        motion.part()
        end = motion.events[-1]
        phases = self.phases
        hardest = motion.hardest()
        found = {
            "duration": end.time * arb_of(phases.time),
            "restitution": motion.restitution(),
            "max_overlap": motion.deepest() * arb_of(phases.length),
        }
        if hardest is None:
            return found
        force = arb_of(self.effective_mass * phases.speed / phases.time)
        return {**found, "max_force": hardest * force}

    def beside(self, inner: arb_mat) -> arb_mat:
        """The coordinates of a mode but its clock, and then those of the centre of mass at the
        start.
        """
        count = inner.nrows() - 1
        drift = len(self.drifting())
        table = inner.table()
        rows = [table[i][:count] + [arb(0)] * drift for i in range(count)]
        kept = [
            [arb(int(i == j)) for j in range(count + drift)] for i in range(count, count + drift)
        ]
        return arb_mat(rows + kept)

    def chart(self, motion: ContactMotion, phase: Phase, state: Sequence[arb]) -> arb_mat:
        """Errors of both bodies, as `bodies` has them, by those of the mode's coordinates and of
        the centre of mass at the start.
        """
        slopes = motion.traced.slopes(motion.name(phase), state).table()
        count = len(slopes) - 1
        drift = len(self.drifting())
        units = [arb_of(unit) for unit in self.units()]
        units += [arb(1)] * (count - len(units))
        relative = [
            [entry * unit for entry in row[:count]] + [arb(0)] * drift
            for row, unit in zip(slopes[:count], units, strict=True)
        ]
        seconds = state[-1] * arb_of(self.phases.time)
        moved = arb_mat(relative + [[arb(0)] * count + row for row in self.drift(seconds)])
        rows = (self.bodies() * moved).table()
        return arb_mat(
            [
                [entry / size for entry in row]
                for row, size in zip(rows, self.own_scales(), strict=True)
            ]
        )

    def drift(self, seconds: arb) -> list[list[arb]]:
        """Errors of the centre of mass, after a time, by those at the start: it moves uniformly."""
        count = len(self.drifting())
        rows = [[arb(int(i == j)) for j in range(count)] for i in range(count)]
        for place in range(count // 2):
            velocity = place + count // 2
            rows[place][velocity] = seconds
        return rows

    def own_scales(self) -> list[arb]:
        """The scales of the quantities; of what only the mode knows, its unit."""
        sizes = [arb_of(self.scale[name]) for name in self.counted()]
        return sizes + [arb(1)] * (self.phases.size - 1 + len(self.drifting()) - len(sizes))

    def parts(self) -> list[int]:
        """Every coordinate is measured alone."""
        return [1] * len(self.own_scales())

    def struck(self) -> Sequence[int]:
        """Errors are made in the coordinates of the bodies."""
        return range(len(self.counted()))

    def readings(self, motion: ContactMotion, t: arb) -> arb_mat:
        """The quantities themselves."""
        count = len(self.own_scales())
        return arb_mat([[arb(int(i == j)) for j in range(count)] for i in self.struck()])


def moved_by_shares(shares: Sequence[arb], drifting: Sequence[int], size: int) -> arb_mat:
    """The coordinates of two bodies and what only the mode knows, by those of the relative motion,
    the spins, the rest, and the centre of mass.

    Body 1 has the share m2/M of the relative motion, body 2 the share -m1/M.
    """
    count = size + len(drifting)
    rows = [[arb(0)] * count for _ in range(count)]
    for body, share in ((0, shares[1]), (1, -shares[0])):
        for i in drifting:
            row = rows[body * len(drifting) + i]
            row[i] = share
            row[size + i] = arb(1)
    for i in range(len(drifting), size):
        rows[len(drifting) + i][i] = arb(1)
    return arb_mat(rows)
