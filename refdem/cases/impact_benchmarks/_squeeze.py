"""A small sphere that spins between two large ones that close on it from both sides, under the
linear law.
"""

from collections.abc import Mapping
from fractions import Fraction
from typing import ClassVar

import numpy as np

from refdem.cases.impact_benchmarks._dashpot import dashpot_of, linear_contact_time
from refdem.cases.impact_benchmarks._member import POSITIONS_ARE_ROUNDED, Member
from refdem.cases.impact_benchmarks._parameters import LEVERS
from refdem.cases.impact_benchmarks._values import Values
from refdem.cases.impact_benchmarks._wall import linear
from refdem.core.parameters import Parameters
from refdem.core.quantity import Scales
from refdem.core.truth import Truth
from refdem.scene import Body, Scene, Sphere


class Squeeze(Member):
    """`partner_radius` and `partner_spin` are the large ones'.

    `speed` and `angle` those of each against the small one.
    """

    bodies: ClassVar[int] = 3

    def values(self, p: Parameters) -> Values:
        """The parameters with the mass of the large spheres, and the dashpot that makes the
        restitution of each against the small one, which stays.
        """
        from refdem.truth.contact_law import sphere_mass
        from refdem.truth.reals import cosine, sine

        v = super().values(p)
        v.large = sphere_mass(v.density, v.partner_radius)
        v.damping = dashpot_of(v, v.large)
        v.normal = v.speed * cosine(v.angle)
        v.across = v.speed * sine(v.angle)
        return v

    def scene(self, v: Values) -> Scene:
        """The three spheres touch, with centres on x and the small one at the origin.

        The scene is symmetric: half a turn about z leaves it as it is.
        """
        distance = float(v.radius + v.partner_radius)
        r = float(v.partner_radius)
        # J = 2/5 m R^2.
        moment = 0.4 * float(v.large) * r * r

        def large(side: int) -> Body:
            """The large sphere at x < 0 for side 1, at x > 0 for side -1."""
            velocity = (side * float(v.normal), side * float(v.across), 0.0)
            return Body(
                mass=float(v.large),
                inertia=(moment, moment, moment),
                shape=Sphere(radius=r),
                position=(-side * distance, 0.0, 0.0),
                velocity=velocity,
                omega=(0.0, 0.0, float(v.partner_spin)),
            )

        small_mass = float(v.mass)
        small_radius = float(v.radius)
        small_moment = 0.4 * small_mass * small_radius * small_radius
        middle = Body(
            mass=small_mass,
            inertia=(small_moment, small_moment, small_moment),
            shape=Sphere(radius=small_radius),
            omega=(0.0, 0.0, float(v.spin)),
        )
        return Scene.of([large(1), middle, large(-1)], [linear(v)])

    def scales(self, v: Values) -> Scales:
        """tau = 1/omega_max; L the way in tau, at least R/8; two contact durations.

        omega_max^2 = max(k_n, k_t (7/2 + 5 M/m))/M for the masses M of a large and m of the small
        sphere: both tangential springs turn the small one, whose 2/5 m resists them.
        """
        mass = float(v.large)
        contact_time = linear_contact_time(v, v.large)
        tangential = float(v.tangential_stiffness * (Fraction(7, 2) + 5 * v.large / v.mass))
        tau = float(np.sqrt(mass / max(float(v.stiffness), tangential)))
        fastest_rim = max(abs(v.radius * v.spin), abs(v.partner_radius * v.partner_spin))
        speed = float(v.speed + fastest_rim)
        length = max(speed * tau, float(v.partner_radius) / POSITIONS_ARE_ROUNDED)
        return Scales(length=length, tau=tau, duration=2 * contact_time, mass=mass)

    def truth(self, v: Values, scale: Mapping[str, float]) -> Truth:
        """The truth of a pair, to which symmetry reduces the three spheres."""
        from refdem.truth.closed_forms.impact_benchmarks.three_spheres import Squeezed, ThreeSpheres
        from refdem.truth.refiner import Refiner

        nothing = Fraction(0)
        names = (
            "stiffness",
            "damping",
            "tangential_stiffness",
            "friction",
            "angle",
        )
        numbers = {name: getattr(v, name) for name in names}
        # By symmetry each large sphere meets half of the small one's mass.
        pair = Squeezed(
            **numbers,
            closing_speed=v.speed,
            lever=LEVERS[v.branch],
            masses=(v.large, v.mass / 2),
            radii=(v.partner_radius, v.radius),
            spins=(nothing, nothing, v.partner_spin, nothing, nothing, v.spin),
            ends_with_overlap=v.cutoff == "zero_overlap",
        )
        return ThreeSpheres(Refiner.of(scale), pair)
