"""A rigid body about a ball joint of the world, in uniform gravity (kernels/spinning_top.c)."""

from time import perf_counter
from typing import Any

import numpy as np

from refdem.core.engine import Method
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Cost, Trajectory
from refdem.errors import EngineError
from refdem.kernels import load, pointer
from refdem.mechanics.quaternion import conjugate, rotated
from refdem.scene import Scene
from refdem.scene.elements.ball_joint import BallJoint
from refdem.scene.elements.uniform_gravity import UniformGravity
from refdem.solvers import _single_point as single
from refdem.solvers._single_point import Array
from refdem.solvers.solver import Solver

FITS = 1e-9
"""Part of a length, or of a speed, by which the start may miss the joint: rounding."""


class SpinningTop(Solver):
    """Attitude and omega by Taylor series; place and velocity from them."""

    claims = Method(
        name="spinning-top",
        summary=(
            "rigid body about a fixed point in gravity: Taylor series of order 20, steps to"
            " round-off"
        ),
        control="exact",
        derived={
            "attitude": (
                "the attitude is divided by its length when it is handed out, so that it is"
                " always 1"
            ),
            "ball_joint": (
                "places are made of the attitude and the arm, so that the joint is always closed"
            ),
        },
        conserves=frozenset({"energy", "constraint"}),
        reversible=True,
        symplectic=True,
        backward=True,
        cost_rank=2,
    )
    kernels = ("spinning_top",)

    def unsupported(self, problem: Motion) -> str | None:
        """None for one body with inertia on one ball joint of the world that it fits."""
        scene = problem.scene
        others = [
            element.kind
            for element in scene.elements
            if not isinstance(element, BallJoint | UniformGravity)
        ]
        if (
            others
            or len(scene.all(BallJoint)) != 1
            or len(scene.bodies) != 1
            or scene.bodies.fixed.any()
        ):
            if others:
                return f"{others[0]} beside a ball joint"
            return "not one free body on one ball joint"
        joint = scene.all(BallJoint)[0]
        if np.count_nonzero(joint.anchor_a) > 1:
            return "the joint is not one of the world on a principal axis of the body"
        if not _about_joint(scene).all():
            return "no inertia about one of the axes through the joint"
        return _astray(scene)

    def run(self, request: Request) -> tuple[Trajectory, Cost]:
        """Position, velocity, attitude and omega at the samples."""
        begun = perf_counter()
        scene = request.problem.scene
        t = np.ascontiguousarray(request.problem.times)
        bodies = scene.bodies
        joint = scene.all(BallJoint)[0]
        arm = -np.array(joint.anchor_a)
        weight = bodies.mass[0] * single.gravity(scene)
        # A row: attitude, omega in body axes [rad/s].
        omega_body = rotated(conjugate(bodies.attitude[0]), bodies.omega[0])
        states = np.empty((len(t), 7))
        states[0] = np.concatenate([bodies.attitude[0], omega_body])
        columns = (_about_joint(scene), arm, weight)
        given = [pointer("spinning_top", np.ascontiguousarray(column)) for column in columns]
        out = pointer("spinning_top", states, output=True)
        started = perf_counter()
        failed = load("spinning_top").lib.refdem_spinning_top(
            *given, len(t), pointer("spinning_top", t), out
        )
        cost = Cost(seconds=perf_counter() - started, setup=started - begun)
        if failed:
            raise EngineError(
                f"spinning-top: the series do not reach sample {failed - 1}; expected a motion"
                " without singularities"
            )
        attitude = states[:, :4] / np.linalg.norm(states[:, :4], axis=1, keepdims=True)
        omega = rotated(attitude, states[:, 4:])
        reach = rotated(attitude, arm)
        found: dict[str, Any] = {
            "position": reach + single.anchor(joint),
            "velocity": np.cross(omega, reach),
            "attitude": attitude,
            "omega": omega,
        }
        rows: dict[str, Any] = {}
        for name, values in found.items():
            # The first row is the start as it came, not as it is rounded here.
            values[0] = getattr(bodies, name)[0]
            rows[name] = np.ascontiguousarray(values[:, None])
        return Trajectory(t=t, **rows), cost


def _about_joint(scene: Scene) -> Array:
    """Principal moments (3,) about the joint: m l^2 more about the two axes across the arm."""
    arm = np.array(scene.all(BallJoint)[0].anchor_a)
    inertia: Array = scene.bodies.inertia[0] + scene.bodies.mass[0] * (arm @ arm - arm**2)
    return inertia


def _astray(scene: Scene) -> str | None:
    """None if the joint is closed at the start, in place and in velocity."""
    bodies = scene.bodies
    joint = scene.all(BallJoint)[0]
    arm = rotated(bodies.attitude[0], -np.array(joint.anchor_a))
    size = float(np.linalg.norm(arm))
    speed = float(np.linalg.norm(bodies.omega[0]))
    gap = np.linalg.norm(bodies.position[0] - arm - single.anchor(joint))
    if gap > FITS * (size + np.linalg.norm(joint.anchor_b)):
        return "the joint is open at the start"
    joint_speed = np.linalg.norm(bodies.velocity[0] - np.cross(bodies.omega[0], arm))
    if joint_speed > FITS * size * speed:
        return "the joint moves at the start"
    return None


METHOD = SpinningTop()
