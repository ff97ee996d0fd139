"""A body on a ball joint of the world: MuJoCo's own, at the joint, with the centre of mass at the
end of an arm.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from refdem.core.refusal import adapter_lacks, engine_cannot
from refdem.engines.mujoco.joints import Array, Columns, Freedom
from refdem.mechanics.quaternion import conjugate, rotated
from refdem.scene import Body, Scene
from refdem.scene.elements.ball_joint import BallJoint

FITS = 1e-9
"""Relative gap of a joint in position or velocity at the start that counts as rounding."""


@dataclass(frozen=True)
class BallFreedom(Freedom):
    """Quaternion w first, body to space; omega in body axes."""

    body: Body
    joint: BallJoint
    nq = 4
    nv = 3

    @property
    def turns(self) -> bool:
        return True

    @property
    def arm(self) -> Array:
        """The vector (3,) [m] from the joint to the centre of mass, in body axes."""
        return -np.array(self.joint.anchor_a)

    def add_body(self, mujoco: Any, parent: Any) -> Any:
        inertial = {
            "mass": self.body.mass,
            "inertia": self.body.inertia,
            "ipos": tuple(self.arm),
            "explicitinertial": True,
        }
        mj_body = parent.add_body(pos=self.joint.anchor_b, **inertial)
        mj_body.add_joint(type=mujoco.mjtJoint.mjJNT_BALL)
        return mj_body

    def start(self) -> tuple[Array, Array]:
        attitude = np.array(self.body.attitude, float)
        return attitude, rotated(conjugate(attitude), np.array(self.body.omega, float))

    def read(self, q: Array, v: Array) -> Columns:
        omega = rotated(q, v)
        arm = rotated(q, self.arm)
        return Columns(arm + np.array(self.joint.anchor_b), np.cross(omega, arm), q, omega)


def of_ball_joints(scene: Scene) -> str | None:
    """None if every ball joint is supported, else the reason why not."""
    joints = scene.all(BallJoint)
    if not joints:
        return None
    if any(element.kind not in ("ball_joint", "uniform_gravity") for element in scene.elements):
        return adapter_lacks("ball joints beside other elements than gravity")
    if any(joint.b >= 0 for joint in joints) or len({joint.a for joint in joints}) < len(joints):
        return adapter_lacks("ball joints between bodies, or more than one on a body")
    for joint in joints:
        body = scene.bodies.single()[joint.a]
        arm = rotated(np.array(body.attitude), -np.array(joint.anchor_a))
        omega = np.array(body.omega)
        if body.fixed or not any(body.inertia):
            return engine_cannot("a ball joint on a body without rotation")
        # A closed joint: r = anchor + arm and v = omega x arm, to the rounding of each.
        gap = np.linalg.norm(np.subtract(body.position, joint.anchor_b) - arm)
        slip = np.linalg.norm(np.subtract(body.velocity, np.cross(omega, arm)))
        arm_length = float(np.linalg.norm(arm))
        is_open = gap > FITS * (arm_length + np.linalg.norm(joint.anchor_b))
        slides = slip > FITS * arm_length * np.linalg.norm(omega)
        if is_open or slides:
            return engine_cannot("an initially open joint, which a ball joint cannot represent")
    return None
