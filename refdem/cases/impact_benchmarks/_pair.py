"""Two equal spheres that touch and close head-on, under Hertz's law."""

from collections.abc import Mapping
from fractions import Fraction

import numpy as np

from refdem.cases.impact_benchmarks._hertz_wall import HERTZ_CONTACT
from refdem.cases.impact_benchmarks._member import POSITIONS_ARE_ROUNDED, Array, Member
from refdem.cases.impact_benchmarks._values import Values
from refdem.core.parameters import Parameters
from refdem.core.quantity import Quantity, Scales
from refdem.core.trajectory import Trajectory
from refdem.core.truth import Truth
from refdem.scene import Body, Scene, Sphere
from refdem.scene.elements.contact import Contact


class HertzPair(Member):
    """Two equal ones, head-on, centre of mass at rest; overlap and its rate."""

    def values(self, p: Parameters) -> Values:
        """The parameters with the effective mass and Hertz's stiffness."""
        from refdem.truth.contact_law import hertz_pair_stiffness

        v = super().values(p)
        v.effective = v.mass / 2
        v.hertz = hertz_pair_stiffness(v.modulus, v.poisson, v.radius)
        v.masses = (v.mass, v.mass)
        v.radii = (v.radius, v.radius)
        v.spins = (Fraction(0), Fraction(0))
        return v

    def scene(self, v: Values) -> Scene:
        """The two spheres, which touch, with their centres on x."""
        return Scene.of(touching(v), [Contact(law="hertz", stiffness=float(v.hertz))])

    def scales(self, v: Values) -> Scales:
        """L is the greatest overlap, at least R/8; tau = contact duration/pi; two contacts.

        The greatest overlap is d = (5 m v^2/(4 k))^(2/5), from m v^2/2 = 2/5 k d^(5/2).
        """
        depth = (1.25 * float(v.effective * v.speed**2 / v.hertz)) ** 0.4
        contact_time = HERTZ_CONTACT * depth / float(v.speed)
        length = max(depth, float(v.radius) / POSITIONS_ARE_ROUNDED)
        return Scales(
            length=length,
            tau=contact_time / np.pi,
            duration=2 * contact_time,
            mass=float(v.effective),
        )

    def quantities(self, v: Values) -> tuple[Quantity, ...]:
        """The quantities that are judged: overlap [m] and its rate [m/s]."""
        scales = self.scales(v)
        return (Quantity("overlap", "m", scales.length), Quantity("v", "m/s", scales.speed))

    def observe(self, v: Values, run: Trajectory) -> dict[str, Array]:
        """The overlap [m] and its rate [m/s] at the samples, each (T,)."""
        x = run.position[:, :, 0]
        u = run.velocity[:, :, 0]
        distance = np.abs(x[:, 1] - x[:, 0])
        return {"overlap": 2 * float(v.radius) - distance, "v": u[:, 0] - u[:, 1]}

    def truth(self, v: Values, scale: Mapping[str, float]) -> Truth:
        """The closed-form truth of the member."""
        from refdem.truth.closed_forms.hertz_spheres import HertzSpheres
        from refdem.truth.refiner import Refiner

        begin = (Fraction(0), v.speed)
        return HertzSpheres(Refiner.of(scale), v.effective, v.hertz, begin)


def touching(v: Values) -> list[Body]:
    """Two spheres that touch: 1 at x < 0, 2 at x > 0, their centre of mass at rest at the origin.

    Their `masses`, `radii` and `spins` (about z) are pairs in `v`; they close at `v.speed`.
    """
    total = sum(v.masses)
    distance = sum(v.radii)
    columns = zip(v.masses, v.masses[::-1], v.radii, v.spins, (1, -1), strict=True)
    bodies = []
    for mass, other_mass, radius, spin, sign in columns:
        # Of the distance of the centres, and of the closing speed, sphere 1 has the part
        # m2/(m1 + m2) and sphere 2 the part m1/(m1 + m2).
        place = float(-sign * other_mass / total * distance)
        speed = float(sign * other_mass / total * v.speed)
        # J = 2/5 m R^2.
        moment = 0.4 * float(mass * radius * radius)
        body = Body(
            mass=float(mass),
            inertia=(moment, moment, moment),
            shape=Sphere(radius=float(radius)),
            omega=(0.0, 0.0, float(spin)),
            position=(place, 0.0, 0.0),
            velocity=(speed, 0.0, 0.0),
        )
        bodies.append(body)
    return bodies
