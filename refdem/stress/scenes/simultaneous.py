"""Many small spheres that hit a large one from all sides at the same instant: by symmetry it stays
at rest.
"""

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
"""Radius of the large sphere [m]."""
SMALL = 0.0625
"""Radius of the small spheres [m], a power of two."""
MASS = 1.0
"""Mass of the large sphere [kg]."""
LIGHT = 0.125
"""Mass of a small sphere [kg]: the large one hardly moves, and every impact is alike."""
STIFFNESS = 128.0
"""Stiffness of the contacts [N/m]: sqrt(LIGHT/STIFFNESS) = 1/32 s exactly."""
SPEED = 1.0
"""Speed of the small spheres towards the centre [m/s]."""


class Simultaneous(Case):
    """`hits` small spheres evenly spaced on a circle, each touching the large one and moving
    towards its centre.
    """

    id = "simultaneous-contacts"
    title = "Simultaneous contacts"
    statement = (
        "Small spheres hit a large one from all sides at once: it stays, and they leave with the"
        " speed that they came with."
    )
    latex = r"d=\frac v\omega\sin\omega t,\quad \omega^2=k/m"
    source = "Matuttis and Chen 2014, chapter 1, section 1.7.4"
    parameters = (
        Parameter(
            name="hits",
            default="2",
            unit="1",
            doc="spheres that come",
            at_least=2,
            at_most=24,
            whole=True,
        ),
    )

    def scene(self, p: Parameters) -> Scene:
        """The large sphere first, then the small ones."""
        count = int(p.hits)
        angle = 2 * np.pi * np.arange(count) / count
        sides = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
        # J = 2/5 m R^2 about every axis.
        inertia = (0.4 * MASS * RADIUS**2,) * 3
        large = Body(mass=MASS, inertia=inertia, shape=Sphere(radius=RADIUS))
        inertia = (0.4 * LIGHT * SMALL**2,) * 3
        shape = Sphere(radius=SMALL)
        small = []
        for normal in sides:
            position = tuple((RADIUS + SMALL) * normal)
            velocity = tuple(-SPEED * normal)
            body = Body(
                mass=LIGHT, inertia=inertia, shape=shape, position=position, velocity=velocity
            )
            small.append(body)
        return Scene.of([large, *small], [Contact(law="linear", stiffness=STIFFNESS)])

    def scales(self, p: Parameters) -> Scales:
        """The greatest overlap or an eighth of the radius; 1/w; two contact times."""
        tau = float(np.sqrt(LIGHT / STIFFNESS))
        return Scales(max(SPEED * tau, RADIUS / 8), tau, 2 * float(np.pi) * tau, LIGHT)

    def quantities(self, p: Parameters) -> tuple[Quantity, ...]:
        """Overlap (negative when apart) and its rate of one pair, and the distance of the large
        sphere from its start.
        """
        s = self.scales(p)
        return (
            Quantity("overlap", "m", s.length),
            Quantity("rate", "m/s", s.speed),
            Quantity("middle", "m", s.length),
        )

    def observe(self, p: Parameters, trajectory: Trajectory) -> dict[str, Array]:
        """Overlap and rate of the pair that deviates most from the mean of all pairs, and how far
        the large sphere moved.
        """
        branch = trajectory.position[:, 1:] - trajectory.position[:, :1]
        distance = np.linalg.norm(branch, axis=2)
        relative = trajectory.velocity[:, 1:] - trajectory.velocity[:, :1]
        rate = np.sum(branch * relative, axis=2) / distance
        middle = np.linalg.norm(trajectory.position[:, 0], axis=1)
        return {
            "overlap": RADIUS + SMALL - _most_deviating(distance),
            "rate": -_most_deviating(rate),
            "middle": middle,
        }

    def truth(self, p: Parameters) -> Truth:
        """Half a period of a sine, then uniform motion; the large sphere stays."""
        from fractions import Fraction

        from refdem.stress.scenes.half_sine import HalfSine
        from refdem.truth.refiner import Refiner

        # Every pair is a contact against a sphere that stays: w^2 = k/m of the small sphere.
        start = (Fraction(0), Fraction(SPEED))
        scale = {q.name: q.scale for q in self.quantities(p)}
        square = Fraction(STIFFNESS) / Fraction(LIGHT)
        return HalfSine(Refiner.of(scale), square, start, int(p.hits) + 1)


def _most_deviating(values: Array) -> Array:
    """The value of each row (T, n) that deviates most from the row's mean (T,)."""
    deviation = np.abs(values - values.mean(axis=1, keepdims=True))
    farthest = deviation.argmax(axis=1)
    result: Array = values[np.arange(len(values)), farthest]
    return result


CASE = Simultaneous()
