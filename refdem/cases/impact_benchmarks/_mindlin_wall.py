"""A sphere that touches a rigid wall from the left: under Hertz's law with Mindlin's tangential
stiffness, clipped at Coulomb's limit.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from refdem.cases.impact_benchmarks._hertz_wall import HERTZ_CONTACT, HertzWall
from refdem.cases.impact_benchmarks._wall import of_impact, struck
from refdem.core.quantity import Scales
from refdem.core.truth import Truth
from refdem.errors import UsageError
from refdem.scene import Scene
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane


class MindlinWall(HertzWall):
    """8 G* sqrt(R d) s across, against 4/3 E* sqrt(R d) d along."""

    def values(self, p: Any) -> Any:
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

    def scene(self, v: Any) -> Scene:
        """The sphere and the wall, which touch without overlap."""
        along = float(v.hertz)
        across = float(v.mindlin)
        law = Contact(
            law="hertz",
            stiffness=along,
            tangential_stiffness=across,
            friction=float(v.friction),
            branch="R",
        )
        return Scene.of([struck(v)], [Plane(normal=(-1.0, 0.0, 0.0)), law])

    def scales(self, v: Any) -> Scales:
        """tau by the faster of the two springs; two contacts."""
        depth = (1.25 * float(v.mass * v.normal**2 / v.hertz)) ** 0.4
        lasts = HERTZ_CONTACT * depth / float(v.normal)
        return of_impact(
            v,
            tau=lasts / np.pi / max(1.0, float(np.sqrt(3.5 * float(v.stiffness_ratio)))),
            lasts=lasts,
        )

    def truth(self, v: Any, scale: Mapping[str, float]) -> Truth:
        """The certified motion, in closed form between proven switches."""
        from refdem.truth.closed_forms.impact_benchmarks.mindlin_wall import MindlinWallImpact

        numbers = {
            name: getattr(v, name)
            for name in ("mass", "radius", "friction", "normal", "across", "spin")
        }
        return MindlinWallImpact(
            scale, stiffness=v.hertz, stiffness_ratio=v.stiffness_ratio, **numbers
        )
