"""Two solid spheres that collide under a linear contact law, in the frame of their centre of mass.

Start: centres on x, body 1 at negative x, touching (zero overlap) at t = 0: r1 = -(m2/M)(R1 + R2)
e_x, r2 = (m1/M)(R1 + R2) e_x, M = m1 + m2. Relative velocity v1 - v2 = closing_speed (cos angle,
sin angle, 0) [angle in rad], so that angle 0 is head-on and closing_speed is its size, not its
normal part; v1 = (m2/M)(v1 - v2), v2 = -(m1/M)(v1 - v2). `spins` are omega1 then omega2, in space
axes. Moments of inertia 2/5 m R^2.

Law, with overlap d = R1 + R2 - |r1 - r2|: normal force k d + c d'. cutoff zero_overlap: it acts,
pulling too, until d = 0; zero_force: max(0, k d + c d'), so that from t = 2 al/w on the spheres fly
freely, overlapping still for a while; `duration` is then the time at which the force ends. Friction
of body i acts at the lever l_i = R_i (branch R), R_i - d (R-d) or R_i - d/2 (R-d/2) along the
normal, for torque and for slip alike, and only while the normal force presses: the limit is
friction x max(0, k d + c d').

Proved: head-on (nothing slips, ever) in closed form; all else, with stick, slip and release, by
validated integration from event to event; in Cartesian vectors where spins and friction turn the
motion out of its plane (spatial_phases.py). Not certified: a slip, or a friction, that is too near
a limit to tell on which side it is; out of the plane a slip that ends, and a clipped spring whose
force fades. Scalars: duration and restitution (of the normal velocity; neither if an overlap never
ends), max_overlap, max_force.
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from math import pi, sqrt

from flint import arb, arb_mat

from refdem.core.truth import Ball
from refdem.errors import NotCertifiedError
from refdem.truth.balls import arb_of, ball_of
from refdem.truth.closed_form import per_precision
from refdem.truth.contact_motion import ContactMotion, TracedContact
from refdem.truth.contact_phases import ContactPhases
from refdem.truth.events.crossing import SwitchError
from refdem.truth.events.motion import HybridMotion
from refdem.truth.events.phase import Phase
from refdem.truth.events.truth import HybridFlow
from refdem.truth.growth import Grows, Retimed
from refdem.truth.head_on_contact import HeadOnContact
from refdem.truth.sphere_pair import SpherePair

NAMES = tuple(
    f"{kind}{body}.{axis}" for body in (1, 2) for kind in ("r", "v", "omega") for axis in "xyz"
)
"""The 18 quantities: r1.x r1.y r1.z v1.x .. omega1.z r2.x .. omega2.z."""
IN_PLANE = tuple(f"{kind}{body}.{axis}" for body in (1, 2) for kind in "rv" for axis in "xy")
MOVED = (*IN_PLANE, "omega1.z", "omega2.z")
"""What S displaces, and whose answers it counts."""


class TwoSpheres(HybridFlow):
    """Positions [m], velocities [m/s] and angular velocities [rad/s] of both, NAMES, at t >= 0.

    S(t) is that of the motion in its plane; out of it a head-on collision grows as across the
    normal. Where nothing slips S leaves friction out: a slip that a small displacement starts is
    soon stuck again.
    """

    def __init__(self, scale: Mapping[str, float], pair: SpherePair, *, digits: int = 40) -> None:
        super(HybridFlow, self).__init__(scale, digits=digits)
        self.spheres = pair
        self.phases = ContactPhases(pair, rubs=not pair.is_head_on)
        if pair.is_head_on:
            self.method = "closed form"
        else:
            self.method = HybridFlow.method
        self.witness = (
            "Taylor series in Cartesian coordinates with the switches found anew, energy, momenta"
        )

    def motion(self, bits: int) -> ContactMotion:
        """The motion at a precision, as far as it has been followed."""
        if "traced" not in self.kept:
            self.kept["traced"] = TracedContact(self.phases)
        if ("motion", bits) not in self.kept:
            self.kept["motion", bits] = ContactMotion(self.kept["traced"], bits)
        found: ContactMotion = self.kept["motion", bits]
        return found

    def clock(self, t: Fraction) -> arb:
        """A time in units of the phases'."""
        return arb_of(t / self.phases.time)

    def at(self, t: Fraction) -> dict[str, Ball]:
        if t < 0:
            raise NotCertifiedError("two-spheres: t < 0 is before the start")
        what = f"at t = {float(t):.17g} s"
        if self.spheres.is_head_on or t == 0:
            return self._certified(lambda: self.evaluate(arb_of(t)), what)
        return self.climbed(
            lambda motion: self.quantities(self.in_si(motion.place(self.clock(t)))), what
        )

    def forecast(self, t: Fraction, digits: int) -> float:
        """The forecast time of the contact, half a period of its spring, which the scalars ask for
        whatever t is; what comes after it costs nothing.
        """
        if self.spheres.is_head_on:
            return 0.0
        half_period = Fraction(pi / sqrt(float(self.phases.k)))
        return super().forecast(half_period, digits)

    def evaluate(self, t: arb) -> dict[str, arb]:
        """The 18 quantities at touch, or of a head-on contact."""
        spins = [arb_of(self.spheres.spins[axis]) for axis in (2, 5)]
        return self.quantities(
            [
                *(self.spheres.start() if t == 0 else HeadOnContact(self.spheres).relative(t)[:4]),
                *spins,
            ]
        )

    def units(self) -> list[Fraction]:
        """The units of x, y, vx, vy, o1, o2 [m, m/s, 1/s]."""
        turns = [self.phases.speed / radius for radius in self.spheres.radii]
        return [self.phases.length] * 2 + [self.phases.speed] * 2 + turns

    def in_si(self, place: Sequence[arb]) -> list[arb]:
        """x, y, vx, vy and the spins about z, from what a motion says of them."""
        return [value * arb_of(unit) for value, unit in zip(place, self.units(), strict=False)]

    def quantities(self, relative: Sequence[arb]) -> dict[str, arb]:
        """The 18 quantities from x, y, vx, vy of body 1 against body 2, and the spins about z."""
        x, y, vx, vy, *turning = relative
        values: list[arb] = []
        for body in (0, 1):
            share = arb_of((1 - 2 * body) * self.spheres.masses[1 - body] / self.spheres.total_mass)
            spin = [arb_of(part) for part in self.spheres.spins[3 * body : 3 * body + 2]]
            values += [
                share * x,
                share * y,
                arb(0),
                share * vx,
                share * vy,
                arb(0),
                *spin,
                turning[body],
            ]
        return dict(zip(NAMES, values, strict=True))

    def uncertified(self, error: SwitchError, what: str) -> NotCertifiedError:
        """The error that reports why certification ends, and where."""
        if not error.state:
            return NotCertifiedError(f"two-spheres {what}: {error.code}: {error}", code=error.code)
        place = self.kept["traced"].place("contact", error.state)
        state = {name: ball_of(value) for name, value in self.quantities(self.in_si(place)).items()}
        time = float(place[-1].mid()) * float(self.phases.time)
        told = f"two-spheres {what}: {error.code}: {error}; certified up to t = {time:.17g} s"
        return NotCertifiedError(told, code=error.code, time=time, state=state)

    def scalars(self) -> dict[str, Ball]:
        if self.spheres.is_head_on:
            return self._certified(lambda: HeadOnContact(self.spheres).constants(), "scalars")
        return self.climbed(self.extremes, "scalars")

    def extremes(self, motion: ContactMotion) -> dict[str, arb]:
        """duration, restitution, max_overlap, max_force."""
        motion.part()
        end = motion.events[-1]
        phases = self.phases
        hardest = motion.hardest()
        found = {
            "duration": end.time * arb_of(phases.time),
            "restitution": motion.restitution(),
            "max_overlap": motion.deepest() * arb_of(phases.length),
        }
        force = arb_of(self.spheres.effective_mass * phases.speed / phases.time)
        if hardest is None:
            return found
        return {**found, "max_force": hardest * force}

    @per_precision
    def growth(self) -> Grows:
        """The growth S in the clock of the phases."""
        return Retimed(super().growth(), self.phases.time)

    def beside(self, inner: arb_mat) -> arb_mat:
        """The coordinates of a mode but its clock, and then those of the centre of mass at the
        start.
        """
        count = inner.nrows() - 1
        drift = len(self.drifting())
        table = inner.table()
        rows = [table[i][:count] + [arb(0)] * drift for i in range(count)]
        return arb_mat(
            rows
            + [
                [arb(int(i == j)) for j in range(count + drift)]
                for i in range(count, count + drift)
            ]
        )

    def chart(self, motion: HybridMotion, phase: Phase, state: Sequence[arb]) -> arb_mat:
        """Errors of both bodies, as `bodies` has them, by those of the mode's coordinates and of
        the centre of mass at the start.
        """
        assert isinstance(motion, ContactMotion)
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

    def drifting(self) -> Sequence[int]:
        """The relative coordinates that have a counterpart of the centre of mass: places, then
        velocities.
        """
        return range(4)

    def drift(self, seconds: arb) -> list[list[arb]]:
        """Errors of the centre of mass, after a time, by those at the start: it moves uniformly."""
        count = len(self.drifting())
        return [
            [arb(1) if i == j else seconds if j == i + count // 2 else arb(0) for j in range(count)]
            for i in range(count)
        ]

    def bodies(self) -> arb_mat:
        """The coordinates MOVED and what only the mode knows, by x, y, vx, vy, the spins, the rest,
        and the centre of mass.
        """
        drifting = self.drifting()
        size = self.phases.size - 1
        shares = [arb_of(mass / sum(self.spheres.masses)) for mass in self.spheres.masses]
        count = size + len(drifting)
        rows = [[arb(0)] * count for _ in range(count)]
        for body, share in ((0, shares[1]), (1, -shares[0])):
            for i in drifting:
                row = rows[body * len(drifting) + i]
                row[i], row[size + i] = share, arb(1)
        for i in range(len(drifting), size):
            rows[len(drifting) + i][i] = arb(1)
        return arb_mat(rows)

    def counted(self) -> Sequence[str]:
        """The quantities in which errors are made and counted."""
        return MOVED

    def own_scales(self) -> list[arb]:
        """The scales of the quantities; of what only the mode knows, its unit."""
        sizes = [arb_of(self.scale[name]) for name in self.counted()]
        return sizes + [arb(1)] * (self.phases.size - 1 + len(self.drifting()) - len(sizes))

    def parts(self) -> list[int]:
        return [1] * len(self.own_scales())

    def struck(self) -> Sequence[int]:
        return range(len(self.counted()))

    def readings(self, motion: HybridMotion, t: arb) -> arb_mat:
        """The matrix that reads the quantities themselves."""
        count = len(self.own_scales())
        return arb_mat([[arb(int(i == j)) for j in range(count)] for i in self.struck()])
