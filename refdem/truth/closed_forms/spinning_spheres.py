"""Two spheres with friction and spins that turn their motion out of its plane, under the law of two_spheres.py, in Cartesian vectors."""

from collections.abc import Mapping, Sequence
from fractions import Fraction

import numpy as np
from flint import arb

from refdem.truth.balls import arb_of
from refdem.truth.closed_forms.two_spheres import NAMES, Array, TwoSpheres
from refdem.truth.spatial_phases import SpatialPhases
from refdem.truth.sphere_pair import SpherePair


class SpinningSpheres(TwoSpheres):
    """The 18 quantities and scalars of two spheres; S displaces all 18."""

    def __init__(self, scale: Mapping[str, float], pair: SpherePair, *, digits: int = 40) -> None:
        super().__init__(scale, pair, digits=digits)
        self.phases = SpatialPhases(pair)

    def evaluate(self, t: arb) -> dict[str, arb]:
        """The 18 quantities at touch."""
        x, y, vx, vy = self.spheres.start()
        return self.quantities([x, y, arb(0), vx, vy, arb(0), *map(arb_of, self.spheres.spins)])

    def units(self) -> list[Fraction]:
        """Of r, v, o1, o2 [m, m/s, 1/s]."""
        phases, radii = self.phases, self.spheres.radii
        return [unit for unit in (phases.length, phases.speed, *(phases.speed / radius for radius in radii)) for _ in range(3)]

    def quantities(self, relative: Sequence[arb]) -> dict[str, arb]:
        """The 18 quantities from r and v of body 1 against body 2, and both spins."""
        shares = [arb_of((1 - 2 * body) * self.spheres.masses[1 - body] / sum(self.spheres.masses)) for body in (0, 1)]
        bodies = [[share * value for value in relative[:6]] + list(relative[6 + 3 * i : 9 + 3 * i]) for i, share in enumerate(shares)]
        return dict(zip(NAMES, bodies[0] + bodies[1], strict=True))

    def growth(self, whole: Array, elapsed: Fraction) -> float:
        """Largest sum, over all 18 coordinates, of the scaled answers of one; the centre of mass moves uniformly."""
        units = np.array([float(unit) for unit in self.units()])
        slopes = whole[:12, :12] * units[:, None] / units
        shares = np.array([float(mass) for mass in self.spheres.masses]) / float(sum(self.spheres.masses))
        own, spun, none = np.eye(6), np.eye(3), np.zeros((6, 3))
        drift = np.eye(6) + float(elapsed) * np.eye(6, k=3)
        apart = np.block([[own, none, -own, none], [none.T, spun, none.T, 0 * spun], [none.T, 0 * spun, none.T, spun]])
        centre = np.hstack([shares[0] * drift, none, shares[1] * drift, none])
        moved = slopes @ apart
        answers = np.vstack([centre + shares[1] * moved[:6], moved[6:9], centre - shares[0] * moved[:6], moved[9:]])
        sizes = np.array([float(self.scale[name]) for name in NAMES])
        return max(1.0, float(np.max(np.abs(answers) @ sizes / sizes))) * (1 + 2.0**-40)
