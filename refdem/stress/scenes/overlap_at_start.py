"""Two spheres that overlap at the start: the contact's spring pushes them apart."""

import numpy as np
from numpy.typing import NDArray

from refdem.core.case import Case
from refdem.core.parameters import Parameter, Parameters
from refdem.core.quantity import Quantity, Scales
from refdem.core.trajectory import Trajectory
from refdem.core.truth import Truth
from refdem.scene import Body, Scene, Sphere
from refdem.scene.elements.contact import Contact

Array = NDArray[np.float64]
RADIUS = 0.5
"""Radius of both spheres [m]: one diameter is the unit of the overlap."""
MASS = 1.0
"""Mass of both spheres [kg]."""
STIFFNESS = 128.0
"""Stiffness of the contact [N/m], a power of two: tau = 1/16 s exactly."""


class OverlapAtStart(Case):
    """Two spheres start at rest, overlapping by `overlap` on x."""

    id = "overlap-at-start"
    title = "Overlap at the start"
    statement = (
        "Two spheres that overlap at rest part with the speed that the energy of the spring between"
        " them gives."
    )
    latex = r"d=d_0\cos\omega t,\quad \omega^2=2k/m"
    source = "Matuttis and Chen 2014, chapter 1, section 1.7.4"
    parameters = (
        Parameter(
            name="overlap", default="1/64", unit="m", doc="at the start", above=0, at_most=0.9
        ),
    )

    def scene(self, p: Parameters) -> Scene:
        """Two equal solid spheres at rest, centres on x on either side of the origin."""
        x = RADIUS - p.overlap / 2
        # J = 2/5 m R^2 about every axis.
        inertia = (0.4 * MASS * RADIUS**2,) * 3
        shape = Sphere(radius=RADIUS)
        left = Body(mass=MASS, inertia=inertia, shape=shape, position=(-x, 0.0, 0.0))
        right = Body(mass=MASS, inertia=inertia, shape=shape, position=(x, 0.0, 0.0))
        bodies = [left, right]
        return Scene.of(bodies, [Contact(law="linear", stiffness=STIFFNESS)])

    def scales(self, p: Parameters) -> Scales:
        """The radius, as positions near it are rounded in every step; 1/w; the duration is twice
        the quarter period in contact.
        """
        tau = float(np.sqrt(MASS / (2 * STIFFNESS)))
        return Scales(RADIUS, tau, float(np.pi) * tau, MASS)

    def quantities(self, p: Parameters) -> tuple[Quantity, ...]:
        """Overlap, negative once they are apart, and its rate."""
        s = self.scales(p)
        return Quantity("overlap", "m", s.length), Quantity("rate", "m/s", s.speed)

    def observe(self, p: Parameters, trajectory: Trajectory) -> dict[str, Array]:
        """The overlap [m] and its rate [m/s] (T,), from the branch vector between the centres."""
        branch = trajectory.position[:, 1] - trajectory.position[:, 0]
        relative = trajectory.velocity[:, 1] - trajectory.velocity[:, 0]
        distance = np.linalg.norm(branch, axis=1)
        rate = np.sum(branch * relative, axis=1) / distance
        return {"overlap": 2 * RADIUS - distance, "rate": -rate}

    def truth(self, p: Parameters) -> Truth:
        """A quarter of a cosine, then uniform motion."""
        from fractions import Fraction

        from refdem.stress.scenes.half_sine import HalfSine
        from refdem.truth.refiner import Refiner

        overlap = p["overlap"]
        assert isinstance(overlap, Fraction)
        # w^2 = k/m_eff = 2 k/m: the effective mass of two equal spheres is m/2.
        square = Fraction(2 * STIFFNESS) / Fraction(MASS)
        scale = {q.name: q.scale for q in self.quantities(p)}
        return HalfSine(Refiner.of(scale), square, (overlap, Fraction(0)))


CASE = OverlapAtStart()
