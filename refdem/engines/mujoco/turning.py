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

    def say(self, mujoco: Any, world: Any) -> Any:
        said = world.add_body(mass=self.body.mass, inertia=self.body.inertia, explicitinertial=True)
        said.add_freejoint()
        return said

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

    def say(self, mujoco: Any, world: Any) -> Any:
        """Mass and arm that make up for the speck, so that m l and m l^2 about the hinge are the
        point's own.
        """
        mass = self.body.mass
        length = self.rod.length
        arm = length - SPECK / (mass * length)
        if self.above:
            place = (0.0, -self.above.rod.length, 0.0)
        else:
            place = self.rod.anchor_b
        bob = {
            "mass": mass * (length / arm),
            "inertia": (SPECK,) * 3,
            "ipos": (0.0, -arm, 0.0),
            "explicitinertial": True,
        }
        said = world.add_body(pos=place, **bob)
        said.add_joint(type=mujoco.mjtJoint.mjJNT_HINGE, axis=(0.0, 0.0, 1.0))
        said.add_site(name=self.site)
        return said

    @property
    def site(self) -> str:
        """The name of the site at the anchor where the rod's force is felt, in axes that turn with
        the rod.
        """
        return f"rod on {self.rod.a}"

    def hanging(self) -> tuple[float, float]:
        """Angle from straight down and its rate at the start."""
        place: Any = self.rod.anchor_b
        speed: Any = (0.0, 0.0, 0.0)
        if self.above:
            place = self.above.body.position
            speed = self.above.body.velocity
        x, y, _ = np.subtract(self.body.position, place)
        u, v, _ = np.subtract(self.body.velocity, speed)
        return float(np.arctan2(x, -y)), float((x * v - y * u) / self.rod.length**2)

    def start(self) -> tuple[Array, Array]:
        angle, rate = self.hanging()
        if self.above:
            before = self.above.hanging()
        else:
            before = (0.0, 0.0)
        return np.array([angle - before[0]]), np.array([rate - before[1]])

    def read(self, q: Array, v: Array) -> Columns:
        """The state of the body from the coordinates of the lineage, (T, its length) each."""
        angle = np.cumsum(q, axis=1)
        rate = np.cumsum(v, axis=1)
        length = np.array([hinge.rod.length for hinge in self.lineage])
        sine = np.sin(angle)
        cosine = np.cos(angle)
        nothing = np.zeros_like(angle)
        outward = np.stack([sine, -cosine, nothing], axis=-1) * length[:, None]
        sideways = np.stack([cosine, sine, nothing], axis=-1) * (length * rate)[..., None]
        return Columns(
            outward.sum(axis=1) + np.array(self.lineage[0].rod.anchor_b),
            sideways.sum(axis=1),
            *self.still(len(q)),
        )
