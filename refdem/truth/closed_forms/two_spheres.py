"""Two solid spheres that collide under a linear contact law, in the frame of their centre of mass.

Start: centres on x, body 1 at negative x, touching (zero overlap) at t = 0: r1 = -(m2/M)(R1 + R2)
e_x, r2 = (m1/M)(R1 + R2) e_x, M = m1 + m2. Relative velocity v1 - v2 = closing_speed (cos angle,
sin angle, 0) [angle in rad], so that angle 0 is head-on and closing_speed is its size, not its
normal part; v1 = (m2/M)(v1 - v2), v2 = -(m1/M)(v1 - v2). `spins` are omega1 then omega2, in space
axes. Moments of inertia 2/5 m R^2.

Law, with overlap d = R1 + R2 - |r1 - r2|: normal force k d + c d'. cutoff zero_overlap: it acts,
also where it is negative, until d = 0; zero_force: max(0, k d + c d'), so that in a head-on
collision, with the frequency w and the decay rate b = c/(2 m) of the overlap, the spheres move
freely from t = 2 atan(w/b)/w on, while they still overlap; `duration` is then the time at which the
force ends. Friction of body i has the lever l_i = R_i (branch R), R_i - d (R-d) or R_i - d/2
(R-d/2) along the normal, for torque and slip alike (branch slip-R: R_i for slip, R_i - d/2 for
torque). The limit of friction is mu max(0, k d + c d').

Proved: head-on collisions without slip in closed form; all others, with stick, slip and release, by
validated integration from event to event, in Cartesian vectors where spins and friction turn the
motion out of its plane (spatial_phases.py). Not certified: a slip or a friction so near a limit
that it is not decided on which side it is; out of the plane a slip that ends, and a spring at its
limit where the normal force vanishes. Scalars: duration and restitution (of the normal velocity;
neither if an overlap never ends), max_overlap, max_force.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property

from flint import arb, arb_mat

from refdem.truth.balls import arb_of
from refdem.truth.collision import Collision, Formula, moved_by_shares
from refdem.truth.contact_motion import ContactMotion
from refdem.truth.contact_phases import ContactPhases, LinearContact
from refdem.truth.events.truth import METHOD
from refdem.truth.head_on_contact import HeadOnContact
from refdem.truth.reals import Number
from refdem.truth.sphere_pair import SpherePair

NAMES = tuple(
    f"{kind}{body}.{axis}" for body in (1, 2) for kind in ("r", "v", "omega") for axis in "xyz"
)
"""The 18 quantities: r1.x r1.y r1.z v1.x .. omega1.z r2.x .. omega2.z."""
IN_PLANE = tuple(f"{kind}{body}.{axis}" for body in (1, 2) for kind in "rv" for axis in "xy")
MOVED = (*IN_PLANE, "omega1.z", "omega2.z")
"""What S displaces, and whose answers it counts."""


WITNESS = "Taylor series in Cartesian coordinates with the switches found anew, energy, momenta"


@dataclass(frozen=True)
class TwoSpheres(Collision):
    """Positions [m], velocities [m/s] and angular velocities [rad/s] of both, NAMES, at t >= 0.

    S(t) is that of the motion in its plane; out of it a head-on collision grows as across the
    normal.
    """

    witness = WITNESS

    spheres: SpherePair
    method: str = field(init=False)

    def __post_init__(self) -> None:
        if self.spheres.is_head_on:
            vars(self)["method"] = "closed form"
        else:
            vars(self)["method"] = METHOD

    @cached_property
    def phases(self) -> LinearContact:
        """The phases of the contact."""
        return ContactPhases(self.spheres)

    @property
    def effective_mass(self) -> Number:
        """The mass [kg] of the relative motion along the normal."""
        return self.spheres.effective_mass

    def formula_at(self, t: Fraction) -> Formula | None:
        if self.spheres.stays_head_on or t == 0:
            return lambda: self.evaluate(arb_of(t))
        return None

    def formula_of_scalars(self) -> Formula | None:
        if self.spheres.is_head_on:
            return lambda: HeadOnContact(self.spheres).constants()
        return None

    def evaluate(self, t: arb) -> dict[str, arb]:
        """The 18 quantities at touch, or of a head-on contact."""
        # omega1.z and omega2.z: spins are (omega1, omega2), three components each.
        spins = [arb_of(self.spheres.spins[axis]) for axis in (2, 5)]
        if t == 0:
            relative = self.spheres.start()
        else:
            relative = HeadOnContact(self.spheres).relative(t)[:4]
        return self.quantities([*relative, *spins])

    def extremes(self, motion: ContactMotion) -> dict[str, arb]:
        return self.contact_extremes(motion)

    def units(self) -> list[Fraction]:
        """The units of x, y, vx, vy and of both spins [m, m/s, 1/s]."""
        # The unit V/R_i of a spin is a surface speed of V.
        spin_units = [self.phases.speed / radius for radius in self.spheres.radii]
        return [self.phases.length] * 2 + [self.phases.speed] * 2 + spin_units

    def quantities(self, relative: Sequence[arb]) -> dict[str, arb]:
        """The 18 quantities from x, y, vx, vy of body 1 against body 2, and the spins about z."""
        x, y, vx, vy, *spins_z = relative
        zero = arb(0)
        values: list[arb] = []
        # The centre of mass is at rest: r1 = (m2/M) r, r2 = -(m1/M) r.
        for body, sign in ((0, 1), (1, -1)):
            share = arb_of(sign * self.spheres.masses[1 - body] / self.spheres.total_mass)
            position = [share * x, share * y, zero]
            velocity = [share * vx, share * vy, zero]
            # Torques are along z: the other components of the spins do not change.
            spin_xy = [arb_of(part) for part in self.spheres.spins[3 * body : 3 * body + 2]]
            values += [*position, *velocity, *spin_xy, spins_z[body]]
        return dict(zip(NAMES, values, strict=True))

    def drifting(self) -> Sequence[int]:
        return range(4)

    def bodies(self) -> arb_mat:
        """The derivative of the coordinates MOVED, and of those that only the mode has, by x, y,
        vx, vy, the spins, the rest, and the centre of mass.
        """
        shares = [arb_of(mass / sum(self.spheres.masses)) for mass in self.spheres.masses]
        return moved_by_shares(shares, self.drifting(), self.phases.size - 1)

    def counted(self) -> Sequence[str]:
        return MOVED
