"""A body that falls, or is thrown up, in a fluid whose drag grows as the square of the velocity."""

import numpy as np
from numpy.typing import NDArray

from refdem.core.case import NEVER, Case
from refdem.core.parameters import Parameter, Parameters
from refdem.core.quantity import Quantity, Scales
from refdem.core.trajectory import Trajectory
from refdem.core.truth import Truth
from refdem.scene import Body, Scene
from refdem.scene.elements.drag import Drag
from refdem.scene.elements.uniform_gravity import UniformGravity

Array = NDArray[np.float64]

RELAXATIONS = 5.0
"""Duration in units of v_t/g: the velocity is then within 1e-4 of its limit."""


class QuadraticDrag(Case):
    """A point on the y axis from the origin; gravity along -y, drag against the velocity."""

    id = "quadratic-drag"
    title = "Quadratic drag and terminal velocity"
    words = ("parachute", "fall", "air", "projectile", "terminal")
    motion = "flying"
    statement = (
        "A body falls in a fluid that resists as the square of its velocity. Its velocity tends to"
        " the terminal velocity, at which drag and weight balance, from below as tanh and from"
        " above as coth; thrown up, it rises less high than without drag and comes back slower."
    )
    latex = (
        r"m\ddot y=-mg-c\,|\dot y|\,\dot y,\qquad v_t=\sqrt{mg/c},\qquad"
        r" \dot y=-v_t\tanh(gt/v_t)\text{ from rest}"
    )
    source = "Newton 1687, book II; Matuttis and Chen 2014, section 1.4.1: Newtonian friction"
    parameters = (
        Parameter(name="mass", default="2", unit="kg", doc="the point mass", above=0),
        Parameter(name="gravity", default="8", unit="m/s^2", doc="along -y", above=0),
        Parameter(
            name="drag", default="1/4", unit="kg/m", doc="drag over the squared velocity", above=0
        ),
        Parameter(name="v0", default="0", unit="m/s", doc="velocity along +y at the start"),
    )
    chaotic_at = NEVER

    def scene(self, p: Parameters) -> Scene:
        """A point, the field and the fluid."""
        body = Body(mass=p.mass, velocity=(0.0, p.v0, 0.0))
        field = UniformGravity(g=(0.0, -p.gravity, 0.0))
        return Scene.of([body], [field, Drag(a=0, coefficient=p.drag)])

    def scales(self, p: Parameters) -> Scales:
        """L = v_t^2/g is the way on which drag stops the body; tau = L/V, with the larger V of the
        terminal velocity and that of the start.
        """
        terminal = float(np.sqrt(p.mass * p.gravity / p.drag))
        length = p.mass / p.drag
        fastest = max(terminal, abs(p.v0))
        return Scales(
            length=length,
            tau=length / fastest,
            duration=RELAXATIONS * terminal / p.gravity,
            mass=p.mass,
        )

    def quantities(self, p: Parameters) -> tuple[Quantity, ...]:
        """Height [m] and velocity [m/s] along +y."""
        scales = self.scales(p)
        return (Quantity("y", "m", scales.length), Quantity("v", "m/s", scales.speed))

    def observe(self, p: Parameters, trajectory: Trajectory) -> dict[str, Array]:
        """Height [m] and velocity [m/s] at the samples, each (T,)."""
        return {"y": trajectory.position[:, 0, 1], "v": trajectory.velocity[:, 0, 1]}

    def truth(self, p: Parameters) -> Truth:
        """tan on the way up, tanh or coth on the way down."""
        from refdem.truth.closed_forms.quadratic_drag import truth

        return truth(p, {q.name: q.scale for q in self.quantities(p)})


CASE = QuadraticDrag()
