"""Constraint drift: rods keep their length, and their ends no relative speed along them."""

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
    """Length to round-off where the method claims it, else to its truncation error."""

    name = "constraint"
    title = "Constraint drift"
    kills = (
        "a constraint solved too loosely, a rod modelled as a stiff spring,"
        " positions projected but not velocities"
    )
    synchronous = True

    def applies(self, subject: Subject) -> str | None:
        """Scenes with rods between points, and methods that do not make places of the rods'
        angles.
        """
        if subject.instance.scene.all(Rod):
            return subject.method.derived.get("rod")
        return "the scene has no constraint"

    def needs(self, subject: Subject) -> tuple[Variant, ...]:
        """The coarsest level, and the finest where lengths are held to the order only and must fall
        with it.
        """
        return tuple(dict.fromkeys((Variant(subject.levels[0]), _judged_level(subject))))

    def judge(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> list[Finding]:
        """One finding each for the drift of length and of velocity."""
        variant = _judged_level(subject)
        coarsest = Variant(subject.levels[0])
        allowed, basis = subject.kept("constraint", variant.level)
        rounding = subject.round_off(variant.level) * _farthest(subject)
        allowed = allowed + rounding - subject.round_off(variant.level)
        drifts = _drifts(subject, runs[variant].trajectory)
        coarse = _drifts(subject, runs[coarsest].trajectory)
        found = []
        for quantity, drift in drifts.items():
            bound = allowed
            if variant != coarsest and len(subject.levels) > 2:
                bound = np.minimum(
                    allowed, left_at_finest(subject, coarse[quantity]) + COUNTING_FLOOR * rounding
                )
            reason = basis
            if bound is not allowed:
                reason = (
                    f"{basis}, and truncation error extrapolated from the coarsest step with the"
                    " claimed order"
                )
            found.append(
                worst(
                    check=self.name,
                    quantity=quantity,
                    t=subject.instance.times,
                    values=drift,
                    allowed=bound,
                    unit="1",
                    basis=reason,
                    what=f"The constraint drift of the rods ({quantity}), relative to its scale,",
                )
            )
        return found


def _judged_level(subject: Subject) -> Variant:
    """The coarsest, where nothing is hidden by a small step, if the method claims lengths to
    round-off; else the finest.
    """
    keeps = subject.method.keeps("constraint", subject.instance.problem.features)
    if keeps:
        return Variant(subject.levels[0])
    return subject.finest


def _farthest(subject: Subject) -> float:
    """How many times the scale the places are, at least 1: no state that is written in such numbers
    holds a length more exactly.
    """
    ends = [end for rod in subject.instance.scene.all(Rod) for end in rod.ends(*_start(subject))]
    return max(1.0, *(float(np.linalg.norm(end)) / subject.instance.scales.length for end in ends))


def _start(subject: Subject) -> tuple[Array, Array]:
    """Places and attitudes (1, N, 3 and 4) at the start."""
    bodies = subject.instance.scene.bodies
    return bodies.position[None], bodies.attitude[None]


def _drifts(subject: Subject, run: Trajectory) -> dict[str, Array]:
    """Largest drift (T,) of any rod: length over L, and relative speed along the rod over L/tau."""
    length = np.zeros(len(run.t))
    speed = np.zeros(len(run.t))
    for rod in subject.instance.scene.all(Rod):
        first, second = rod.ends(run.position, run.attitude)
        apart = first - second
        distance = np.linalg.norm(apart, axis=1)
        relative = run.velocity[:, rod.a]
        if rod.b >= 0:
            relative = relative - run.velocity[:, rod.b]
        length = np.maximum(length, np.abs(distance - rod.length) / subject.instance.scales.length)
        speed = np.maximum(
            speed,
            np.abs(np.sum(apart * relative, axis=1)) / distance / subject.instance.scales.speed,
        )
    return {"length": length, "velocity": speed}


CHECK = Constraint()
