"""Two solid spheres that collide under a linear contact law, in the frame of their centre of mass.

Start: centres on x, body 1 at negative x, touching (zero overlap) at t = 0: r1 = -(m2/M)(R1 + R2) e_x, r2 = (m1/M)(R1 + R2) e_x,
M = m1 + m2. Relative velocity v1 - v2 = closing_speed (cos angle, sin angle, 0) [angle in rad], so that angle 0 is head-on and
closing_speed is its size, not its normal part; v1 = (m2/M)(v1 - v2), v2 = -(m1/M)(v1 - v2). `spins` are omega1 then omega2, in
space axes. Moments of inertia 2/5 m R^2.

Law, with overlap d = R1 + R2 - |r1 - r2|: normal force k d + c d'. cutoff zero_overlap: it acts, pulling too, until d = 0;
zero_force: max(0, k d + c d'), so that from t = 2 al/w on the spheres fly freely, overlapping still for a while; `duration` is then
the time at which the force ends. Friction of body i acts at the lever l_i = R_i (branch R), R_i - d (R-d) or R_i - d/2 (R-d/2) along
the normal, for torque and for slip alike, and only while the normal force presses: the limit is friction x max(0, k d + c d').

Proved: head-on (nothing slips, ever) in closed form; all else, with stick, slip and release, by validated integration from event to
event; in Cartesian vectors where spins and friction turn the motion out of its plane (spatial_phases.py). Not certified: a slip, or a
friction, that is too near a limit to tell on which side it is; out of the plane a slip that ends, and a clipped spring whose force fades.
Scalars: duration and restitution (of the normal velocity; neither if an overlap never ends), max_overlap, max_force.
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from itertools import pairwise

import numpy as np
from flint import arb, arb_mat
from numpy.typing import NDArray

from refdem.core.parameters import Parameters
from refdem.core.truth import Ball, Truth
from refdem.errors import NotCertifiedError
from refdem.truth.balls import arb_of, ball_of
from refdem.truth.contact_motion import ContactMotion, TracedContact
from refdem.truth.contact_phases import ContactPhases
from refdem.truth.events.crossing import SwitchError
from refdem.truth.events.truth import HybridFlow
from refdem.truth.head_on_contact import HeadOnContact
from refdem.truth.smooth_flow import ORIGINS
from refdem.truth.sphere_pair import SpherePair, sphere_pair

Array = NDArray[np.float64]
NAMES = tuple(f"{kind}{body}.{axis}" for body in (1, 2) for kind in ("r", "v", "omega") for axis in "xyz")
"""The 18 quantities: r1.x r1.y r1.z v1.x .. omega1.z r2.x .. omega2.z."""
IN_PLANE = tuple(f"{kind}{body}.{axis}" for body in (1, 2) for kind in "rv" for axis in "xy")
MOVED = (*IN_PLANE, "omega1.z", "omega2.z")
"""What S displaces, and whose answers it counts."""


class TwoSpheres(HybridFlow):
    """Positions [m], velocities [m/s] and angular velocities [rad/s] of both, NAMES, at t >= 0.

    S(t) is that of the motion in its plane; out of it a head-on collision grows as across the normal. Where nothing slips S leaves
    friction out: a slip that a small displacement starts is soon stuck again.
    """

    def __init__(self, scale: Mapping[str, float], pair: SpherePair, *, digits: int = 40) -> None:
        super(HybridFlow, self).__init__(scale, digits=digits)
        self.spheres = pair
        self.phases = ContactPhases(pair, rubs=not pair.is_head_on)
        self.method = "closed form" if pair.is_head_on else HybridFlow.method
        self.witness = "Taylor series in Cartesian coordinates with the switches found anew, energy, momenta"

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
        return self.climbed(lambda motion: self.quantities(self.in_si(motion.place(self.clock(t)))), what)

    def forecast(self, t: Fraction, digits: int) -> float:
        return super().forecast(t / self.phases.time, digits) if self.method == HybridFlow.method else 0.0

    def evaluate(self, t: arb) -> dict[str, arb]:
        """The 18 quantities at touch, or of a head-on contact."""
        spins = [arb_of(self.spheres.spins[axis]) for axis in (2, 5)]
        return self.quantities([*(self.spheres.start() if t == 0 else HeadOnContact(self.spheres).relative(t)[:4]), *spins])

    def units(self) -> list[Fraction]:
        """Of x, y, vx, vy, o1, o2 [m, m/s, 1/s]."""
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
            share = arb_of((1 - 2 * body) * self.spheres.masses[1 - body] / sum(self.spheres.masses))
            spin = [arb_of(part) for part in self.spheres.spins[3 * body : 3 * body + 2]]
            values += [share * x, share * y, arb(0), share * vx, share * vy, arb(0), *spin, turning[body]]
        return dict(zip(NAMES, values, strict=True))

    def uncertified(self, error: SwitchError, what: str) -> NotCertifiedError:
        """The honest end."""
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
        end, phases = motion.events[-1], self.phases
        hardest = motion.hardest()
        found = {
            "duration": end.time * arb_of(phases.time),
            "restitution": motion.restitution(),
            "max_overlap": motion.deepest() * arb_of(phases.length),
        }
        force = arb_of(self.spheres.effective_mass * phases.speed / phases.time)
        return found if hardest is None else {**found, "max_force": hardest * force}

    def sensitivity(self, t: Fraction) -> float:
        return self.growth(self.transfer(Fraction(0), t), t) if t else 1.0

    def sensitivities(self, times: Sequence[Fraction]) -> list[float]:
        """S at every time: the largest growth of an error made at t = 0 or at an earlier one of (up to 32 of) the times.

        Sticking forgets: its flow has no inverse, so growths are products of those from sample to sample.
        """
        found, every = [1.0] * len(times), max(1, -(-len(times) // ORIGINS))
        steps = [self.transfer(first, second) for first, second in pairwise(times)]
        for first in range(0, len(times), every):
            whole = np.eye(self.phases.size)
            for i in range(first + 1, len(times)):
                whole = steps[i - 1] @ whole
                found[i] = max(found[i], self.growth(whole, times[i] - times[first]))
        return found

    def transfer(self, first: Fraction, second: Fraction) -> Array:
        """d (x, y, vx, vy, spins, spring, clock) at one time by that at an earlier one, to rounding."""
        if (first, second) not in self.kept:
            a, b = self.clock(first), self.clock(second)

            def moved(motion: ContactMotion) -> Array:
                before, after = (_floats(motion.slopes(t)) for t in (a, b))
                return after @ motion.transfer(a, b) @ np.linalg.inv(before)

            self.kept[first, second] = self.followed(moved, f"S from t = {float(first):.17g} s to {float(second):.17g} s")
        found: Array = self.kept[first, second]
        return found

    def growth(self, whole: Array, elapsed: Fraction) -> float:
        """Largest sum, over the coordinates MOVED of both bodies, of the scaled answers of one; the centre of mass moves uniformly."""
        units = np.array([float(unit) for unit in self.units()])
        slopes = whole[:6, :6] * units[:, None] / units
        shares = np.array([float(mass) for mass in self.spheres.masses]) / float(sum(self.spheres.masses))
        apart, centre = np.zeros((6, 10)), np.zeros((4, 10))
        apart[:4, :4], apart[:4, 4:8], apart[4:, 8:] = np.eye(4), -np.eye(4), np.eye(2)
        centre[:, :4], centre[:, 4:8] = shares[0] * np.eye(4), shares[1] * np.eye(4)
        centre[:2] += float(elapsed) * centre[2:]
        moved = slopes @ apart
        answers = np.vstack([centre + shares[1] * moved[:4], centre - shares[0] * moved[:4], moved[4:]])
        sizes = np.array([float(self.scale[name]) for name in MOVED])
        return max(1.0, float(np.max(np.abs(answers) @ sizes / sizes))) * (1 + 2.0**-40)


def _floats(matrix: arb_mat) -> Array:
    return np.array([[float(x.mid()) for x in row] for row in matrix.table()])


def truth(p: Parameters, scale: Mapping[str, float]) -> Truth:
    """The truth of case two-spheres, in its plane or in space; `scale` of the 18 quantities NAMES."""
    from refdem.truth.closed_forms.spinning_spheres import SpinningSpheres

    pair = sphere_pair(p)
    return SpinningSpheres(scale, pair) if pair.leaves_plane else TwoSpheres(scale, pair)
