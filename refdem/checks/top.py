"""A body on a ball joint fixed to the world: the joint stays closed, and L_z about the vertical is
conserved; for a symmetric body also L_3, about its own axis.
"""

from collections.abc import Mapping

import numpy as np

from refdem.core.check import Check, CompletedRun, Subject
from refdem.core.finding import Finding
from refdem.core.judgement import Array, left_at_finest, worst
from refdem.core.refinement import COUNTING_FLOOR, turning
from refdem.core.trajectory import Trajectory
from refdem.core.variant import Variant
from refdem.mechanics.quaternion import conjugate, rotated
from refdem.scene import Scene
from refdem.scene.elements.ball_joint import BallJoint
from refdem.scene.elements.uniform_gravity import UniformGravity

OWN_SPIN = "spin about the own axis"
"""Name of the law L_3 = const, which no method claims.

A method that conserves angular momentum in space may turn the body about one axis after another,
which conserves L_3 only to its order.
"""

LAWS = {
    "joint": "constraint",
    "joint velocity": "constraint",
    "L_z": "angular-momentum",
    "L_3": OWN_SPIN,
}
"""The law that a method must claim for each quantity to be held to round-off."""


class Top(Check):
    """Joint and angular momenta are constant to round-off where the method claims it or is exact,
    else to its truncation error.
    """

    name = "top"
    title = "Top on its tip"
    kills = (
        "a joint that separates, a torque about the vertical or the symmetry"
        " axis, space axes used as body axes"
    )
    synchronous = True

    def applies(self, subject: Subject) -> str | None:
        """One body on one ball joint of the world, with no other element than gravity."""
        scene = subject.instance.scene
        kinds = {element.kind for element in scene.elements} - {"uniform_gravity"}
        joints = scene.all(BallJoint)
        if kinds == {"ball_joint"} and len(joints) == len(scene.bodies) == 1 and joints[0].b < 0:
            return None
        return "the scene has no top"

    def needs(self, subject: Subject) -> tuple[Variant, ...]:
        """The plain run of every level: what is held to the order must fall with it."""
        return subject.plain

    def judge(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> list[Finding]:
        """Findings on the separation of the joint in position and velocity, and on the changes of
        L_z and L_3.
        """
        at_levels = [_changes(subject, runs[variant].trajectory) for variant in subject.plain]
        terms = _terms(subject, runs[subject.finest].trajectory)
        return [
            self._constant(subject, name, [changes[name] for changes in at_levels], terms)
            for name in at_levels[0]
        ]

    def _constant(
        self, subject: Subject, name: str, changes: list[Array], terms: dict[str, float]
    ) -> Finding:
        """The finding that one quantity is constant, from its changes (T,) at every level, coarse
        to fine, and the size of the terms that are rounded, by name (`_terms`).

        The coarsest counts where the method claims the law. Elsewhere the change at the finest is
        also bounded by that at the coarsest, fallen with the claimed order.
        """
        law = LAWS[name]
        # Round-off of terms that are larger than the scale of their sum.
        of_terms = max(1.0, terms.get(name, 1.0))
        if subject.keeps(law):
            level = subject.levels[0]
            values = changes[0]
            allowed, basis = subject.kept(law, level)
        else:
            level = subject.levels[-1]
            values = changes[-1]
            allowed, basis = subject.kept(law, level)
            if len(subject.levels) > 2:
                rounding = COUNTING_FLOOR * subject.round_off(level) * of_terms
                allowed = np.minimum(allowed, left_at_finest(subject, *changes) + rounding)
                basis = (
                    f"{basis}, and truncation error extrapolated from the coarsest step with"
                    " the claimed order"
                )
        # Claim + (terms - 1) u_n; the claim includes u_n.
        allowed = allowed + (of_terms - 1.0) * subject.round_off(level)
        signal = None
        if name.startswith("L_"):
            signal = 1.0
            allowed = allowed + turning(subject.instance, subject.method, level)
        measured = "change of"
        if name.startswith("joint"):
            measured = "separation of the"
        return worst(
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


def _changes(subject: Subject, run: Trajectory) -> dict[str, Array]:
    """Separation of the joint (T,) in position and velocity, if the method can open it, and |L -
    L(0)| of L_z and L_3, each in its scale.
    """
    scene = subject.instance.scene
    scales = subject.instance.scales
    changes = {}
    if "ball_joint" not in subject.method.derived:
        place, speed = _opening(scene, run)
        changes = {"joint": place / scales.length, "joint velocity": speed / scales.speed}
    spins = _spins(scene, run)
    scale = _momentum_scale(subject, spins)
    return changes | {name: np.abs(spin - spin[0]) / scale for name, spin in spins.items()}


def _momentum_scale(subject: Subject, spins: dict[str, Array]) -> float:
    """One scale for L_z and L_3 [kg m^2/s]: the largest |L_z| or |L_3| of the run; m L V if both
    are 0.
    """
    scales = subject.instance.scales
    largest = max(float(np.max(np.abs(spin))) for spin in spins.values())
    return largest or scales.mass * scales.length * scales.speed


def _terms(subject: Subject, run: Trajectory) -> dict[str, float]:
    """Sizes of the terms of L_z and L_3, in the scale of both.

    The spin omega is rounded along every axis by u |omega|. Across the axis of a top this rounding
    is multiplied by the larger moment of inertia, although the spin there may be small:

        L_z = sum of J_i omega_i e_i + m arm x v   has terms of up to J_max |omega| + m |arm| |v|.
    """
    scene = subject.instance.scene
    joint = scene.all(BallJoint)[0]
    bodies = scene.bodies
    # L_z: (J_max |omega| + m |arm| |v|)/scale;   L_3: J_3 |omega|/scale.
    omega = float(np.max(np.linalg.norm(run.omega[:, joint.a], axis=1)))
    arm = np.linalg.norm(run.position[:, joint.a] - np.array(joint.anchor_b), axis=1)
    speed = np.linalg.norm(run.velocity[:, joint.a], axis=1)
    orbital = float(bodies.mass[joint.a] * np.max(arm * speed))
    scale = _momentum_scale(subject, _spins(scene, run))
    moments = bodies.inertia[joint.a]
    of_spin = float(moments.max()) * omega
    return {"L_z": (of_spin + orbital) / scale, "L_3": float(moments[2]) * omega / scale}


def _opening(scene: Scene, run: Trajectory) -> tuple[Array, Array]:
    """Distance (T,) [m] of the two anchors of the joint, and the speed [m/s] v + omega x arm of the
    body's anchor.
    """
    joint = scene.all(BallJoint)[0]
    # |r_a - r_b| and |v + omega x arm|, with r_b and its velocity 0 fixed to the world.
    first, second = joint.ends(run.position, run.attitude)
    anchor_velocity = run.velocity[:, joint.a] + np.cross(
        run.omega[:, joint.a], first - run.position[:, joint.a]
    )
    return np.linalg.norm(first - second, axis=1), np.linalg.norm(anchor_velocity, axis=1)


def _spins(scene: Scene, run: Trajectory) -> dict[str, Array]:
    """L_z about the vertical through the joint (T,), and L_3 about the third axis of a body that is
    symmetric about it and hangs on it.

    L = R J omega_body + m arm x v, with R the rotation from body axes to space.
    """
    joint = scene.all(BallJoint)[0]
    bodies = scene.bodies
    gravity = sum((np.array(field.g) for field in scene.all(UniformGravity)), np.zeros(3))
    if gravity.any():
        axis = gravity / np.linalg.norm(gravity)
    else:
        axis = np.array([0.0, 0.0, 1.0])
    attitude = run.attitude[:, joint.a]
    # J omega_body, in principal axes.
    spin_body = rotated(conjugate(attitude), run.omega[:, joint.a]) * bodies.inertia[joint.a]
    arm = run.position[:, joint.a] - np.array(joint.anchor_b)
    # L = R J omega_body + m arm x v,   L_z = L . axis,   L_3 = (J omega_body)_3.
    orbital = bodies.mass[joint.a] * np.cross(arm, run.velocity[:, joint.a])
    total = rotated(attitude, spin_body) + orbital
    momenta = {"L_z": total @ axis}
    is_symmetric = bodies.inertia[joint.a, 0] == bodies.inertia[joint.a, 1] and not any(
        joint.anchor_a[:2]
    )
    if is_symmetric:
        return momenta | {"L_3": spin_body[:, 2]}
    return momenta


CHECK = Top()
