"""A body on a ball joint of the world: the joint stays closed, L about the vertical stays, and L_3
if the body is symmetric.
"""

from collections.abc import Mapping

import numpy as np

from refdem.core.check import Check, CompletedRun, Subject
from refdem.core.finding import Finding
from refdem.core.judgement import Array, left_at_finest, worst
from refdem.core.refinement import COUNTING_FLOOR
from refdem.core.trajectory import Trajectory
from refdem.core.variant import Variant
from refdem.mechanics.quaternion import conjugate, rotated
from refdem.scene import Scene
from refdem.scene.elements.ball_joint import BallJoint
from refdem.scene.elements.uniform_gravity import UniformGravity

OWN_SPIN = "spin about the own axis"
"""No claim of a method: one that keeps angular momentum in space may turn the body by parts, about
one axis after another, which keeps L_3 to its order only."""


class Top(Check):
    """The quantities are conserved to round-off where the method claims it (angular momentum in
    space, constraint) or is exact, else to its truncation error.
    """

    name = "top"
    title = "Top on its tip"
    kills = (
        "a joint that separates, a torque about the vertical or the symmetry"
        " axis, space axes used as body axes"
    )
    synchronous = True

    def applies(self, subject: Subject) -> str | None:
        """One body on one ball joint of the world, and no other element than gravity."""
        scene = subject.instance.scene
        kinds = {element.kind for element in scene.elements} - {"uniform_gravity"}
        joints = scene.all(BallJoint)
        if kinds == {"ball_joint"} and len(joints) == len(scene.bodies) == 1 and joints[0].b < 0:
            return None
        return "the scene has no top"

    def needs(self, subject: Subject) -> tuple[Variant, ...]:
        """The coarsest level, and the finest for what is held to the order only."""
        return tuple(dict.fromkeys((Variant(subject.levels[0]), subject.finest)))

    def judge(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> list[Finding]:
        """Opening of the joint in place and velocity; change of L_z and L_3."""
        laws = {
            "joint": "constraint",
            "joint velocity": "constraint",
            "L_z": "angular-momentum",
            "L_3": OWN_SPIN,
        }
        coarsest = _changes(subject, runs[Variant(subject.levels[0])].trajectory)
        finest = _changes(subject, runs[subject.finest].trajectory)
        found = []
        for name, coarse in coarsest.items():
            keeps = subject.method.keeps(laws[name], subject.instance.problem.features)
            if keeps:
                level = subject.levels[0]
            else:
                level = subject.levels[-1]
            allowed, basis = subject.kept(laws[name], level)
            if not keeps and len(subject.levels) > 2:
                allowed = np.minimum(
                    allowed,
                    left_at_finest(subject, coarse) + COUNTING_FLOOR * subject.round_off(level),
                )
                basis = (
                    f"{basis}, and truncation error extrapolated from the coarsest step with"
                    " the claimed order"
                )
            values = finest[name]
            if keeps:
                values = coarse
            signal = None
            if name.startswith("L_"):
                signal = 1.0
            measured = "change of"
            if name.startswith("joint"):
                measured = "separation of the"
            found.append(
                worst(
                    check=self.name,
                    quantity=name,
                    t=subject.instance.times,
                    values=values,
                    allowed=allowed,
                    signal=signal,
                    unit="1",
                    basis=basis,
                    what=f"The {measured} {name}, relative to its scale,",
                )
            )
        return found


def _changes(subject: Subject, run: Trajectory) -> dict[str, Array]:
    """Opening of the joint (T,) in place and velocity, if the method can open it, and the change of
    L_z and L_3, each in its scale.
    """
    scene = subject.instance.scene
    size = subject.instance.scales
    found = {}
    if "ball_joint" not in subject.method.derived:
        place, speed = _opening(scene, run)
        found = {"joint": place / size.length, "joint velocity": speed / size.speed}
    spins = _spins(scene, run)
    scale = (
        max(float(np.max(np.abs(spin))) for spin in spins.values())
        or size.mass * size.length * size.speed
    )
    return found | {name: np.abs(spin - spin[0]) / scale for name, spin in spins.items()}


def _opening(scene: Scene, run: Trajectory) -> tuple[Array, Array]:
    """Distance (T,) [m] of the two anchors, and their relative speed [m/s]."""
    joint = scene.all(BallJoint)[0]
    first, second = joint.ends(run.position, run.attitude)
    moving = run.velocity[:, joint.a] + np.cross(
        run.omega[:, joint.a], first - run.position[:, joint.a]
    )
    return np.linalg.norm(first - second, axis=1), np.linalg.norm(moving, axis=1)


def _spins(scene: Scene, run: Trajectory) -> dict[str, Array]:
    """L about the vertical through the joint (T,), and about the third axis of a body that is
    symmetric about it and hangs on it.
    """
    joint = scene.all(BallJoint)[0]
    bodies = scene.bodies
    gravity = sum((np.array(field.g) for field in scene.all(UniformGravity)), np.zeros(3))
    if gravity.any():
        axis = gravity / np.linalg.norm(gravity)
    else:
        axis = np.array([0.0, 0.0, 1.0])
    attitude = run.attitude[:, joint.a]
    inner = rotated(conjugate(attitude), run.omega[:, joint.a]) * bodies.inertia[joint.a]
    arm = run.position[:, joint.a] - np.array(joint.anchor_b)
    whole = rotated(attitude, inner) + bodies.mass[joint.a] * np.cross(
        arm, run.velocity[:, joint.a]
    )
    found = {"L_z": whole @ axis}
    symmetric = bodies.inertia[joint.a, 0] == bodies.inertia[joint.a, 1] and not any(
        joint.anchor_a[:2]
    )
    if symmetric:
        return found | {"L_3": inner[:, 2]}
    return found


CHECK = Top()
