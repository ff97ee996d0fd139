"""How a body that turns may move: on a free joint, or about a hinge at the end of a rod."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from refdem.engines.mujoco.joints import Array, Columns, Freedom
from refdem.mechanics.quaternion import conjugate, rotated
from refdem.scene import Body
from refdem.scene.elements.rod import Rod

SPECK = 1e-15
"""Inertia [kg m^2] about its own centre of a point on a rod: MuJoCo wants at least mjMINVAL = 1e-15."""


@dataclass(frozen=True)
class Free(Freedom):
    """A rigid body on a free joint: velocity in space axes, omega in body axes, quaternion w first, body to space."""

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
    """A point on a massless rod that hangs from the world: a hinge about z at the anchor, the angle from straight down."""

    body: Body
    rod: Rod
    nq = 1
    nv = 1

    @property
    def turns(self) -> bool:
        return True

    def say(self, mujoco: Any, world: Any) -> Any:
        """Mass and arm that make up for the speck, so that m l and m l^2 about the hinge are the point's own."""
        mass, length = self.body.mass, self.rod.length
        arm = length - SPECK / (mass * length)
        bob = {"mass": mass * (length / arm), "inertia": (SPECK,) * 3, "ipos": (0.0, -arm, 0.0), "explicitinertial": True}
        said = world.add_body(pos=self.rod.anchor_b, **bob)
        said.add_joint(type=mujoco.mjtJoint.mjJNT_HINGE, axis=(0.0, 0.0, 1.0))
        said.add_site(name=self.site)
        return said

    @property
    def site(self) -> str:
        """The name of the site at the anchor where the rod's force is felt, in axes that turn with the rod."""
        return f"rod on {self.rod.a}"

    def start(self) -> tuple[Array, Array]:
        x, y, _ = np.subtract(self.body.position, self.rod.anchor_b)
        u, v, _ = self.body.velocity
        return np.array([np.arctan2(x, -y)]), np.array([(x * v - y * u) / self.rod.length**2])

    def read(self, q: Array, v: Array) -> Columns:
        sine, cosine, nothing = np.sin(q[:, 0]), np.cos(q[:, 0]), np.zeros(len(q))
        outward = self.rod.length * np.stack([sine, -cosine, nothing], axis=-1)
        sideways = self.rod.length * v * np.stack([cosine, sine, nothing], axis=-1)
        return Columns(outward + np.array(self.rod.anchor_b), sideways, *self.still(len(q)))
