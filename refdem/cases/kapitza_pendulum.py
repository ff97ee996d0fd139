"""A pendulum whose pivot shakes up and down: it can stand on its head."""

import numpy as np
from numpy.typing import NDArray

from refdem.cases import _angles
from refdem.core.case import Case
from refdem.core.parameters import Parameter, Parameters
from refdem.core.quantity import Quantity, Scales
from refdem.core.trajectory import Trajectory
from refdem.core.truth import Truth
from refdem.scene import Body, Scene
from refdem.scene.elements.moving_anchor import MovingAnchor
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.uniform_gravity import UniformGravity

Array = NDArray[np.float64]
MASS = 1.0
"""The motion does not depend on it, nor on that of the pivot."""


class KapitzaPendulum(Case):
    """Pivot at y = a cos(drive t), gravity along -y, theta from the top: x = l sin theta, y = pivot
    + l cos theta.
    """

    id = "kapitza-pendulum"
    title = "Kapitza's pendulum"
    words = ("inverted", "vibration", "stability", "drone")
    motion = "swinging"
    statement = (
        "The pivot of a pendulum moves up and down by a law of time. Fast enough, it holds the"
        " pendulum upright: the top is stable where both Floquet multipliers of the motion about it"
        " lie on the unit circle, which needs (a drive)^2 > 2 g l for a fast drive, and ends at an"
        " amplitude near 0.45 l. A real multiplier is reported as it is, one of a complex pair by"
        " its modulus 1."
    )
    latex = r"\ddot\theta=\frac{g-a\Omega^2\cos\Omega t}{l}\,\sin\theta"
    source = (
        "Kapitza 1951; Landau and Lifshitz, Mechanics, section 30; Matuttis and Chen 2014,"
        " chapter 1"
    )
    parameters = (
        Parameter(name="length", default="1", unit="m", doc="the rod", above=0),
        Parameter(name="gravity", default="1", unit="m/s^2", doc="along -y", above=0),
        Parameter(
            name="drive_amplitude", default="1/4", unit="m", doc="a, of the pivot", at_least=0
        ),
        Parameter(
            name="drive", default="10", unit="rad/s", doc="angular frequency of the pivot", above=0
        ),
        Parameter(name="theta0", default="1/4", unit="rad", doc="angle at the start, from the top"),
        Parameter(name="thetadot0", default="0", unit="rad/s", doc="rate at the start"),
    )

    def scene(self, p: Parameters) -> Scene:
        """The bob, and the pivot as a body that is carried."""
        # At t = 0 the pivot is at y = a, at rest; theta is measured from the top.
        sine, cosine = _angles.sine_and_cosine(p, "theta0")
        speed = p.length * p.thetadot0
        position = (p.length * sine, p.drive_amplitude + p.length * cosine, 0.0)
        bob = Body(mass=MASS, position=position, velocity=(speed * cosine, -speed * sine, 0.0))
        pivot = Body(mass=MASS, position=(0.0, p.drive_amplitude, 0.0))
        shaking = MovingAnchor(
            a=1, amplitude=p.drive_amplitude, frequency=p.drive, axis=(0.0, 1.0, 0.0)
        )
        return Scene.of(
            [bob, pivot],
            [Rod(a=0, b=1, length=p.length), shaking, UniformGravity(g=(0.0, -p.gravity, 0.0))],
        )

    def scales(self, p: Parameters) -> Scales:
        """1/tau^2 = Omega^2 + (g + a Omega^2)/l + thetadot0^2, T = 100 tau.

        Omega is the drive; a Omega^2 is the largest acceleration of the pivot, in whose frame it
        adds to gravity.
        """
        pivot_acceleration = p.drive_amplitude * p.drive**2
        pendulum = (p.gravity + pivot_acceleration) / p.length
        tau = 1.0 / float(np.sqrt(p.drive**2 + pendulum + p.thetadot0**2))
        return Scales(length=p.length + p.drive_amplitude, tau=tau, duration=100 * tau, mass=MASS)

    def quantities(self, p: Parameters) -> tuple[Quantity, ...]:
        """The quantities that are judged: angle [rad] and rate [rad/s]."""
        fastest = 1.0 / self.scales(p).tau
        return (
            Quantity("theta", "rad", 1.0, angle=True),
            Quantity("thetadot", "rad/s", fastest),
        )

    def observe(self, p: Parameters, trajectory: Trajectory) -> dict[str, Array]:
        """theta = atan2(x, y) and thetadot = (x' y - x y')/(x^2 + y^2), each (T,).

        (x, y) is the vector from the pivot, body 1, to the bob, body 0.
        """
        x, y, _ = (trajectory.position[:, 0] - trajectory.position[:, 1]).T
        vx, vy, _ = (trajectory.velocity[:, 0] - trajectory.velocity[:, 1]).T
        theta = np.arctan2(x, y)
        thetadot = (vx * y - x * vy) / (x * x + y * y)
        return {"theta": theta, "thetadot": thetadot}

    def truth(self, p: Parameters) -> Truth:
        """Validated integration; Floquet multipliers from the linear equation."""
        from refdem.truth.closed_forms.kapitza_pendulum import truth

        return truth(p, {q.name: q.scale for q in self.quantities(p)})


CASE = KapitzaPendulum()
