"""A sphere that touches a rigid wall, the plane x = 0, from the left: under Hertz's law, F = k
d^(3/2) with k = `hertz`, and Coulomb friction.
"""

from collections.abc import Mapping

import numpy as np

from refdem.cases.impact_benchmarks._values import Values
from refdem.cases.impact_benchmarks._wall import Wall, of_impact, struck
from refdem.core.parameters import Parameters
from refdem.core.quantity import Scales
from refdem.core.truth import Truth
from refdem.scene import Scene
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane

HERTZ_CONTACT = 2.94327518
"""Duration of a Hertzian contact in units of greatest overlap/closing speed: (4/5) B(2/5, 1/2)."""


class HertzWall(Wall):
    """Hertz's law, and friction of full size whenever there is slip."""

    def values(self, p: Parameters) -> Values:
        """The parameters with the contact stiffness of the material."""
        from refdem.truth.contact_law import hertz_wall_stiffness

        v = super().values(p)
        v.hertz = hertz_wall_stiffness(v.modulus, v.poisson, v.radius)
        return v

    def scene(self, v: Values) -> Scene:
        """The sphere and the wall, which touch without overlap."""
        law = Contact(law="hertz", stiffness=float(v.hertz), friction=float(v.friction), branch="R")
        return Scene.of([struck(v)], [Plane(normal=(-1.0, 0.0, 0.0)), law])

    def scales(self, v: Values) -> Scales:
        """tau = contact duration/pi; it lasts two contact durations."""
        contact_time = self.contact_time(v)
        return of_impact(v, tau=contact_time / np.pi, contact_time=contact_time)

    def contact_time(self, v: Values) -> float:
        """Duration [s] of the contact at the normal speed v_n: (4/5) B(2/5, 1/2) d/v_n.

        The greatest overlap d = (5 m v_n^2/(4 k))^(2/5) follows from m v_n^2/2 = 2/5 k d^(5/2).
        """
        depth = (1.25 * float(v.mass * v.normal**2 / v.hertz)) ** 0.4
        return float(HERTZ_CONTACT * depth / float(v.normal))

    def truth(self, v: Values, scale: Mapping[str, float]) -> Truth:
        """The closed-form truth of the member."""
        from refdem.truth.closed_forms.impact_benchmarks.hertz_wall import (
            HertzWallImpact,
            touching_sphere,
        )
        from refdem.truth.refiner import Refiner

        numbers = {
            name: getattr(v, name)
            for name in ("mass", "radius", "friction", "normal", "across", "spin")
        }
        strike = touching_sphere(stiffness=v.hertz, **numbers)
        return HertzWallImpact(Refiner.of(scale), strike)
