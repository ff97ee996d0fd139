"""A pendulum on a string that runs over a wheel to a mass on the other side (fig. 1.3b)."""

import numpy as np
from numpy.typing import NDArray

from refdem.cases import _angles
from refdem.cases._fitting import StringOnWheel
from refdem.core.parameters import Parameter, Parameters
from refdem.core.quantity import Quantity, Scales
from refdem.core.trajectory import Trajectory
from refdem.core.truth import Truth
from refdem.scene import Body, Scene
from refdem.scene.elements.string_over_wheel import StringOverWheel
from refdem.scene.elements.uniform_gravity import UniformGravity

Array = NDArray[np.float64]


class PendulumWheelMass(StringOnWheel):
    """Wheel at the origin; a = R (cos th, sin th) + r (sin th, -cos th) swings, b = (-R, -s) moves
    up and down, s - R th + r stays.
    """

    id = "pendulum-wheel-mass"
    title = "Pendulum, wheel and mass"
    words = ("pulley", "rope", "string", "gear", "winch", "atwood")
    motion = "swinging"
    statement = (
        "A taut string runs over a wheel and does not slip; a pendulum swings on one side, a mass"
        " hangs on the other. The pendulum's length changes as it swings. Energy stays; another"
        " integral does so only for a wheel of no size and a mass of three pendulums."
    )
    latex = (
        r"u=\dot r-R\dot\theta,\quad (M+m+J/R^2)\dot u=mr\dot\theta^2-Mg+mg\cos\theta,\quad "
        r"r\ddot\theta=-2u\dot\theta-R\dot\theta^2-g\sin\theta"
    )
    source = (
        "Matuttis and Chen 2014, chapter 1, fig. 1.3b; Tufillaro 1986 for the integrable case"
        " (Swinging Atwood's machine)"
    )
    parameters = (
        *(
            Parameter(name=n, default=d, unit="kg", doc=doc, above=0)
            for n, d, doc in (("mass", "1", "m"), ("counter_mass", "3/2", "M"))
        ),
        Parameter(name="wheel_radius", default="1/8", unit="m", doc="R", at_least=0),
        Parameter(
            name="wheel_inertia", default="1/128", unit="kg m^2", doc="J about the axle", at_least=0
        ),
        Parameter(name="gravity", default="9.8125", unit="m/s^2", doc="along -y", above=0),
        Parameter(
            name="r0",
            default="1",
            unit="m",
            doc="free string of the pendulum at the start",
            above=0,
        ),
        Parameter(
            name="theta0",
            default="3/2",
            unit="rad",
            doc="its angle from the downward vertical at the start",
        ),
        Parameter(name="rdot0", default="0", unit="m/s", doc="rate of r at the start"),
        Parameter(name="thetadot0", default="0", unit="rad/s", doc="rate of theta at the start"),
    )

    def scene(self, p: Parameters) -> Scene:
        """The pendulum on the right, the mass on the left, as far below the wheel as the pendulum's
        string is long.
        """
        # The string leaves the wheel at R e_t in the direction e_r: a = R e_t + r e_r. With e_t' =
        # -theta' e_r and e_r' = theta' e_t its velocity is u e_r + r theta' e_t, where u = r' - R
        # theta' is also the upward velocity of the mass on the other side.
        sine, cosine = _angles.sine_and_cosine(p, "theta0")
        tangential = np.array((cosine, sine, 0.0))
        radial = np.array((sine, -cosine, 0.0))
        u = p.rdot0 - p.wheel_radius * p.thetadot0
        position = p.wheel_radius * tangential + p.r0 * radial
        velocity = u * radial + p.r0 * p.thetadot0 * tangential
        bob = Body(mass=p.mass, position=tuple(position), velocity=tuple(velocity))
        counter = Body(
            mass=p.counter_mass, position=(-p.wheel_radius, -p.r0, 0.0), velocity=(0.0, u, 0.0)
        )
        string = StringOverWheel(a=0, b=1, radius=p.wheel_radius, inertia=p.wheel_inertia)
        return Scene.of([bob, counter], [string, UniformGravity(g=(0.0, -p.gravity, 0.0))])

    def scales(self, p: Parameters) -> Scales:
        """L = r0 + R; 1/tau^2 = g/r0 + thetadot0^2 + (rdot0/r0)^2."""
        tau = 1.0 / float(np.sqrt(p.gravity / p.r0 + p.thetadot0**2 + (p.rdot0 / p.r0) ** 2))
        return Scales(
            length=p.r0 + p.wheel_radius, tau=tau, duration=20 * tau, mass=p.mass + p.counter_mass
        )

    def quantities(self, p: Parameters) -> tuple[Quantity, ...]:
        """Length and angle of the pendulum, and their rates."""
        s = self.scales(p)
        return (
            Quantity("r", "m", s.length),
            Quantity("theta", "rad", 1.0, angle=True),
            Quantity("rdot", "m/s", s.speed),
            Quantity("thetadot", "rad/s", 1.0 / s.tau),
        )

    def observe(self, p: Parameters, trajectory: Trajectory) -> dict[str, Array]:
        """The quantities from the pendulum's bob alone, each (T,).

        Its string is a tangent of the wheel, of length r: x^2 + y^2 = r^2 + R^2, and as complex
        numbers (r + i R) exp(i theta) = -y + i x.
        """
        x, y, _ = trajectory.position[:, 0].T
        vx, vy, _ = trajectory.velocity[:, 0].T
        r = np.sqrt(x * x + y * y - p.wheel_radius**2)
        theta = np.angle((-y + 1j * x) / (r + 1j * p.wheel_radius))
        # Of the velocity u e_r + r theta' e_t, with u = r' - R theta'.
        thetadot = (vx * np.cos(theta) + vy * np.sin(theta)) / r
        u = vx * np.sin(theta) - vy * np.cos(theta)
        rdot = u + p.wheel_radius * thetadot
        return {"r": r, "theta": theta, "rdot": rdot, "thetadot": thetadot}

    def truth(self, p: Parameters) -> Truth:
        """The truth by validated integration of the equations of motion."""
        from refdem.truth.closed_forms.pendulum_wheel_mass import truth

        return truth(p, {q.name: q.scale for q in self.quantities(p)})


CASE = PendulumWheelMass()
