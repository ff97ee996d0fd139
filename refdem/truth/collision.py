"""A truth of a collision under the linear law, followed from event to event.

Theorem: the quantities at t are those of the motion through the phases of the contact
(contact_phases.py in the plane, spatial_phases.py out of it), by validated integration through
events (events/truth.py). Errors are counted in the quantities of both bodies; the centre of mass
moves uniformly.

Hypotheses, and where each is checked:

* those of a motion through events, as listed in events/truth.py;
* t >= 0, after touch: `Collision.at`;
* the units of the phases are exact, so that S is that of the phases, read in the scales of both
  bodies: they are dyadic (contact_phases.py);
* a formula is used only if the exact parameters satisfy its conditions: `formula_at`.

Formula: x1 = x_c + m2/M r, x2 = x_c - m1/M r, with r = x1 - x2 (`moved_by_shares`); x_c + t v_c for
the centre of mass (`drift`).

This class is abstract; what collides is final: two spheres, three, one and a wall.
"""

from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from math import pi, sqrt
from typing import Any, Self

from flint import arb, arb_mat

from refdem.core.truth import Ball, Truth
from refdem.errors import NotCertifiedError
from refdem.truth.balls import Guarded, arb_of, precision, unit_matrix
from refdem.truth.contact_motion import ContactMotion, TracedContact
from refdem.truth.contact_phases import LinearContact
from refdem.truth.dual import Derivatives, flattened, unflattened
from refdem.truth.events.phase import Phase
from refdem.truth.events.truth import EventProof
from refdem.truth.growth import Stretch, inverted, smooth
from refdem.truth.reals import Number
from refdem.truth.refiner import Refiner
from refdem.truth.validated_ivp.integration import GUARD

FLIGHT = arb(2) ** -30
"""The flight before touch in which errors may be made, in the phases' unit of time."""
Formula = Callable[[], dict[str, arb]]
"""Quantities as balls at the current precision."""


