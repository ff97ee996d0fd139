"""Angular momentum about the origin: orbital, spin and total; where a contact law itself changes
it, against truth.
"""

from collections.abc import Mapping

import numpy as np

from refdem.core.balance import angular, angular_scale, torque_reason
from refdem.core.check import Check, CompletedRun, Subject
from refdem.core.finding import Finding
from refdem.core.judgement import Array, certified, left_at_finest, no_truth, undecided, worst
from refdem.core.refinement import COUNTING_FLOOR, sweeping, turning
from refdem.core.trajectory import Trajectory
from refdem.core.truth import SampledTruth
from refdem.core.variant import Variant
from refdem.scene import Scene
from refdem.scene.elements.contact import Contact


class AngularMomentum(Check):
    """Constant to round-off where the method claims it, else to its truncation error."""

    name = "angular-momentum"
    title = "Angular momentum"
    kills = "a wrong lever arm, a missing torque, body axes used as space axes"
    synchronous = True

    def applies(self, subject: Subject) -> str | None:
        """Scenes in which something can turn and no torque about the origin acts from outside."""
        if {"dimension:1"} == subject.instance.scene.features & {"dimension:1", "rotation"}:
            return "all motion is along one line through the origin"
        if _law_turns(subject):
            return None
        return torque_reason(subject.instance.scene)

    def needs(self, subject: Subject) -> tuple[Variant, ...]:
        """The coarsest level, where it is kept to round-off; the finest, where it is compared with
        truth; both, where it must fall.
        """
        if _law_turns(subject):
            return (subject.finest,)
        return tuple(dict.fromkeys((Variant(subject.levels[0]), _judged_level(subject))))

    def judge(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> list[Finding]:
        """The total; for bodies on which nothing acts also orbital and spin part by itself."""
        if _law_turns(subject):
            return [self._against_truth(subject, runs[subject.finest].trajectory)]
        return [self._kept(subject, runs, name) for name in _parts(subject.instance.scene)]

    def _kept(self, subject: Subject, runs: Mapping[Variant, CompletedRun], name: str) -> Finding:
        """One part, at the coarsest level if it is held to round-off, else at the finest."""
        free = name == "orbital"
        if free:
            variant = Variant(subject.levels[0])
        else:
            variant = _judged_level(subject)
        allowed: Array | float
        if free:
            allowed = subject.noise(variant.level)
            moved = "nothing acts on the bodies, and every method integrates free motion exactly"
            basis = f"{moved}: only round-off, c u sqrt(n) plus u n for equal terms, may change it"
        else:
            allowed, basis = subject.kept("angular-momentum", variant.level)
            sweeps = subject.round_off(variant.level) * (
                sweeping(subject.instance, subject.method) - 1.0
            )
            allowed = allowed + sweeps + turning(subject.instance, subject.method, variant.level)
        if variant != Variant(subject.levels[0]) and len(subject.levels) > 2:
            coarse = self._changes(subject, runs[Variant(subject.levels[0])], name)
            rounding = subject.round_off(variant.level) + turning(
                subject.instance, subject.method, variant.level
            )
            fallen = left_at_finest(subject, coarse) + COUNTING_FLOOR * rounding
            if np.any(fallen < allowed):
                basis = (
                    "truncation error extrapolated from the coarsest step with the claimed order"
                )
            allowed = np.minimum(allowed, fallen)
        size = float(
            np.linalg.norm(angular(subject.instance.scene, runs[variant].trajectory)[name][0])
        )
        return worst(
            check=self.name,
            quantity=name,
            t=subject.instance.times,
            values=self._changes(subject, runs[variant], name),
            allowed=allowed,
            signal=size / angular_scale(subject.instance),
            unit="1",
            basis=basis,
            what=(
                f"The change of {name} angular momentum, relative to the initial sum of"
                " m|r||v| + |J omega|,"
            ),
        )

    def _changes(self, subject: Subject, run: CompletedRun, name: str) -> Array:
        """The change of one part since the start (T,), in units of the scale."""
        part = angular(subject.instance.scene, run.trajectory)[name]
        changes: Array = np.linalg.norm(part - part[0], axis=1) / angular_scale(subject.instance)
        return changes

    def _against_truth(self, subject: Subject, run: Trajectory) -> Finding:
        """Levers that do not sum to the centre distance change the total by the integral of overlap
        times friction: that of truth.
        """
        truth = certified(subject)
        scene = subject.instance.scene
        level = subject.levels[-1]
        if truth is None:
            return undecided(self.name, "law", no_truth(subject))
        found = angular(scene, run)["total"][: truth.until]
        expected = angular(scene, _as_trajectory(truth))["total"]
        sizes = {name: subject.instance.quantities[f"{name}1.x"].scale for name in KINDS}
        place = np.linalg.norm(scene.bodies.position, axis=1)
        speed = np.linalg.norm(scene.bodies.velocity, axis=1)
        spun = scene.bodies.inertia.max(axis=1).sum() * sizes["omega"]
        share = (
            scene.bodies.mass @ (place * sizes["v"] + speed * sizes["r"]) + spun
        ) / angular_scale(subject.instance)
        return worst(
            check=self.name,
            quantity="law",
            t=subject.instance.times[: truth.until],
            values=np.linalg.norm(found - expected, axis=1) / angular_scale(subject.instance),
            allowed=float(share) * subject.bound(level),
            unit="1",
            basis=(
                "error bounds on position, velocity and angular velocity, propagated to"
                " angular momentum"
            ),
            what=(
                "The error of total angular momentum (its true change is the time"
                " integral of overlap times friction),"
            ),
        )


KINDS = ("r", "v", "omega")


def _parts(scene: Scene) -> tuple[str, ...]:
    """The total; of bodies on which nothing acts the orbital and the spin part by themselves
    too.
    """
    if scene.elements or "rotation" not in scene.features:
        return ("total",)
    return ("total", "orbital", "spin")


def _judged_level(subject: Subject) -> Variant:
    """The coarsest, where nothing is hidden by a small step, if the method claims it to round-off;
    else the finest.
    """
    keeps = subject.method.keeps("angular-momentum", subject.instance.problem.features)
    if keeps:
        return Variant(subject.levels[0])
    return subject.finest


def _law_turns(subject: Subject) -> bool:
    """Two spheres under a law that changes their total angular momentum, and a case that says where
    they are.
    """
    laws = subject.instance.scene.all(Contact)
    known = all(
        f"{kind}{body}.{axis}" in subject.instance.quantities
        for kind in KINDS
        for body in (1, 2)
        for axis in "xyz"
    )
    return (
        known
        and len(subject.instance.scene.elements) == 1
        and any(law.friction > 0 and law.branch != "R-d/2" for law in laws)
    )


def _as_trajectory(truth: SampledTruth) -> Trajectory:
    """The certified states of two spheres; their attitudes make no difference."""

    def vector(kind: str, body: int) -> Array:
        components = [truth.value(f"{kind}{body}.{axis}") for axis in "xyz"]
        return np.stack(components, axis=-1)

    # Columns (T, 2, 3), as trajectories have them.
    r, v, omega = (np.stack([vector(kind, 1), vector(kind, 2)], axis=1) for kind in KINDS)
    attitude = np.zeros((truth.until, 2, 4))
    attitude[..., 0] = 1.0
    return Trajectory(
        t=np.array(truth.t[: truth.until]), position=r, velocity=v, attitude=attitude, omega=omega
    )


CHECK = AngularMomentum()
