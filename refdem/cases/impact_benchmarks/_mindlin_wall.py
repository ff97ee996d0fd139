"""A sphere that touches a rigid wall from the left: under Hertz's law with Mindlin's tangential
stiffness, clipped at Coulomb's limit.
"""

from collections.abc import Mapping

import numpy as np

from refdem.cases.impact_benchmarks._hertz_wall import HertzWall
from refdem.cases.impact_benchmarks._values import Values
from refdem.cases.impact_benchmarks._wall import of_impact, struck
from refdem.core.parameters import Parameters
from refdem.core.quantity import Scales
from refdem.core.truth import Truth
from refdem.errors import UsageError
from refdem.scene import Scene
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane


class MindlinWall(HertzWall):
    """Normal force 4/3 E* sqrt(R d) d, tangential force 8 G* sqrt(R d) s at most mu times it.

    d is the overlap and s the tangential displacement; E* and G* are Hertz's and Mindlin's
    effective moduli.
    """

    def values(self, p: Parameters) -> Values:
        """The parameters with the normal and the tangential stiffness of the material."""
        from refdem.truth.contact_law import hertz_modulus, mindlin_modulus, mindlin_wall_stiffness

        v = super().values(p)
        v.mindlin = mindlin_wall_stiffness(v.modulus, v.poisson, v.radius)
        v.stiffness_ratio = mindlin_modulus(v.modulus, v.poisson) / hertz_modulus(
            v.modulus, v.poisson
        )
        if not v.friction:
            raise UsageError(
                "parameter friction: got 0; expected more than 0: without it no tangential spring"
                " holds anything"
            )
        return v

    def scene(self, v: Values) -> Scene:
        """The sphere and the wall, which touch without overlap."""
        law = Contact(
            law="hertz",
            stiffness=float(v.hertz),
            tangential_stiffness=float(v.mindlin),
            friction=float(v.friction),
            branch="R",
        )
        return Scene.of([struck(v)], [Plane(normal=(-1.0, 0.0, 0.0)), law])

    def scales(self, v: Values) -> Scales:
        """tau = contact duration/pi, by the faster of the two springs; two contact durations.

        The tangential spring acts on the effective mass 2/7 m of a sphere that also rotates, so
        that its rate is sqrt(7/2 k_t/k_n) times the normal one.
        """
        contact_time = self.contact_time(v)
        rate_ratio = float(np.sqrt(3.5 * float(v.stiffness_ratio)))
        tau = contact_time / np.pi / max(1.0, rate_ratio)
        return of_impact(v, tau=tau, contact_time=contact_time)

    def truth(self, v: Values, scale: Mapping[str, float]) -> Truth:
        """The certified motion, in closed form between proven switches."""
        from refdem.truth.closed_forms.impact_benchmarks.hertz_wall import touching_sphere
        from refdem.truth.closed_forms.impact_benchmarks.mindlin_wall import MindlinWallImpact
        from refdem.truth.refiner import Refiner

        numbers = {
            name: getattr(v, name)
            for name in ("mass", "radius", "friction", "normal", "across", "spin")
        }
        strike = touching_sphere(stiffness=v.hertz, **numbers)
        return MindlinWallImpact(Refiner.of(scale), strike, v.stiffness_ratio)