@dataclass(frozen=True)
class Collision(Guarded, Truth):
    """The motion through a contact as quantities of the bodies, which `refiner` has the scales of.

    Errors are counted in the quantities of both bodies, while a mode has only their relative
    motion: `beside`, `chart` and `drift` add the centre of mass, which moves uniformly.
    """

    refiner: Refiner

    @cached_property
    @abstractmethod
    def phases(self) -> LinearContact:
        """The phases of the contact, in units of their own."""

    @property
    @abstractmethod
    def effective_mass(self) -> Number:
        """The mass [kg] of the relative motion."""

    @cached_property
    def proof(self) -> EventProof[ContactMotion]:
        """The proof that follows the phases from event to event, with the motions followed."""
        return EventProof(self, self.refiner, "two-spheres ")

    @abstractmethod
    def units(self) -> list[Fraction]:
        """The units of positions, velocities and spins of a motion [m, m/s, 1/s]."""

    @abstractmethod
    def quantities(self, relative: Sequence[arb]) -> dict[str, arb]:
        """Every quantity from the relative positions, velocities and spins (`relative`), in SI
        units.
        """

    @abstractmethod
    def drifting(self) -> Sequence[int]:
        """The numbers of the relative coordinates that the centre of mass has too: positions, then
        velocities.
        """

    @abstractmethod
    def bodies(self) -> arb_mat:
        """The derivative of the quantities `counted`, and of the coordinates that only the mode
        has, by the coordinates of the mode and those of the centre of mass.
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
        return self.refiner.scale

    @property
    def clock_unit(self) -> Fraction:
        """Seconds in a unit of the clock of the phases."""
        return self.phases.time

    def refined(self, digits: int) -> Self:
        """The same truth with radii of at most 10^-digits."""
        other = copy(self)
        vars(other).update(refiner=self.refiner.to(digits), proof=self.proof.to(digits))
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
            return self.refiner.balls(formula, what)
        return self.proof.climbed(lambda motion: self.moved(motion, t), what)

    def derivatives(self, t: Fraction, count: int) -> Derivatives:
        """The derivatives at t of every quantity by each of `count` parameters, by which the
        numbers of this truth carry their own derivatives (dual.py).
        """
        what = f"derivatives at t = {float(t):.17g} s"
        formula = self.formula_at(t)
        if formula is None:
            return self.proof.derivatives(lambda motion: self.moved(motion, t), what, count)
        values: Formula = formula
        flat = self.refiner.balls(lambda: flattened(values(), count), what)
        return unflattened(flat, count)

    def moved(self, motion: ContactMotion, t: Fraction) -> dict[str, arb]:
        """Every quantity of a motion at the time t [s]."""
        relative = motion.place(self.clock(t))
        return self.quantities(self.in_si(relative))

    def scalars(self) -> dict[str, Ball]:
        """Values that do not depend on time."""
        formula = self.formula_of_scalars()
        if formula is not None:
            return self.refiner.balls(formula, "scalars")
        return self.proof.climbed(self.extremes, "scalars")

    def sensitivity(self, t: Fraction) -> float:
        """S(t), with the jump matrix at each event.

        Where nothing slips friction acts on errors alone: a slip that an error starts at touch
        stretches the tangential spring, or is stopped at once without one.
        """
        return self.proof.sensitivity(t)

    def forecast(self, t: Fraction, digits: int) -> float:
        """CPU seconds that `at(t)` to so many digits is about to cost: those of the contact, which
        lasts half a period of its spring.

        The scalars need the whole contact, whatever t is; the motion after it takes no time to
        compute.
        """
        if self.formula_of_scalars() is not None:
            return 0.0
        half_period = Fraction(pi / sqrt(float(self.phases.k)))
        return self.proof.forecast(half_period, digits)

    def motion(self, bits: int) -> ContactMotion:
        """The motion at a precision, as far as it has been followed."""
        return self.proof.motion(bits)

    def motion_at(self, bits: int, parameters: int = 0) -> ContactMotion:
        """The motion, to be followed at a precision; with a number of parameters as coordinates
        (events/directed.py).
        """
        return ContactMotion(self.traced(), bits, parameters)

    def traced(self) -> TracedContact:
        """The phases of the contact as programs."""
        kept: dict[Any, Any] = self.proof.kept
        if "traced" not in kept:
            kept["traced"] = TracedContact(self.phases)
        contact: TracedContact = kept["traced"]
        return contact

    def clock(self, t: Fraction) -> arb:
        """The time t [s] in the phases' unit of time."""
        return arb_of(t / self.phases.time)

    def in_si(self, place: Sequence[arb]) -> list[arb]:
        """Positions, velocities and spins of a motion, from the units of the phases to SI units.

        What follows them in `place` (spring, clock) is left out.
        """
        return [value * arb_of(unit) for value, unit in zip(place, self.units(), strict=False)]

    def last_state(self, state: Sequence[arb]) -> tuple[dict[str, arb], float]:
        """The quantities and the time [s] of a state with which a motion ended."""
        place = self.traced().place("contact", state)
        time = float(place[-1].mid()) * float(self.phases.time)
        return self.quantities(self.in_si(place)), time

    def contact_extremes(self, motion: ContactMotion) -> dict[str, arb]:
        """The scalars of a contact: duration [s], restitution, max_overlap [m], and max_force [N]
        where it is proved.
        """
        motion.part()
        end = motion.events[-1]
        phases = self.phases
        largest_force = motion.hardest()
        scalars = {
            "duration": end.time * arb_of(phases.time),
            "restitution": motion.restitution(),
            "max_overlap": motion.deepest() * arb_of(phases.length),
        }
        if largest_force is None:
            return scalars
        # The unit of force is m V/T.
        unit_of_force = arb_of(self.effective_mass * phases.speed / phases.time)
        return {**scalars, "max_force": largest_force * unit_of_force}

    def beside(self, inner: arb_mat) -> arb_mat:
        """The derivative of a mode's coordinates without its clock (`inner`, less a row and a
        column), and beside it the unit matrix of the centre of mass at the start.
        """
        count = inner.nrows() - 1
        drift = len(self.drifting())
        table = inner.table()
        rows = [table[i][:count] + [arb(0)] * drift for i in range(count)]
        for i in range(count, count + drift):
            rows.append([arb(int(i == j)) for j in range(count + drift)])
        return arb_mat(rows)

    def chart(self, motion: ContactMotion, phase: Phase, state: Sequence[arb]) -> arb_mat:
        """The errors of both bodies, in scales, by those of the mode's coordinates and of the
        centre of mass at the start.

        1/scale . bodies . diag(units . d place/d state, drift): from the coordinates of the mode to
        relative positions, velocities and spins in SI units, and on to those of both bodies.
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
        centre_of_mass = [[arb(0)] * count + row for row in self.drift(seconds)]
        rows = (self.bodies() * arb_mat(relative + centre_of_mass)).table()
        scaled_rows = []
        for row, scale in zip(rows, self.scales_of_coordinates(), strict=True):
            scaled_rows.append([entry / scale for entry in row])
        return arb_mat(scaled_rows)

    def approach(self, motion: ContactMotion) -> list[Stretch]:
        """The flight before touch, which ends with the jump matrix of touch.

        An error of the places that is there at touch changes when the spheres touch. The flight may
        be of any length. There an error of a velocity becomes one of the place, and nothing else
        changes: M(s) = 1 + s N.
        """
        phase = motion.phases[0]
        with precision(motion.bits + GUARD):
            chart = self.chart(motion, phase, phase.entered)
            count = chart.nrows()
            # C J C^-1: the jump matrix J in the coordinates of the mode becomes that in those of C,
            # which is `chart`.
            jump = chart * self.beside(motion.jump_at_touch()) * inverted(chart)
            drifting = self.flight_slopes(count)

        def fundamental(since: arb) -> arb_mat:
            return unit_matrix(count) + since * drifting

        return [smooth(-FLIGHT, FLIGHT, fundamental, jump=jump, affine=True)]

    def flight_slopes(self, count: int) -> arb_mat:
        """N (count, count): the rate of each coordinate of `chart` by the others in free flight, in
        scales, per unit of the clock.
        """
        names = list(self.counted())
        rows = [[arb(0)] * count for _ in range(count)]
        for place, name in enumerate(names):
            if name.startswith("r"):
                velocity = "v" + name[1:]
                # d(r/scale(r))/dtau = (v/scale(v)) scale(v) T/scale(r), with t = T tau.
                ratio = self.scale[velocity] * self.phases.time / self.scale[name]
                rows[place][names.index(velocity)] = arb_of(ratio)
        return arb_mat(rows)

    def drift(self, seconds: arb) -> list[list[arb]]:
        """The errors of the centre of mass after `seconds` by those at the start: x + t v."""
        count = len(self.drifting())
        rows = [[arb(int(i == j)) for j in range(count)] for i in range(count)]
        for position in range(count // 2):
            velocity = position + count // 2
            rows[position][velocity] = seconds
        return rows

    def scales_of_coordinates(self) -> list[arb]:
        """The scales of the quantities `counted`; 1 for each coordinate that only the mode has."""
        scales = [arb_of(self.scale[name]) for name in self.counted()]
        count = self.phases.size - 1 + len(self.drifting())
        return scales + [arb(1)] * (count - len(scales))

    def parts(self) -> list[int]:
        """Every coordinate is measured alone."""
        return [1] * len(self.scales_of_coordinates())

    def struck(self) -> Sequence[int]:
        """The coordinates in which errors are made: those of the bodies."""
        return range(len(self.counted()))

    def readings(self, motion: ContactMotion, t: arb) -> arb_mat:
        """The rows of the unit matrix for the quantities: they are coordinates themselves."""
        count = len(self.scales_of_coordinates())
        return arb_mat([[arb(int(i == j)) for j in range(count)] for i in self.struck()])


def moved_by_shares(shares: Sequence[arb], drifting: Sequence[int], size: int) -> arb_mat:
    """The Jacobian of the coordinates of two bodies, and of further ones of the mode, by those of
    the relative motion, the spins, those further coordinates, and the centre of mass.

    x1 = x_c + m2/M r, x2 = x_c - m1/M r, with r = x1 - x2. `shares` are m1/M and m2/M, `drifting`
    the numbers of the relative positions and velocities, `size` is the number of coordinates of the
    mode without its clock.
    """
    count = size + len(drifting)
    rows = [[arb(0)] * count for _ in range(count)]
    # x1 = x_c + m2/M r, x2 = x_c - m1/M r, and the same for velocities.
    for body, share in ((0, shares[1]), (1, -shares[0])):
        for i in drifting:
            row = rows[body * len(drifting) + i]
            row[i] = share
            row[size + i] = arb(1)
    # Spins and further coordinates of the mode are not changed.
    for i in range(len(drifting), size):
        rows[len(drifting) + i][i] = arb(1)
    return arb_mat(rows)
