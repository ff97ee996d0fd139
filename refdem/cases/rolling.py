"""A rigid sphere, disc or ring that slides on a plane until it rolls."""

import numpy as np
from numpy.typing import NDArray

from refdem.cases import _plane, _rigid
from refdem.core.case import NEVER, Case
from refdem.core.parameters import Parameter, Parameters
from refdem.core.quantity import Quantity, Scales
from refdem.core.trajectory import Trajectory
from refdem.core.truth import Truth
from refdem.scene import Scene
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.uniform_gravity import UniformGravity

Array = NDArray[np.float64]
SHORTEST = 8.0
"""The motion lasts so many tau at least, about."""
LONGEST = 64.0
"""The motion lasts so many tau at most, about: a slip that does not end by then is not waited for.
"""
ABOUT = (15 / 16, 17 / 16)
"""Fractions of the requested time between which the run ends, away from the end of the slip."""


class Rolling(Case):
    """x runs down the slope and y is its normal; gravity is tilted instead."""

    id = "rolling"
    title = "Slide and roll"
    words = ("bowling", "wheel", "slip", "friction", "roll", "sphere")
    motion = "rubbing"
    statement = (
        "A rigid sphere, disc or ring lies on a plane, level or sloped, and is given a speed and a"
        " spin. While the point that touches slips, friction of full size acts against the slip,"
        " and not against the motion of the centre; it spins the body up, or turns a body with"
        " backspin round. Where the slip ends the body rolls, for ever, if the tangent of the slope"
        " is at most mu (1 + m R^2/J), the boundary included; on a steeper slope it slides on."
    )
    latex = (
        r"s=v+R\omega,\quad \dot v=g\sin\alpha-\mu g\cos\alpha\,\mathrm{Sgn}(s),\quad"
        r" J\dot\omega=-\mu mgR\cos\alpha\,\mathrm{Sgn}(s),\quad"
        r" \dot v_{\mathrm{roll}}=\frac{g\sin\alpha}{1+J/(mR^2)}"
    )
    source = (
        "Coriolis 1835, Theorie mathematique des effets du jeu de billard; Sommerfeld 1943,"
        " Mechanik, section 27"
    )
    parameters = (
        Parameter(name="mass", default="1", unit="kg", doc="of the body", above=0),
        Parameter(name="radius", default="1/2", unit="m", doc="of the body", above=0),
        Parameter(
            name="inertia_factor",
            default="2/5",
            unit="1",
            doc=_rigid.FACTORS,
            above=0,
            at_most=1,
        ),
        Parameter(name="speed", default="4", unit="m/s", doc="of the centre along x, at the start"),
        Parameter(
            name="spin",
            default="0",
            unit="rad/s",
            doc="omega about z at the start; it rolls where speed + radius spin = 0",
        ),
        Parameter(
            name="friction",
            default="1/4",
            unit="1",
            doc="coefficient of static and sliding friction",
            at_least=0,
        ),
        Parameter(
            name="slope",
            default="0",
            unit="1",
            doc="tangent of the angle at which the plane falls along x",
            at_least=0,
        ),
        Parameter(name="gravity", default="9.8125", unit="m/s^2", doc="straight down", above=0),
    )
    chaotic_at = NEVER

    def scene(self, p: Parameters) -> Scene:
        """The body on the plane y = 0, in gravity of the slope's angle."""
        body = _rigid.sphere(
            mass=p.mass,
            factor=p.inertia_factor,
            radius=p.radius,
            position=np.array([0.0, p.radius, 0.0]),
            velocity=np.array([p.speed, 0.0, 0.0]),
            omega=np.array([0.0, 0.0, p.spin]),
        )
        hypotenuse = float(np.hypot(1.0, p.slope))
        along = p.gravity * (p.slope / hypotenuse)
        pressing = p.gravity / hypotenuse
        gravity = UniformGravity(g=(along, -pressing, 0.0))
        contact = Contact(law="rigid", friction=p.friction)
        return Scene.of([body], [Plane(normal=(0.0, 1.0, 0.0)), gravity, contact])

    def scales(self, p: Parameters) -> Scales:
        """L = R, tau = R/V with the fastest of centre, surface and sqrt(g R); about twice as long
        as the slip lasts, within SHORTEST and LONGEST tau.
        """
        fastest = max(abs(p.speed), p.radius * abs(p.spin), float(np.sqrt(p.gravity * p.radius)))
        tau = p.radius / fastest
        end = _end_of_slip(p)
        wanted = min(max(2 * end, SHORTEST * tau), LONGEST * tau)
        least, most = (part * wanted for part in ABOUT)
        if end > 0:
            duration = _rigid.clear_of_all(
                np.array([end]), int(p.samples), least=float(least), most=float(most)
            )
        else:
            duration = wanted
        return Scales(length=p.radius, tau=tau, duration=duration, mass=p.mass)

    def quantities(self, p: Parameters) -> tuple[Quantity, ...]:
        """Place, velocity and angular velocity in the plane x-y."""
        scales = self.scales(p)
        return _plane.quantities_with_spin(scales.length, scales.speed, 1 / scales.tau)

    def observe(self, p: Parameters, trajectory: Trajectory) -> dict[str, Array]:
        """Place, velocity and angular velocity in the plane at the samples, each (T,)."""
        return _plane.observe_with_spin(trajectory)

    def truth(self, p: Parameters) -> Truth:
        """Uniform accelerations, phase by phase."""
        from refdem.truth.closed_forms.rolling import truth

        return truth(p, {q.name: q.scale for q in self.quantities(p)})


def _end_of_slip(p: Parameters) -> float:
    """The time [s] at which the slip ends, or friction turns round; 0 if that is never."""
    from refdem.truth.closed_forms.rolling import incline_of
    from refdem.truth.exact import number

    slip = number(p, "speed") + number(p, "radius") * number(p, "spin")
    ended = incline_of(p).lasts(slip)
    if ended is None:
        return 0.0
    return float(ended)


CASE = Rolling()
