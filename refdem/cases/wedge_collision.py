"""A wedge meets a wall edge first, turns, and leaves flat side first: energy is lost without
friction (fig. 1.38).
"""

import numpy as np
from numpy.typing import NDArray

from refdem.core.case import Case
from refdem.core.parameters import Parameter, Parameters
from refdem.core.quantity import Quantity, Scales
from refdem.core.trajectory import Trajectory
from refdem.core.truth import Truth
from refdem.scene import Body, Scene
from refdem.scene.elements.wedge import Wedge

Array = NDArray[np.float64]
APPROACH = 1.40218211
"""Time from touch to the turn in units of greatest overlap/closing speed: B(1/3, 1/2)/3."""


def depth(p: Parameters) -> float:
    """The greatest overlap d_m = (3 E/k2)^(1/3) [m], where E = m v^2/2 = k2 d_m^3/3."""
    return float((1.5 * p.mass * p.closing_speed**2 / p.k2) ** (1 / 3))


class WedgeCollision(Case):
    """A particle that touches the wall at x = 0 at the start, moving along +x, edge first."""

    id = "wedge-collision"
    title = "Collision of a wedge"
    words = ("polyhedron", "corner", "edge", "shape")
    motion = "colliding"
    statement = (
        "Edge first a wedge is pressed back with the square of its overlap, flat side first in"
        " proportion to it; at greatest overlap it turns. The forces depend on place and"
        " orientation alone, yet energy is lost, or gained; run back, it comes back to the last"
        " bit."
    )
    latex = (
        r"F_\text{in}=k_2d^2,\ F_\text{out}=k_1d,\quad d_m=\left(\frac{3E}{k_2}\right)^{1/3},\quad"
        r" E'=\tfrac12k_1d_m^2,\quad"
        r"E'<E\Leftrightarrow k_1<\tfrac23k_2d_m"
    )
    source = "Matuttis and Chen 2014, chapter 1, section 1.7.4, fig. 1.38"
    parameters = (
        Parameter(name="mass", default="1", unit="kg", doc="the wedge", above=0),
        Parameter(name="k1", default="2", unit="N/m", doc="flat side first: F = k1 d", above=0),
        Parameter(name="k2", default="12", unit="N/m^2", doc="edge first: F = k2 d^2", above=0),
        Parameter(name="closing_speed", default="1", unit="m/s", doc="velocity at touch", above=0),
    )

    def scene(self, p: Parameters) -> Scene:
        """The wedge at the wall; its edge, its y axis, points along +x, and only the contact law
        rotates it.
        """
        # Any moment of inertia will do: no torque acts, the law itself turns the wedge.
        moment = p.mass * depth(p) ** 2
        # A turn by -90 degrees about z takes the body's y axis, the edge, to +x.
        edge_first = (np.sqrt(0.5), 0.0, 0.0, -np.sqrt(0.5))
        wedge = Body(
            mass=p.mass,
            inertia=(moment, moment, moment),
            velocity=(p.closing_speed, 0.0, 0.0),
            attitude=edge_first,
        )
        return Scene.of([wedge], [Wedge(quadratic=p.k2, stiffness=p.k1)])

    def scales(self, p: Parameters) -> Scales:
        """L is the greatest overlap; tau the shorter of approach and separation.

        It lasts the approach, the separation (a quarter of a period, pi/2 sqrt(m/k1)), and the
        flight out to three overlaps.
        """
        approach_time = APPROACH * depth(p) / p.closing_speed
        oscillation = float(np.sqrt(p.mass / p.k1))
        tau = min(2 * approach_time / np.pi, oscillation)
        duration = approach_time + (np.pi / 2 + 3) * oscillation
        return Scales(length=depth(p), tau=tau, duration=duration, mass=p.mass)

    def quantities(self, p: Parameters) -> tuple[Quantity, ...]:
        """Overlap, negative while apart, and its rate."""
        s = self.scales(p)
        return (Quantity("overlap", "m", s.length), Quantity("v", "m/s", s.speed))

    def observe(self, p: Parameters, trajectory: Trajectory) -> dict[str, Array]:
        """The overlap [m] and its rate [m/s] at the samples, each (T,)."""
        return {"overlap": trajectory.position[:, 0, 0], "v": trajectory.velocity[:, 0, 0]}

    def truth(self, p: Parameters) -> Truth:
        """The incomplete beta function in, a sine out."""
        from refdem.truth.closed_forms.wedge_collision import truth

        return truth(p, {q.name: q.scale for q in self.quantities(p)})


CASE = WedgeCollision()
