"""A point mass on a rigid rod: the pendulum as a constraint in Cartesian coordinates (1.112)."""

import numpy as np
from numpy.typing import NDArray

from refdem.cases import _angles
from refdem.core.case import NEVER, Case
from refdem.core.parameters import Parameter, Parameters
from refdem.core.quantity import Quantity, Scales
from refdem.core.trajectory import Trajectory
from refdem.core.truth import Truth
from refdem.scene import Body, Scene
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.uniform_gravity import UniformGravity

Array = NDArray[np.float64]


class Pendulum(Case):
    """Planar, gravity along -y, theta from the downward vertical: x = l sin theta, y = -l cos
    theta.
    """

    id = "pendulum"
    title = "Pendulum"
    words = ("swing", "rod", "constraint", "clock", "joint")
    motion = "swinging"
    statement = (
        "A point mass hangs on a rigid massless rod and swings, or goes round. The rod is a"
        " constraint, not a coordinate: its length must stay, and the force in it (positive in"
        " tension) is part of the answer."
    )
    latex = r"\ddot\theta+\frac{g}{l}\sin\theta=0,\qquad F=m\left(l\dot\theta^2+g\cos\theta\right)"
    source = (
        "Matuttis and Chen 2014, chapter 1, (1.112), figs. 1.3a and 1.22; k^2 = sin^2(theta0/2) +"
        " thetadot0^2/(4 w0^2)"
    )
    parameters = (
        Parameter(name="mass", default="1", unit="kg", doc="the point mass", above=0),
        Parameter(name="length", default="1", unit="m", doc="the rod", above=0),
        Parameter(name="gravity", default="9.8125", unit="m/s^2", doc="along -y", above=0),
        Parameter(
            name="theta0",
            default="1",
            unit="rad",
            doc="angle at the start, from the downward vertical",
        ),
        Parameter(name="thetadot0", default="0", unit="rad/s", doc="rate at the start"),
    )
    chaotic_at = NEVER

    def scene(self, p: Parameters) -> Scene:
        """The mass at l (sin theta0, -cos theta0), with the velocity l thetadot0 (cos theta0, sin
        theta0), on a rod from the origin.
        """
        s, c = _angles.sine_and_cosine(p, "theta0")
        speed = p.length * p.thetadot0
        mass = Body(
            mass=p.mass,
            position=(p.length * s, -p.length * c, 0.0),
            velocity=(speed * c, speed * s, 0.0),
        )
        return Scene.of(
            [mass], [Rod(a=0, length=p.length), UniformGravity(g=(0.0, -p.gravity, 0.0))]
        )

    def scales(self, p: Parameters) -> Scales:
        """tau = 1/max(w0, 2 k w0), the second of which is the rate at the bottom; T = 20 tau.

        (2 k w0)^2 = 4 w0^2 sin^2(theta0/2) + thetadot0^2 by the conservation of energy.
        """
        w0 = np.sqrt(p.gravity / p.length)
        bottom_rate = np.hypot(2 * w0 * np.sin(p.theta0 / 2), p.thetadot0)
        tau = 1.0 / float(max(w0, bottom_rate))
        return Scales(length=p.length, tau=tau, duration=20 * tau, mass=p.mass)

    def quantities(self, p: Parameters) -> tuple[Quantity, ...]:
        """The angle, its rate, the position and the force in the rod."""
        s = self.scales(p)
        return (
            Quantity("theta", "rad", 1.0, angle=True),
            Quantity("thetadot", "rad/s", 1.0 / s.tau),
            Quantity("x", "m", s.length),
            Quantity("y", "m", s.length),
            Quantity("rod_force", "N", s.mass * s.speed / s.tau),
        )

    def observe(self, p: Parameters, trajectory: Trajectory) -> dict[str, Array]:
        """theta = atan2(x, -y) [rad], thetadot = (x vy - y vx)/r^2 [rad/s], place, and the rod's
        force [N] if the run has that channel; each (T,).
        """
        x, y, _ = trajectory.position[:, 0].T
        vx, vy, _ = trajectory.velocity[:, 0].T
        observed = {
            "theta": np.arctan2(x, -y),
            "thetadot": (x * vy - y * vx) / (x * x + y * y),
            "x": x,
            "y": y,
        }
        if "rod_force" in trajectory.channels:
            observed["rod_force"] = trajectory.channels["rod_force"].reshape(len(x), -1)[:, 0]
        return observed

    def truth(self, p: Parameters) -> Truth:
        """Jacobi elliptic functions; tanh and sech on the separatrix."""
        from refdem.truth.closed_forms.pendulum import truth

        return truth(p, {q.name: q.scale for q in self.quantities(p)})


CASE = Pendulum()
