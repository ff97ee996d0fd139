"""How a body that turns may move: on a free joint, or about a hinge at the end of a rod."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from refdem.engines.mujoco.joints import Array, Columns, Freedom
from refdem.mechanics.quaternion import conjugate, rotated
from refdem.scene import Body
from refdem.scene.elements.rod import Rod

SPECK = 1e-15
"""Inertia [kg m^2] about its own centre of a point on a rod: MuJoCo wants at least mjMINVAL =
1e-15.
"""


@dataclass(frozen=True)
class Free(Freedom):
    """A rigid body on a free joint: velocity in space axes, omega in body axes, quaternion w first,
    body to space.
    """

    body: Body
    nq = 7
    nv = 6

    @property
    def turns(self) -> bool:
        return True

    def add_body(self, mujoco: Any, parent: Any) -> Any:
        body = self.body
        mj_body = parent.add_body(mass=body.mass, inertia=body.inertia, explicitinertial=True)
        mj_body.add_freejoint()
        return mj_body

    def start(self) -> tuple[Array, Array]:
        body = self.body
        body_omega = rotated(conjugate(np.array(body.attitude, float)), np.array(body.omega, float))
        return np.array([*body.position, *body.attitude]), np.array([*body.velocity, *body_omega])

    def read(self, q: Array, v: Array) -> Columns:
        return Columns(q[:, :3], v[:, :3], q[:, 3:], rotated(q[:, 3:], v[:, 3:]))


@dataclass(frozen=True)
class Hinge(Freedom):
    """A point on a massless rod below the world or another such point: a hinge about z at the upper
    end.

    The coordinate is the angle from straight down, or from the direction of the rod above.
    """

    body: Body
    rod: Rod
    above: "Hinge | None" = None
    nq = 1
    nv = 1

    @property
    def turns(self) -> bool:
        return True

    @property
    def lineage(self) -> tuple["Hinge", ...]:
        """The hinges from the world down to this one."""
        if self.above:
            return (*self.above.lineage, self)
        return (self,)

    def add_body(self, mujoco: Any, parent: Any) -> Any:
        """The body of MuJoCo below the hinge; mass and arm compensate for its own inertia SPECK.

        With the arm a and the mass M = m l/a, M a is m l, and M a^2 + SPECK is m l^2, so that the
        weight's torque and the inertia about the hinge are those of the point.
        """
        mass = self.body.mass
        length = self.rod.length
        arm = length - SPECK / (mass * length)
        hinge: Any = self.rod.anchor_b
        if self.above:
            hinge = (0.0, -self.above.rod.length, 0.0)
        inertial = {
            "mass": mass * (length / arm),
            "inertia": (SPECK,) * 3,
            "ipos": (0.0, -arm, 0.0),
            "explicitinertial": True,
        }
        mj_body = parent.add_body(pos=hinge, **inertial)
        mj_body.add_joint(type=mujoco.mjtJoint.mjJNT_HINGE, axis=(0.0, 0.0, 1.0))
        mj_body.add_site(name=self.site)
        return mj_body

    @property
    def site(self) -> str:
        """The name of the site at the anchor where the rod's force is felt, in axes that turn with
        the rod.
        """
        return f"rod on {self.rod.a}"

    def hanging(self) -> tuple[float, float]:
        """Angle from straight down [rad] and its rate [rad/s] at the start."""
        hinge_position: Any = self.rod.anchor_b
        hinge_velocity: Any = (0.0, 0.0, 0.0)
        if self.above:
            hinge_position = self.above.body.position
            hinge_velocity = self.above.body.velocity
        x, y, _ = np.subtract(self.body.position, hinge_position)
        u, v, _ = np.subtract(self.body.velocity, hinge_velocity)
        # (x, y) = l (sin theta, -cos theta), and l^2 theta' = x y' - y x'.
        angle = float(np.arctan2(x, -y))
        rate = float((x * v - y * u) / self.rod.length**2)
        return angle, rate

    def start(self) -> tuple[Array, Array]:
        angle, rate = self.hanging()
        # The joint's coordinate is the angle from the rod above.
        angle_above = 0.0
        rate_above = 0.0
        if self.above:
            angle_above, rate_above = self.above.hanging()
        return np.array([angle - angle_above]), np.array([rate - rate_above])

    def read(self, q: Array, v: Array) -> Columns:
        """The state of the body from the coordinates of the lineage, (T, its length) each."""
        # Each coordinate is the angle from the rod above: angles from straight down are their sums.
        angle = np.cumsum(q, axis=1)
        rate = np.cumsum(v, axis=1)
        length = np.array([hinge.rod.length for hinge in self.lineage])
        sine = np.sin(angle)
        cosine = np.cos(angle)
        zero = np.zeros_like(angle)
        # r = anchor + sum of l (sin, -cos), v = sum of l theta' (cos, sin), over the rods above.
        arms = np.stack([sine, -cosine, zero], axis=-1) * length[:, None]
        velocities = np.stack([cosine, sine, zero], axis=-1) * (length * rate)[..., None]
        anchor = np.array(self.lineage[0].rod.anchor_b)
        attitude, omega = self.still(len(q))
        return Columns(arms.sum(axis=1) + anchor, velocities.sum(axis=1), attitude, omega)
