"""Two spheres, alike or not, that touch and spin about z while they close head-on, under the linear
law.
"""

from collections.abc import Mapping
from fractions import Fraction
from typing import ClassVar

import numpy as np

from refdem.cases.impact_benchmarks._dashpot import dashpot_of, linear_contact_time
from refdem.cases.impact_benchmarks._member import POSITIONS_ARE_ROUNDED, Member
from refdem.cases.impact_benchmarks._pair import touching
from refdem.cases.impact_benchmarks._parameters import LEVERS
from refdem.cases.impact_benchmarks._values import Values
from refdem.cases.impact_benchmarks._wall import linear
from refdem.core.parameters import Parameters
from refdem.core.quantity import Scales
from refdem.core.truth import Truth
from refdem.scene import Scene


class SpinningPair(Member):
    """`partner_radius`, `partner_density` and `partner_spin` are the second sphere's."""

    bodies: ClassVar[int] = 2

    def values(self, p: Parameters) -> Values:
        """The parameters with masses, radii and spins of both spheres, the effective mass, and the
        dashpot that makes the restitution.
        """
        from refdem.truth.contact_law import sphere_mass

        v = super().values(p)
        v.masses = (v.mass, sphere_mass(v.partner_density, v.partner_radius))
        v.radii = (v.radius, v.partner_radius)
        v.spins = (v.spin, v.partner_spin)
        v.effective = v.masses[0] * v.masses[1] / sum(v.masses)
        v.damping = dashpot_of(v, v.effective)
        return v

    def scene(self, v: Values) -> Scene:
        """The two spheres, which touch, with their centres on x."""
        return Scene.of(touching(v), [linear(v)])

    def scales(self, v: Values) -> Scales:
        """tau = 1/omega_max; L the way in tau, at least R/8; two contact durations.

        omega_max^2 = max(k_n, 7/2 k_t)/m: of solid spheres that stick and rotate, 2/7 of the
        effective mass m resists the tangential spring.
        """
        mass = float(v.effective)
        contact_time = linear_contact_time(v, v.effective)
        stiffest = max(float(v.stiffness), 3.5 * float(v.tangential_stiffness))
        tau = float(np.sqrt(mass / stiffest))
        fastest_rim = max(abs(r * spin) for r, spin in zip(v.radii, v.spins, strict=True))
        speed = float(v.speed + fastest_rim)
        length = max(speed * tau, float(max(v.radii)) / POSITIONS_ARE_ROUNDED)
        return Scales(length=length, tau=tau, duration=2 * contact_time, mass=mass)

    def truth(self, v: Values, scale: Mapping[str, float]) -> Truth:
        """The truth of the collision of two spheres."""
        from refdem.truth.closed_forms.two_spheres import TwoSpheres
        from refdem.truth.refiner import Refiner
        from refdem.truth.sphere_pair import SpherePair

        nothing = Fraction(0)
        names = ("masses", "radii", "stiffness", "damping", "tangential_stiffness", "friction")
        numbers = {name: getattr(v, name) for name in names}
        pair = SpherePair(
            **numbers,
            closing_speed=v.speed,
            angle=nothing,
            spins=(nothing, nothing, v.spins[0], nothing, nothing, v.spins[1]),
            lever=LEVERS[v.branch],
            ends_with_overlap=v.cutoff == "zero_overlap",
        )
        return TwoSpheres(Refiner.of(scale), pair)
