"""The two equilibria of a pendulum: stable at the bottom, unstable at the top (fig. 1.34)."""

import numpy as np

from refdem.cases import _plane
from refdem.cases._plane import Array
from refdem.core.case import Case
from refdem.core.parameters import Parameter, Parameters
from refdem.core.quantity import Quantity, Scales
from refdem.core.trajectory import Trajectory
from refdem.core.truth import Truth
from refdem.scene import Body, Scene
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.uniform_gravity import UniformGravity

MASS = 1.0
"""The motion does not depend on it."""


class PendulumEquilibria(Case):
    """Let go at rest, `delta` away from the vertical through the pivot: x = l sin delta."""

    id = "pendulum-equilibria"
    title = "Equilibria of the pendulum"
    words = ("balance", "inverted", "stability", "rest")
    motion = "swinging"
    statement = (
        "A point mass on a rigid rod is let go next to one of its two equilibria. At the bottom it"
        " stays as near as it was. From the top it leaves as delta cosh(w0 t), to first order in"
        " delta; exactly at the top, in Cartesian coordinates, it stays."
    )
    latex = (
        r"\ddot\varphi=\mp\frac{g}{l}\sin\varphi,"
        r"\qquad\varphi\approx\delta\cos\omega_0t\ \text{or}\ \delta\cosh\omega_0t"
    )
    source = "Matuttis and Chen 2014, chapter 1, fig. 1.34"
    parameters = (
        Parameter(name="length", default="1", unit="m", doc="the rod", above=0),
        Parameter(name="gravity", default="9.8125", unit="m/s^2", doc="along -y", above=0),
        Parameter(
            name="position",
            default="top",
            unit="1",
            doc="the equilibrium",
            choices=("top", "bottom"),
        ),
        Parameter(
            name="delta",
            default="1e-3",
            unit="rad",
            doc="angle from it at the start, towards +x",
            at_least=-3,
            at_most=3,
        ),
    )

    def scene(self, p: Parameters) -> Scene:
        """The pendulum at rest, next to the top or the bottom."""
        if p.position == "top":
            side = 1.0
        else:
            side = -1.0
        x = p.length * np.sin(p.delta)
        y = side * p.length * np.cos(p.delta)
        mass = Body(mass=MASS, position=(x, y, 0.0))
        return Scene.of(
            [mass], [Rod(a=0, length=p.length), UniformGravity(g=(0.0, -p.gravity, 0.0))]
        )

    def scales(self, p: Parameters) -> Scales:
        """tau = 1/max(w0, rate at the bottom), T = 20 tau.

        From rest at the angle theta from the downward vertical the rate at the bottom is 2 w0
        sin(theta/2), with theta = delta at the bottom and pi - delta at the top.
        """
        w0 = np.sqrt(p.gravity / p.length)
        if p.position == "top":
            sine = abs(np.cos(p.delta / 2))
        else:
            sine = abs(np.sin(p.delta / 2))
        tau = 1.0 / float(w0 * max(1.0, 2 * sine))
        return Scales(length=p.length, tau=tau, duration=20 * tau, mass=MASS)

    def quantities(self, p: Parameters) -> tuple[Quantity, ...]:
        """The quantities that are judged: position [m] and velocity [m/s]."""
        s = self.scales(p)
        return _plane.quantities(s.length, s.speed)

    def observe(self, p: Parameters, trajectory: Trajectory) -> dict[str, Array]:
        """The position [m] and the velocity [m/s] at the samples, each (T,)."""
        return _plane.observe(trajectory)

    def truth(self, p: Parameters) -> Truth:
        """The certified motion, by the Jacobi functions of the pendulum."""
        from refdem.truth.closed_forms.pendulum_equilibria import truth

        return truth(p, {q.name: q.scale for q in self.quantities(p)})


CASE = PendulumEquilibria()
