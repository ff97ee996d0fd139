"""Two spheres squeezed between the floor and a ceiling at `height`."""

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from refdem.cases.impact_benchmarks._dashpot import dashpot_of
from refdem.cases.impact_benchmarks._floor import OnFloor, ball
from refdem.cases.impact_benchmarks._member import POSITIONS_ARE_ROUNDED
from refdem.cases.impact_benchmarks._values import Values
from refdem.core.parameters import Parameters
from refdem.core.quantity import Scales
from refdem.core.truth import Truth
from refdem.errors import UsageError
from refdem.scene import Scene
from refdem.scene.elements.plane import Plane


class Stack(OnFloor):
    """Both spheres start at rest at a quarter and three quarters of the height; all three contacts
    press and stay.
    """

    bodies: ClassVar[int] = 2

    def values(self, p: Parameters) -> Values:
        """The parameters with the mass of the upper sphere, and the dashpot that gives the
        restitution of an impact of the two on each other.
        """
        from refdem.truth.contact_law import sphere_mass

        v = super().values(p)
        v.upper = sphere_mass(v.partner_density, v.radius)
        v.effective = v.mass * v.upper / (v.mass + v.upper)
        v.damping = dashpot_of(v, v.effective)
        if not v.height < 4 * v.radius:
            raise UsageError(
                f"parameter height: got {float(v.height):g} m; expected less than four radii, so"
                " that all contacts press"
            )
        return v

    def scene(self, v: Values) -> Scene:
        """The spheres one above the other, between two planes."""
        bodies = [ball(v, v.mass, v.height / 4), ball(v, v.upper, v.height * 3 / 4)]
        return self.of(v, bodies, Plane(point=(0.0, float(v.height), 0.0), normal=(0.0, -1.0, 0.0)))

    def scales(self, v: Values) -> Scales:
        """L = height/8; tau = sqrt(m/(3 k)) of the lighter sphere, T = 40 tau, some six periods.

        The fastest mode of two equal spheres moves them against each other: each is pushed back by
        k x of its wall and 2 k x of the other sphere, so that omega^2 = 3 k/m. With unequal masses
        the fastest mode is slower than that of two spheres of the lighter mass.
        """
        lighter = min(float(v.mass), float(v.upper))
        tau = float(np.sqrt(lighter / float(v.stiffness) / 3))
        return Scales(
            length=float(v.height) / POSITIONS_ARE_ROUNDED,
            tau=tau,
            duration=40 * tau,
            mass=float(v.effective),
        )

    def truth(self, v: Values, scale: Mapping[str, float]) -> Truth:
        """The truth as the solution of a linear system."""
        from refdem.truth.closed_forms.impact_benchmarks import floor

        return floor.stack(
            scale,
            self.floor(v),
            upper_mass=v.upper,
            ceiling=v.height,
            starts=(v.height / 4, v.height * 3 / 4),
        )
