"""A mass that flies past a hook and is caught at the point of closest approach (fig. 1.5)."""

from typing import ClassVar

from refdem.cases import _plane
from refdem.cases._plane import Array
from refdem.core.case import Case
from refdem.core.parameters import Parameter, Parameters
from refdem.core.quantity import Quantity, Scales
from refdem.core.trajectory import Trajectory
from refdem.core.truth import Truth
from refdem.scene import Body, Scene
from refdem.scene.elements.catch import Catch

RUN_UP = 2
"""Distance of the start from the point of closest approach, in units of the radius."""


class CapturedMass(Case):
    """The hook is the origin; the mass comes along y = -radius from x = -2 radius and is caught at
    (0, -radius).
    """

    id = "captured-mass"
    title = "Captured mass"
    words = ("hook", "docking", "catch", "inelastic", "satellite")
    motion = "swinging"
    statement = (
        "A mass flies past a hook in a straight line and is caught where it comes closest, at the"
        " distance r. There its velocity is across the line to the hook, so that it goes on in a"
        " circle with v = r omega: energy and angular momentum about the hook, which is m r^2"
        " omega, stay what they were on the straight line."
    )
    latex = r"L=m\,v\,r=J\,\omega,\qquad J=m\,r^2,\qquad v=r\,\omega"
    source = "Matuttis and Chen 2014, chapter 1, fig. 1.5"
    parameters = (
        Parameter(name="mass", default="1", unit="kg", doc="the point mass", above=0),
        Parameter(
            name="speed", default="1", unit="m/s", doc="of the straight flight, along x", above=0
        ),
        Parameter(
            name="radius", default="1", unit="m", doc="distance of the line from the hook", above=0
        ),
    )
    exclude: ClassVar[dict[str, str]] = {
        "reversal": "the hook does not let go: nothing in the state says where it caught the mass"
    }

    def scene(self, p: Parameters) -> Scene:
        """The scene at the start, before the mass is caught."""
        mass = Body(
            mass=p.mass, position=(-RUN_UP * p.radius, -p.radius, 0.0), velocity=(p.speed, 0.0, 0.0)
        )
        return Scene.of([mass], [Catch(a=0, radius=p.radius)])

    def scales(self, p: Parameters) -> Scales:
        """tau = 1/omega = radius/speed."""
        tau = p.radius / p.speed
        return Scales(length=p.radius, tau=tau, duration=20 * tau, mass=p.mass)

    def quantities(self, p: Parameters) -> tuple[Quantity, ...]:
        """The quantities that are judged: position [m] and velocity [m/s]."""
        s = self.scales(p)
        return _plane.quantities(s.length, s.speed)

    def observe(self, p: Parameters, trajectory: Trajectory) -> dict[str, Array]:
        """The position [m] and the velocity [m/s] at the samples, each (T,)."""
        return _plane.observe(trajectory)

    def truth(self, p: Parameters) -> Truth:
        """The certified motion: a straight line, then a circle."""
        from refdem.truth.closed_forms.captured_mass import truth

        return truth(p, {q.name: q.scale for q in self.quantities(p)})


CASE = CapturedMass()
