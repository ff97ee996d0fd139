"""Two equal spheres that squeeze a smaller one between them, under the linear law, turned into
themselves by half a turn about z.

The middle one stays where it is and only turns, so that each of the others meets a sphere that
cannot be moved and has, for its torque alone, half of the middle one's moment of inertia: J w' = 2
torque. What follows is a pair (contact_phases) whose effective mass is that of the outer sphere.
The outer two never touch each other as long as the middle one is not crushed.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

from flint import arb, arb_mat

from refdem.truth.balls import unit_matrix
from refdem.truth.collision import Collision
from refdem.truth.contact_motion import ContactMotion
from refdem.truth.contact_phases import ContactPhases, LinearContact
from refdem.truth.events.truth import METHOD
from refdem.truth.reals import Number
from refdem.truth.sphere_pair import TouchingPair

NAMES = tuple(
    f"{kind}{body}.{axis}" for body in (1, 2, 3) for kind in ("r", "v", "omega") for axis in "xyz"
)
"""Body 1 is the outer one at negative x, body 2 the middle one, body 3 the other."""
MOVED = ("r1.x", "r1.y", "v1.x", "v1.y", "omega1.z", "omega2.z")


@dataclass(frozen=True, kw_only=True)
class Squeezed(TouchingPair):
    """An outer sphere of `masses[0]` against the middle one; masses[1] is half of the mass of the
    middle one, and enters its torque.
    """

    @property
    def effective_mass(self) -> Number:
        """The effective mass [kg]: that of the outer sphere."""
        return self.masses[0]

    @property
    def is_head_on(self) -> bool:
        """Never taken for it: nothing is lost by integrating."""
        return False


@dataclass(frozen=True)
class ThreeSpheres(Collision):
    """Positions [m], velocities [m/s] and angular velocities [rad/s] of the three, NAMES, at t >=
    0, from touch.
    """

    method = METHOD
    witness = "Taylor series of the three bodies, each with its own equation; momenta"

    spheres: Squeezed

    @cached_property
    def phases(self) -> LinearContact:
        """The phases of the contact."""
        return ContactPhases(self.spheres)

    @property
    def effective_mass(self) -> Number:
        """The mass [kg] of the relative motion along the normal."""
        return self.spheres.effective_mass

    def formula_at(self, t: Fraction) -> None:
        """None: the motion is followed."""

    def formula_of_scalars(self) -> None:
        """None: the motion is followed."""

    def extremes(self, motion: ContactMotion) -> dict[str, arb]:
        return self.contact_extremes(motion)

    def units(self) -> list[Fraction]:
        """The units of x, y, vx, vy, o1, o2 [m, m/s, 1/s]."""
        turns = [self.phases.speed / radius for radius in self.spheres.radii]
        return [self.phases.length] * 2 + [self.phases.speed] * 2 + turns

    def quantities(self, relative: Sequence[arb]) -> dict[str, arb]:
        """The 27 quantities from x, y, vx, vy of body 1 and the spins about z of it and the middle
        one.
        """
        x, y, vx, vy, outer, middle = relative[:6]
        o = arb(0)
        first = [x, y, o, vx, vy, o, o, o, outer]
        second = [o, o, o, o, o, o, o, o, middle]
        third = [-x, -y, o, -vx, -vy, o, o, o, outer]
        values = [*first, *second, *third]
        return dict(zip(NAMES, values, strict=True))

    def drifting(self) -> Sequence[int]:
        """None: the middle sphere stays, and mirror images stay mirror images."""
        return ()

    def bodies(self) -> arb_mat:
        """The coordinates of an outer sphere and the two spins are those of the mode."""
        return unit_matrix(self.phases.size - 1)

    def counted(self) -> Sequence[str]:
        return MOVED
