"""One body about a fixed centre: Newton's attraction (Kepler), or a spring of natural length 0."""

import numpy as np

from refdem.cases import _plane
from refdem.cases._plane import Array
from refdem.core.case import NEVER, Case
from refdem.core.parameters import Parameter, Parameters
from refdem.core.quantity import Quantity, Scales
from refdem.core.trajectory import Trajectory
from refdem.core.truth import Truth
from refdem.scene import Body, Scene
from refdem.scene.elements.central_field import CentralField
from refdem.scene.elements.spring import Spring

REVOLUTIONS = 3
"""Duration in revolutions: tau of an eccentric orbit is far below its period, so that 20 tau would
show too little of it.
"""


def _periapsis(p: Parameters) -> tuple[float, float, float]:
    """Distance [m] and speed [m/s] at the closest approach, and the period [s]; the mass is 1
    kg.
    """
    a = p.semi_major
    e = p.eccentricity
    if p.stiffness is not None:
        # r'' = -w^2 r with w^2 = k/m: the centre is the middle of the ellipse, the closest point
        # the end of the short axis b = a sqrt(1 - e^2), passed with the speed a w; T = 2 pi/w.
        w = float(np.sqrt(p.stiffness))
        b = a * float(np.sqrt((1 - e) * (1 + e)))
        return b, a * w, 2 * np.pi / w
    # Kepler: r = a (1 - e), v^2 = gm/a (1 + e)/(1 - e), T = 2 pi sqrt(a^3/gm).
    distance = a * (1 - e)
    speed = float(np.sqrt(p.gm / a * (1 + e) / (1 - e)))
    period = 2 * np.pi * float(np.sqrt(a**3 / p.gm))
    return distance, speed, period


class TwoBodyOrbit(Case):
    """The orbit lies in the x-y plane and starts in +y: from periapsis on +x, or with the spring
    from the end of the long axis on +x.
    """

    id = "two-body-orbit"
    title = "Two-body orbit"
    words = ("satellite", "planet", "kepler", "gravity", "celestial")
    motion = "orbiting"
    statement = (
        "A body of unit mass goes round a fixed centre on an ellipse: with Newton's attraction the"
        " centre is a focus, with a spring (parameter stiffness) it is the middle. Energy and"
        " angular momentum stay, and the ellipse does not turn."
    )
    latex = (
        r"\ddot{\mathbf r}=-\frac{GM}{r^3}\,\mathbf r\quad\text{or}\quad\ddot{\mathbf"
        r" r}=-k\,\mathbf r"
    )
    source = (
        "Matuttis and Chen 2014, chapter 1, section 1.7.4 (conservation laws); Kepler's equation E"
        " - e sin E = n t"
    )
    parameters = (
        Parameter(
            name="gm",
            default="1",
            unit="m^3/s^2",
            doc="Newton's attraction; not used with a spring",
            above=0,
        ),
        Parameter(name="semi_major", default="1", unit="m", doc="semi-major axis", above=0),
        Parameter(
            name="eccentricity",
            default="1/2",
            unit="1",
            doc="of the ellipse, below 1; Newton's orbit starts at its periapsis",
            at_least=0,
            at_most=0.999999,
        ),
        Parameter(
            name="stiffness",
            default="",
            unit="N/m",
            doc="a spring to the centre in place of gravity; starts at the end of the long axis",
            above=0,
        ),
    )
    chaotic_at = NEVER

    def scene(self, p: Parameters) -> Scene:
        """The body on +x, which moves in +y, and what attracts it."""
        distance, speed, _ = _periapsis(p)
        field: CentralField | Spring
        if p.stiffness is None:
            field = CentralField(gm=p.gm)
        else:
            field = Spring(a=0, stiffness=p.stiffness)
            # It starts from the end of the long axis, with the speed b w.
            speed = distance * float(np.sqrt(p.stiffness))
            distance = p.semi_major
        body = Body(mass=1.0, position=(distance, 0.0, 0.0), velocity=(0.0, speed, 0.0))
        return Scene.of([body], [field])

    def scales(self, p: Parameters) -> Scales:
        """Distance at periapsis and tau = 1/(angular velocity there), so that L/tau is the speed
        there.
        """
        distance, speed, period = _periapsis(p)
        return Scales(length=distance, tau=distance / speed, duration=REVOLUTIONS * period)

    def quantities(self, p: Parameters) -> tuple[Quantity, ...]:
        """Place on the scale of the orbit, velocity on that of periapsis."""
        return _plane.quantities(p.semi_major, self.scales(p).speed)

    def observe(self, p: Parameters, trajectory: Trajectory) -> dict[str, Array]:
        """The position [m] and velocity [m/s] (T,) of body 0, by component."""
        return _plane.observe(trajectory)

    def truth(self, p: Parameters) -> Truth:
        """Kepler's equation by interval Newton; sine and cosine for the spring."""
        from refdem.truth.closed_forms.two_body_orbit import truth

        return truth(p, {q.name: q.scale for q in self.quantities(p)})


CASE = TwoBodyOrbit()
