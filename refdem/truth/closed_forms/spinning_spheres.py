"""Two spheres with friction and spins that turn their motion out of its plane, under the law of
two_spheres.py, in Cartesian vectors.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

from flint import arb, arb_mat

from refdem.core.parameters import Parameters
from refdem.core.truth import Truth
from refdem.truth.balls import arb_of
from refdem.truth.closed_forms.two_spheres import NAMES, WITNESS, TwoSpheres
from refdem.truth.collision import Collision, Formula, moved_by_shares
from refdem.truth.contact_motion import ContactMotion
from refdem.truth.contact_phases import LinearContact
from refdem.truth.events.truth import METHOD
from refdem.truth.reals import Number
from refdem.truth.refiner import Refiner
from refdem.truth.spatial_phases import SpatialPhases
from refdem.truth.sphere_pair import SpherePair, sphere_pair

DISPLACED = tuple(
    f"{kind}{body}.{axis}" for body in (1, 2) for kind in "rv" for axis in "xyz"
) + tuple(f"omega{body}.{axis}" for body in (1, 2) for axis in "xyz")
"""NAMES with the spins last."""


@dataclass(frozen=True)
class SpinningSpheres(Collision):
    """The 18 quantities and scalars of two spheres; S displaces all 18."""

    method = METHOD
    witness = WITNESS

    spheres: SpherePair

    @cached_property
    def phases(self) -> LinearContact:
        """The phases of the contact."""
        return SpatialPhases(self.spheres)

    @property
    def effective_mass(self) -> Number:
        """The mass [kg] of the relative motion along the normal."""
        return self.spheres.effective_mass

    def formula_at(self, t: Fraction) -> Formula | None:
        if t == 0:
            return self.at_touch
        return None

    def formula_of_scalars(self) -> None:
        """None: the motion is followed."""

    def extremes(self, motion: ContactMotion) -> dict[str, arb]:
        return self.contact_extremes(motion)

    def at_touch(self) -> dict[str, arb]:
        """The 18 quantities at touch."""
        # The centres and the relative velocity at t = 0 are in the plane z = 0.
        x, y, vx, vy = self.spheres.start()
        return self.quantities([x, y, arb(0), vx, vy, arb(0), *map(arb_of, self.spheres.spins)])

    def units(self) -> list[Fraction]:
        """The units of r, v, o1, o2 [m, m/s, 1/s]."""
        length = self.phases.length
        speed = self.phases.speed
        # The unit V/R_i of a spin is a surface speed of V.
        turns = [speed / radius for radius in self.spheres.radii]
        return [unit for unit in (length, speed, *turns) for _ in range(3)]

    def quantities(self, relative: Sequence[arb]) -> dict[str, arb]:
        """The 18 quantities from r and v of body 1 against body 2, and both spins."""
        values: list[arb] = []
        # The centre of mass rests: r1 = (m2/M) r, r2 = -(m1/M) r, and the same for v.
        for body, sign in ((0, 1), (1, -1)):
            share = arb_of(sign * self.spheres.masses[1 - body] / self.spheres.total_mass)
            values += [share * value for value in relative[:6]]
            values += relative[6 + 3 * body : 9 + 3 * body]
        return dict(zip(NAMES, values, strict=True))

    def drifting(self) -> Sequence[int]:
        return range(6)

    def bodies(self) -> arb_mat:
        """The Jacobian of the coordinates DISPLACED, and of further ones of the mode, by r, v, the
        spins, those further coordinates, and the centre of mass.
        """
        shares = [arb_of(mass / sum(self.spheres.masses)) for mass in self.spheres.masses]
        return moved_by_shares(shares, self.drifting(), self.phases.size - 1)

    def counted(self) -> Sequence[str]:
        return DISPLACED


def truth(p: Parameters, scale: Mapping[str, float]) -> Truth:
    """The truth of case two-spheres, in its plane or in space.

    `scale` of the 18 quantities NAMES.
    """
    pair = sphere_pair(p)
    if pair.leaves_plane:
        return SpinningSpheres(Refiner.of(scale), pair)
    return TwoSpheres(Refiner.of(scale), pair)
