"""Constraint drift: a rod has constant length, and its ends have no relative velocity along it.

With d the vector between the ends of a rod of length l, |d| = l and d . v_rel = 0.
"""

from collections.abc import Mapping

import numpy as np

from refdem.core.check import Check, CompletedRun, Subject
from refdem.core.finding import Finding
from refdem.core.judgement import Array, left_at_finest, worst
from refdem.core.refinement import COUNTING_FLOOR
from refdem.core.trajectory import Trajectory
from refdem.core.variant import Variant
from refdem.scene.elements.rod import Rod


class Constraint(Check):
    """Rod lengths are constant to round-off where the method claims it, else to truncation
    error.
    """

    name = "constraint"
    title = "Constraint drift"
    kills = (
        "a constraint solved too loosely, a rod modelled as a stiff spring,"
        " positions projected but not velocities"
    )
    synchronous = True

    def applies(self, subject: Subject) -> str | None:
        """Scenes with rods, and methods that integrate positions (those that compute them from
        angles hold every length by construction).
        """
        if subject.instance.scene.all(Rod):
            return subject.method.derived.get("rod")
        return "the scene has no constraint"

    def needs(self, subject: Subject) -> tuple[Variant, ...]:
        """The coarsest level; all of them where lengths are constant only to the order of the
        method.
        """
        if subject.keeps("constraint"):
            return (Variant(subject.levels[0]),)
        return subject.plain

    def judge(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> list[Finding]:
        """Two findings: the largest drift of length and of relative velocity along any rod."""
        variant = _judged_level(subject)
        coarsest = Variant(subject.levels[0])
        allowed, basis = subject.kept("constraint", variant.level)
        # Positions far from the origin are rounded in proportion to their distance.
        rounding = subject.round_off(variant.level) * _position_scale(subject)
        # Claim + u_n (|r|/L - 1), where the claim includes u_n.
        allowed = allowed + rounding - subject.round_off(variant.level)
        drifts = _drifts(subject, runs[variant].trajectory)
        at_levels = [_drifts(subject, runs[level].trajectory) for level in self.needs(subject)]
        findings = []
        for quantity, drift in drifts.items():
            bound = allowed
            if variant != coarsest and len(subject.levels) > 2:
                extrapolated = left_at_finest(subject, *(found[quantity] for found in at_levels))
                bound = np.minimum(allowed, extrapolated + COUNTING_FLOOR * rounding)
            drift_basis = basis
            if bound is not allowed:
                drift_basis = (
                    f"{basis}, and truncation error extrapolated from the coarsest step with the"
                    " claimed order"
                )
            findings.append(
                worst(
                    check=self.name,
                    quantity=quantity,
                    t=subject.instance.times,
                    values=drift,
                    allowed=bound,
                    unit="1",
                    basis=drift_basis,
                    what=f"The constraint drift of the rods ({quantity}), relative to its scale,",
                )
            )
        return findings


def _judged_level(subject: Subject) -> Variant:
    """The coarsest level if the method claims rod lengths to round-off (a small step hides nothing
    there), else the finest.
    """
    keeps = subject.keeps("constraint")
    if keeps:
        return Variant(subject.levels[0])
    return subject.finest


def _position_scale(subject: Subject) -> float:
    """Largest distance of a rod's end from the origin over the length scale, at least 1.

    A length is a difference of positions, so it is rounded in proportion to their size.
    """
    position, attitude = _initial_pose(subject)
    farthest = 1.0
    for rod in subject.instance.scene.all(Rod):
        for end in rod.ends(position, attitude):
            farthest = max(farthest, float(np.linalg.norm(end)) / subject.instance.scales.length)
    return farthest


def _initial_pose(subject: Subject) -> tuple[Array, Array]:
    """Initial positions (1, N, 3) and attitudes (1, N, 4)."""
    bodies = subject.instance.scene.bodies
    return bodies.position[None], bodies.attitude[None]


def _drifts(subject: Subject, run: Trajectory) -> dict[str, Array]:
    """Largest drift (T,) over all rods: | |d| - l | / L, and |d . v_rel| / |d| over the speed
    scale.

    d is the vector between the ends of a rod of length l, v_rel their relative velocity.
    """
    length = np.zeros(len(run.t))
    speed = np.zeros(len(run.t))
    for rod in subject.instance.scene.all(Rod):
        first, second = rod.ends(run.position, run.attitude)
        separation = first - second
        distance = np.linalg.norm(separation, axis=1)
        relative = run.velocity[:, rod.a]
        if rod.b >= 0:
            relative = relative - run.velocity[:, rod.b]
        # Drift of length: | |d| - l |/L.
        length = np.maximum(length, np.abs(distance - rod.length) / subject.instance.scales.length)
        # Drift of velocity: |d . v_rel|/(|d| V).
        speed = np.maximum(
            speed,
            np.abs(np.sum(separation * relative, axis=1))
            / distance
            / subject.instance.scales.speed,
        )
    return {"length": length, "velocity": speed}


CHECK = Constraint()
