"""A heavy symmetric top on its tip: precession, nutation, sleep."""

import numpy as np
from numpy.typing import NDArray

from refdem.cases._fitting import TopOnTip
from refdem.core.parameters import Parameter, Parameters
from refdem.core.quantity import Quantity, Scales
from refdem.core.trajectory import Trajectory
from refdem.core.truth import Truth
from refdem.mechanics.quaternion import matrix
from refdem.scene import Body, Scene
from refdem.scene.elements.ball_joint import BallJoint
from refdem.scene.elements.uniform_gravity import UniformGravity

Array = NDArray[np.float64]


class HeavyTop(TopOnTip):
    """The tip rests at the origin.

    Euler angles z-x-z, theta from the upward vertical, phi = psi = 0 at the start.
    """

    id = "heavy-top"
    title = "Heavy top"
    words = ("gyroscope", "precession", "nutation", "spinning")
    motion = "spinning"
    statement = (
        "A symmetric top spins about its tip. Its axis nutates between two angles as it goes round"
        " the vertical; at the right speed it goes round steadily, J1 W^2 cos theta - J3 w3 W + m g"
        " l = 0. Upright it sleeps if (J3 w3)^2 >= 4 J1 m g l. E, L_z and L_3 stay."
    )
    latex = (
        r"\dot\varphi=\frac{L_z-L_3\cos\theta}{J_1\sin^2\theta},"
        r"\quad\dot\psi=\omega_3-\dot\varphi\cos\theta,\quad "
        r"J_1\ddot\theta=(J_1\dot\varphi\cos\theta-L_3)\,\dot\varphi\sin\theta+mgl\sin\theta"
    )
    source = (
        "Lagrange 1788; Landau and Lifshitz, Mechanics, section 35; Matuttis and Chen 2014,"
        " chapter 1"
    )
    parameters = (
        Parameter(name="mass", default="1", unit="kg", doc="of the top", above=0),
        Parameter(
            name="length",
            default="1/2",
            unit="m",
            doc="from the tip to the centre of mass",
            above=0,
        ),
        Parameter(name="gravity", default="9.8125", unit="m/s^2", doc="along -z", above=0),
        Parameter(
            name="inertia",
            default="1/2,1/4",
            unit="kg m^2",
            doc="J1 and J3 about the tip",
            shape=(2,),
            above=0,
        ),
        Parameter(
            name="theta0",
            default="1/2",
            unit="rad",
            doc="tilt at the start, between 0 and pi",
            above=0,
            at_most=3.14,
        ),
        Parameter(name="phidot0", default="0", unit="rad/s", doc="precession at the start"),
        Parameter(name="thetadot0", default="0", unit="rad/s", doc="rate of the tilt at the start"),
        Parameter(
            name="spin",
            default="20",
            unit="rad/s",
            doc="w3, angular velocity about the axis of the top",
        ),
    )

    def scene(self, p: Parameters) -> Scene:
        """The top on a ball joint at the origin, its centre of mass `length` from the tip.

        With phi = psi = 0 the line of nodes is x, and the axis n = (0, -sin theta, cos theta) is
        the vertical turned by theta about x.
        """
        sine = np.sin(p.theta0)
        cosine = np.cos(p.theta0)
        axis = np.array([0.0, -sine, cosine])
        # omega = theta' e_x + phi' e_z + psi' n, with psi' = w3 - phi' cos theta.
        omega = np.array([p.thetadot0, 0.0, p.phidot0]) + (p.spin - p.phidot0 * cosine) * axis
        position = p.length * axis
        velocity = p.length * np.cross(omega, axis)
        # About the centre of mass the transverse moments are J1 - m l^2 (parallel axes).
        transverse = p.inertia[0] - p.mass * p.length**2
        inertia = (transverse, transverse, p.inertia[1])
        half = p.theta0 / 2
        attitude = (np.cos(half), np.sin(half), 0.0, 0.0)
        top = Body(
            mass=p.mass,
            inertia=inertia,
            position=tuple(position),
            velocity=tuple(velocity),
            attitude=attitude,
            omega=tuple(omega),
        )
        joint = BallJoint(a=0, anchor_a=(0.0, 0.0, -p.length))
        gravity = UniformGravity(g=(0.0, 0.0, -p.gravity))
        return Scene.of([top], [joint, gravity])

    def scales(self, p: Parameters) -> Scales:
        """1/tau^2 is the sum of the squared rates at the start and of that of a pendulum, m g
        l/J1; L is the length, T = 20 tau.
        """
        pendulum = p.mass * p.gravity * p.length / p.inertia[0]
        square = p.spin**2 + p.phidot0**2 + p.thetadot0**2 + pendulum
        tau = square**-0.5
        return Scales(length=p.length, tau=float(tau), duration=float(20 * tau), mass=p.mass)

    def quantities(self, p: Parameters) -> tuple[Quantity, ...]:
        """Euler angles, and the rate of the tilt."""
        angles = tuple(Quantity(name, "rad", 1.0, angle=True) for name in ("theta", "phi", "psi"))
        return (*angles, Quantity("thetadot", "rad/s", 1.0 / self.scales(p).tau))

    def observe(self, p: Parameters, trajectory: Trajectory) -> dict[str, Array]:
        """Euler angles z-x-z [rad] and the rate of theta [rad/s], each (T,).

        The third column of R = R_z(phi) R_x(theta) R_z(psi) is the top's axis in space, (sin phi
        sin theta, -cos phi sin theta, cos theta); its third row is the vertical in body axes, (sin
        theta sin psi, sin theta cos psi, cos theta).
        """
        rotation = matrix(trajectory.attitude[:, 0])
        omega = trajectory.omega[:, 0]
        phi = np.arctan2(rotation[:, 0, 2], -rotation[:, 1, 2])
        psi = np.arctan2(rotation[:, 2, 0], rotation[:, 2, 1])
        sine = np.hypot(rotation[:, 0, 2], rotation[:, 1, 2])
        theta = np.arctan2(sine, rotation[:, 2, 2])
        # theta' is omega along the line of nodes (cos phi, sin phi, 0).
        thetadot = omega[:, 0] * np.cos(phi) + omega[:, 1] * np.sin(phi)
        return {"theta": theta, "phi": phi, "psi": psi, "thetadot": thetadot}

    def truth(self, p: Parameters) -> Truth:
        """Validated integration; nutation and period from the roots of a cubic."""
        from refdem.truth.closed_forms.heavy_top import truth

        s = self.scales(p)
        return truth(p, {q.name: q.scale for q in self.quantities(p)}, 1.0 / s.tau)


CASE = HeavyTop()
