"""Two elastic spheres meet head-on under Hertz's law, F = k d^(3/2)."""

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
CONTACT = 2.94327518
"""Duration in units of greatest overlap/closing speed: (4/5) B(2/5, 1/2)."""


def depth(p: Parameters) -> float:
    """The greatest overlap (5 m v^2/(4 k))^(2/5) [m], where m v^2/2 = 2/5 k d^(5/2)."""
    return float((1.25 * p.effective_mass * p.closing_speed**2 / p.stiffness) ** 0.4)


def radius(p: Parameters) -> float:
    """The radius [m] of both spheres: a power of two, two to four times the greatest overlap.

    Positions at the start are then exact, and the centres stay apart.
    """
    return float(2.0 ** np.ceil(np.log2(2 * depth(p))))


class HertzSpheres(Case):
    """Two equal spheres of twice the effective mass on x, touching without overlap at the start,
    centre of mass at rest.
    """

    id = "hertz-spheres"
    title = "Hertzian spheres"
    words = ("contact", "mindlin", "elastic", "dem", "collision")
    motion = "colliding"
    statement = (
        "Two elastic spheres press each other with the power 3/2 of their overlap. The faster they"
        " meet the shorter they touch, as the fifth root of the speed; all energy comes back."
        " overlap is negative while they are apart, v is its rate."
    )
    latex = (
        r"F=k\,d^{3/2},\quad d_\text{max}=\left(\frac{5mv^2}{4k}\right)^{2/5},\quad"
        r"t_c=\tfrac45\,\mathrm B\!\left(\tfrac25,\tfrac12\right)\frac{d_\text{max}}{v}\propto"
        r" v^{-1/5}"
    )
    source = (
        "Matuttis and Chen 2014, chapter 1, section 1.7.4; Hertz 1882; Landau and Lifshitz, Theory"
        " of Elasticity, section 9"
    )
    parameters = (
        Parameter(name="effective_mass", default="1/2", unit="kg", doc="m1 m2/(m1 + m2)", above=0),
        Parameter(
            name="stiffness", default="1000", unit="N/m^(3/2)", doc="k in F = k d^(3/2)", above=0
        ),
        Parameter(
            name="closing_speed", default="1", unit="m/s", doc="relative velocity at touch", above=0
        ),
    )

    def scene(self, p: Parameters) -> Scene:
        """The scene at touch: sphere 1 at x < 0, sphere 2 at x > 0."""
        r = radius(p)
        mass = 2 * p.effective_mass
        # J = 2/5 m R^2.
        moment = 0.4 * mass * r * r
        bodies = []
        for side in (1.0, -1.0):
            body = Body(
                mass=mass,
                inertia=(moment, moment, moment),
                shape=Sphere(radius=r),
                position=(-side * r, 0.0, 0.0),
                velocity=(side * p.closing_speed / 2, 0.0, 0.0),
            )
            bodies.append(body)
        return Scene.of(bodies, [Contact(law="hertz", stiffness=p.stiffness)])

    def scales(self, p: Parameters) -> Scales:
        """L is the greatest overlap, tau = contact duration/pi; it lasts two contact durations."""
        contact_time = CONTACT * depth(p) / p.closing_speed
        return Scales(
            length=depth(p),
            tau=contact_time / np.pi,
            duration=2 * contact_time,
            mass=p.effective_mass,
        )

    def quantities(self, p: Parameters) -> tuple[Quantity, ...]:
        """The quantities that are judged: overlap [m] and its rate [m/s]."""
        scales = self.scales(p)
        return (Quantity("overlap", "m", scales.length), Quantity("v", "m/s", scales.speed))

    def observe(self, p: Parameters, trajectory: Trajectory) -> dict[str, Array]:
        """The overlap [m] and its rate [m/s] at the samples, each (T,)."""
        x = trajectory.position[:, :, 0]
        v = trajectory.velocity[:, :, 0]
        distance = np.abs(x[:, 1] - x[:, 0])
        return {"overlap": 2 * radius(p) - distance, "v": v[:, 0] - v[:, 1]}

    def truth(self, p: Parameters) -> Truth:
        """The incomplete beta function, solved for overlap and velocity."""
        from refdem.truth.closed_forms.hertz_spheres import truth

        return truth(p, {q.name: q.scale for q in self.quantities(p)})


CASE = HertzSpheres()
