"""A rigid body on a ball joint fixed to the world, in uniform gravity, by Taylor series in attitude
and omega (kernels/spinning_top.c).

In body axes, with the principal moments J about the joint and the arm from it to the centre of mass
(Landau and Lifshitz, Mechanics, section 36):

    q' = q w/2,   J w' = (J w) x w + arm x R(q)^T m g.
"""

import numpy as np

from refdem.core.engine import Method
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Trajectory
from refdem.errors import EngineError
from refdem.mechanics.quaternion import conjugate, rotated
from refdem.scene import Scene
from refdem.scene.elements.ball_joint import BallJoint
from refdem.scene.elements.uniform_gravity import UniformGravity
from refdem.solvers import _single_point as single
from refdem.solvers._kernel_solver import KernelCall, KernelSolver, samples, turning_states
from refdem.solvers._scene_pattern import ANY, ONE, ScenePattern
from refdem.solvers._single_point import Array

FITS = 1e-9
"""Relative error of the joint's position and velocity at the start that counts as rounding."""


class SpinningTop(KernelSolver):
    """Attitude and omega by Taylor series; position and velocity from them."""

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

    pattern = ScenePattern(elements={BallJoint: ONE, UniformGravity: ANY}, bodies=ONE)

    def unsupported_values(self, problem: Motion) -> str | None:
        """None for a body with inertia whose joint is on one of its principal axes and closed, else
        the reason.
        """
        scene = problem.scene
        if np.count_nonzero(scene.all(BallJoint)[0].anchor_a) > 1:
            return "the joint is not one of the world on a principal axis of the body"
        if not _about_joint(scene).all():
            return "no inertia about one of the axes through the joint"
        return _misfit(scene)

    def prepare(self, request: Request) -> KernelCall:
        """Moments about the joint, arm and weight; rows of 7 for attitude and omega in body
        axes.
        """
        scene = request.problem.scene
        t = request.problem.times
        bodies = scene.bodies
        # w = R^T omega.
        omega_body = rotated(conjugate(bodies.attitude[0]), bodies.omega[0])
        states = np.empty((len(t), 7))
        states[0] = np.concatenate([bodies.attitude[0], omega_body])
        weight = bodies.mass[0] * single.gravity(scene)
        return KernelCall(
            function="refdem_spinning_top",
            inputs=(_about_joint(scene), _arm(scene), weight),
            clock=samples(t),
            outputs=(states,),
        )

    def finish(self, request: Request, call: KernelCall, status: int) -> Trajectory:
        """Position, velocity, attitude and omega at the samples; raises EngineError if the series
        do not reach them.
        """
        if status:
            raise EngineError(
                f"spinning-top: the series do not reach sample {status - 1}; expected a motion"
                " without singularities"
            )
        scene = request.problem.scene
        (states,) = call.outputs
        attitude = states[:, :4] / np.linalg.norm(states[:, :4], axis=1, keepdims=True)
        omega = rotated(attitude, states[:, 4:])
        # r = joint + R arm, v = omega x R arm.
        arm = rotated(attitude, _arm(scene))
        columns = {
            "position": arm + single.anchor(scene.all(BallJoint)[0]),
            "velocity": np.cross(omega, arm),
            "attitude": attitude,
            "omega": omega,
        }
        return Trajectory(t=request.problem.times, **turning_states(scene.bodies, columns))


def _arm(scene: Scene) -> Array:
    """The vector (3,) [m] from the joint to the centre of mass, in body axes."""
    return -np.array(scene.all(BallJoint)[0].anchor_a)


def _about_joint(scene: Scene) -> Array:
    """Principal moments of inertia (3,) about the joint, by the parallel axis theorem: J_k + m (l^2
    - l_k^2), with the arm l along a principal axis.
    """
    arm = np.array(scene.all(BallJoint)[0].anchor_a)
    inertia: Array = scene.bodies.inertia[0] + scene.bodies.mass[0] * (arm @ arm - arm**2)
    return inertia


def _misfit(scene: Scene) -> str | None:
    """None if the joint is closed at the start, in position and velocity, else the reason."""
    bodies = scene.bodies
    joint = scene.all(BallJoint)[0]
    arm = rotated(bodies.attitude[0], -np.array(joint.anchor_a))
    arm_length = float(np.linalg.norm(arm))
    speed = float(np.linalg.norm(bodies.omega[0]))
    # |r - R arm - joint| and |v - omega x R arm|.
    gap = np.linalg.norm(bodies.position[0] - arm - single.anchor(joint))
    if gap > FITS * (arm_length + np.linalg.norm(joint.anchor_b)):
        return "the joint is open at the start"
    joint_speed = np.linalg.norm(bodies.velocity[0] - np.cross(bodies.omega[0], arm))
    if joint_speed > FITS * arm_length * speed:
        return "the joint moves at the start"
    return None


METHOD = SpinningTop()
