"""Many spheres that hit one in the middle at the same instant, from all sides: by symmetry it stays
where it is.
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
SMALL = 0.0625
MASS = 1.0
LIGHT = 0.125
STIFFNESS = 128.0
SPEED = 1.0


class Simultaneous(Case):
    """`hits` small spheres evenly on a circle, each touching the large one."""

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
        """The large sphere first, then the small ones, which touch it and fly at its centre."""
        count = int(p.hits)
        turn = 2 * np.pi * np.arange(count) / count
        sides = np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=1)
        # J = 2/5 m R^2 about every axis.
        inertia = (0.4 * MASS * RADIUS**2,) * 3
        large = Body(mass=MASS, inertia=inertia, shape=Sphere(radius=RADIUS))
        inertia = (0.4 * LIGHT * SMALL**2,) * 3
        shape = Sphere(radius=SMALL)
        small = []
        for normal in sides:
            place = tuple((RADIUS + SMALL) * normal)
            velocity = tuple(-SPEED * normal)
            body = Body(mass=LIGHT, inertia=inertia, shape=shape, position=place, velocity=velocity)
            small.append(body)
        return Scene.of([large, *small], [Contact(law="linear", stiffness=STIFFNESS)])

    def scales(self, p: Parameters) -> Scales:
        """1/w and the deepest overlap; two contacts."""
        tau = float(np.sqrt(LIGHT / STIFFNESS))
        return Scales(max(SPEED * tau, RADIUS / 8), tau, 2 * float(np.pi) * tau, LIGHT)

    def quantities(self, p: Parameters) -> tuple[Quantity, ...]:
        """The deepest overlap (negative when they are apart), the fastest approach, and how far the
        middle one went.
        """
        s = self.scales(p)
        return (
            Quantity("overlap", "m", s.length),
            Quantity("rate", "m/s", s.speed),
            Quantity("middle", "m", s.length),
        )

    def observe(self, p: Parameters, trajectory: Trajectory) -> dict[str, Array]:
        """The quantities of the pair with the middle sphere that is farthest from the mean of the
        others.
        """
        apart = trajectory.position[:, 1:] - trajectory.position[:, :1]
        distance = np.linalg.norm(apart, axis=2)
        relative = trajectory.velocity[:, 1:] - trajectory.velocity[:, :1]
        rate = np.sum(apart * relative, axis=2) / distance
        middle = np.linalg.norm(trajectory.position[:, 0], axis=1)
        return {
            "overlap": RADIUS + SMALL - _oddest(distance),
            "rate": -_oddest(rate),
            "middle": middle,
        }

    def truth(self, p: Parameters) -> Truth:
        """Half a sine, then uniform motion; the middle one stays."""
        from fractions import Fraction

        from refdem.stress.scenes.half_sine import HalfSine

        start = (Fraction(0), Fraction(SPEED))
        scale = {q.name: q.scale for q in self.quantities(p)}
        return HalfSine(Fraction(STIFFNESS) / Fraction(LIGHT), start, scale, bodies=int(p.hits) + 1)


def _oddest(values: Array) -> Array:
    """The value of each row (T, n) that differs most from the row's mean (T,)."""
    away = np.abs(values - values.mean(axis=1, keepdims=True))
    farthest = away.argmax(axis=1)
    found: Array = values[np.arange(len(values)), farthest]
    return found


CASE = Simultaneous()
