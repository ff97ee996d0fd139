"""Angular momentum about the origin: orbital sum m r x v, spin sum J omega, and their total.

Where the contact law itself changes the total, because its lever arms do not add up to the distance
of the centres, the total is compared with truth.
"""

from collections.abc import Mapping

import numpy as np
from msgspec import structs

from refdem.core.balance import angular, angular_scale, torque_reason
from refdem.core.check import Check, CompletedRun, Subject
from refdem.core.finding import Finding
from refdem.core.judgement import Array, certified, left_at_finest, no_truth, undecided, worst
from refdem.core.refinement import COUNTING_FLOOR, flight, sweeping, turning
from refdem.core.trajectory import Trajectory
from refdem.core.truth import SampledTruth
from refdem.core.variant import Variant
from refdem.scene import Scene
from refdem.scene.elements.contact import Contact


class AngularMomentum(Check):
    """Angular momentum is constant to round-off where the method claims it, else to truncation
    error.
    """

    name = "angular-momentum"
    title = "Angular momentum"
    kills = "a wrong lever arm, a missing torque, body axes used as space axes"
    synchronous = True

    def applies(self, subject: Subject) -> str | None:
        """Scenes in which something can turn and no external torque about the origin acts."""
        if {"dimension:1"} == subject.instance.scene.features & {"dimension:1", "rotation"}:
            return "all motion is along one line through the origin"
        if _law_changes_total(subject):
            return None
        return torque_reason(subject.instance.scene)

    def needs(self, subject: Subject) -> tuple[Variant, ...]:
        """The coarsest level where the method claims L to round-off; the finest where L is compared
        with truth; all levels where the error of L must fall with the step.
        """
        if _law_changes_total(subject):
            return (subject.finest,)
        if subject.keeps("angular-momentum"):
            return (Variant(subject.levels[0]),)
        return subject.plain

    def judge(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> list[Finding]:
        """One finding for the total; where no element acts, also one each for orbital and spin
        part.
        """
        if _law_changes_total(subject):
            return [self._against_truth(subject, runs[subject.finest].trajectory)]
        return [
            self._kept(subject, runs, name) for name in _conserved_parts(subject.instance.scene)
        ]

    def _kept(self, subject: Subject, runs: Mapping[Variant, CompletedRun], name: str) -> Finding:
        """The finding that one part, `name`, is constant: at the coarsest level to round-off, else
        at the finest.

        The orbital part of free motion is constant for every method, except for round-off.
        Elsewhere the bound is that of the method's claim. At the finest level it is also at most
        what the change at the coarsest level implies with the claimed order.

        With the round-off u_n = c u sqrt(n), the factor f of a neighbour search (`sweeping`), the
        rounding e of equal terms (`_equal_roundings`) and the growth g of the terms (`_spread`),

            |L(t) - L(0)|/L_s <= claim + (f - 1) u_n + e + (g - 1) (u_n + e),

        where L_s is the initial sum of m |r| |v| + |J omega|.
        """
        is_free_motion = name == "orbital"
        if is_free_motion:
            variant = Variant(subject.levels[0])
        else:
            variant = _judged_level(subject)
        allowed: Array | float
        if is_free_motion:
            allowed = subject.noise(variant.level)
            reason = "nothing acts on the bodies, and every method integrates free motion exactly"
            basis = f"{reason}: only round-off, c u sqrt(n) plus u n for equal terms, may change it"
        else:
            allowed, basis = subject.kept("angular-momentum", variant.level)
            # (f - 1) u_n.
            sweep_rounding = subject.round_off(variant.level) * (
                sweeping(subject.instance, subject.method) - 1.0
            )
            equal_roundings = _equal_roundings(subject, variant.level)
            # (g - 1) (u_n + e).
            rounding_at_start = subject.round_off(variant.level) + equal_roundings
            spread = _spread(subject, runs[variant].trajectory)
            of_later_terms = (spread - 1.0) * rounding_at_start
            allowed = allowed + sweep_rounding + equal_roundings + of_later_terms
        if variant != Variant(subject.levels[0]) and len(subject.levels) > 2:
            changes = [self._changes(subject, runs[level], name) for level in subject.plain]
            rounding = subject.round_off(variant.level) + _equal_roundings(subject, variant.level)
            spread = _spread(subject, runs[variant].trajectory)
            # Prediction of order p from coarser levels, plus COUNTING_FLOOR (u_n + e) g.
            extrapolated = left_at_finest(subject, *changes) + COUNTING_FLOOR * rounding * spread
            if np.any(extrapolated < allowed):
                basis = (
                    "truncation error extrapolated from the coarsest step with the claimed order"
                )
            allowed = np.minimum(allowed, extrapolated)
        initial = float(
            np.linalg.norm(angular(subject.instance.scene, runs[variant].trajectory)[name][0])
        )
        finding = worst(
            check=self.name,
            quantity=name,
            t=subject.instance.times,
            values=self._changes(subject, runs[variant], name),
            allowed=allowed,
            signal=initial / angular_scale(subject.instance),
            unit="1",
            basis=basis,
            what=(
                f"The change of {name} angular momentum, relative to the initial sum of"
                " m|r||v| + |J omega|,"
            ),
        )
        return with_remark(finding, self._change_remark(subject, runs, name))

    def _change_remark(
        self, subject: Subject, runs: Mapping[Variant, CompletedRun], name: str
    ) -> str:
        """The remark for a method that does not claim to conserve L: by how much L changes at the
        coarsest and the finest step, although no external torque acts; "" if that is round-off.
        """
        coarsest = Variant(subject.levels[0])
        if coarsest == subject.finest or not {coarsest, subject.finest} <= set(runs):
            return ""
        rounding = subject.round_off(subject.levels[-1]) + _equal_roundings(
            subject, subject.levels[-1]
        )
        at_coarsest = float(self._changes(subject, runs[coarsest], name).max())
        at_finest = float(self._changes(subject, runs[subject.finest], name).max())
        if not at_finest > COUNTING_FLOOR * rounding:
            return ""
        return (
            f"No torque acts from outside, and yet it changes by {at_coarsest:.2g} at"
            f" {_level_words(subject, subject.levels[0])} and by {at_finest:.2g} at"
            f" {_level_words(subject, subject.levels[-1])}; the method does not claim to keep it."
        )

    def _changes(self, subject: Subject, run: CompletedRun, name: str) -> Array:
        """|L(t) - L(0)| of one part (T,), in units of the initial sum of m |r| |v| + |J omega|."""
        # |L(t) - L(0)|/L_s.
        part = angular(subject.instance.scene, run.trajectory)[name]
        changes: Array = np.linalg.norm(part - part[0], axis=1) / angular_scale(subject.instance)
        return changes

    def _against_truth(self, subject: Subject, run: Trajectory) -> Finding:
        """The finding that total angular momentum follows truth, where the contact law changes it.

        Lever arms R - d of two spheres that touch do not add up to the centre distance, so the
        total changes by the time integral of overlap times friction. An error E of the state, in
        units of the scales of r, v and omega, changes it by at most E times sum m (|r| v_scale +
        |v| r_scale) + J omega_scale.
        """
        truth = certified(subject)
        scene = subject.instance.scene
        level = subject.levels[-1]
        if truth is None:
            return undecided(self.name, "law", no_truth(subject))
        measured = angular(scene, run)["total"][: truth.until]
        expected = angular(scene, _as_trajectory(truth, len(scene.bodies)))["total"]
        scales = {name: subject.instance.quantities[f"{name}1.x"].scale for name in KINDS}
        distance = np.linalg.norm(scene.bodies.position, axis=1)
        speed = np.linalg.norm(scene.bodies.velocity, axis=1)
        # |dL| <= sum m (|r| dv + |v| dr) + J domega for errors of one scale of each quantity.
        spin_error = scene.bodies.inertia.max(axis=1).sum() * scales["omega"]
        orbital_error = scene.bodies.mass @ (distance * scales["v"] + speed * scales["r"])
        sensitivity = (orbital_error + spin_error) / angular_scale(subject.instance)
        # Largest |L(t) - L(0)|/L_s of truth: the change by the law itself.
        true_changes = np.linalg.norm(expected - expected[0], axis=1)
        by_law = float(true_changes.max()) / angular_scale(subject.instance)
        finding = worst(
            check=self.name,
            quantity="law",
            t=subject.instance.times[: truth.until],
            values=np.linalg.norm(measured - expected, axis=1) / angular_scale(subject.instance),
            allowed=float(sensitivity) * subject.bound(level),
            unit="1",
            basis=(
                "error bounds on position, velocity and angular velocity, propagated to"
                " angular momentum"
            ),
            what=(
                "The error of total angular momentum, whose true change is the time integral of"
                " overlap times friction,"
            ),
        )
        if not by_law > subject.round_off(level):
            return finding
        return with_remark(
            finding,
            f"The law itself changes it by {by_law:.2g}, because the sum of its lever arms differs"
            " from the distance of the centres: a property of the law, not of the method.",
        )


def with_remark(finding: Finding, remark: str) -> Finding:
    """The finding with a remark after its sentence; the same finding for an empty remark."""
    if not remark:
        return finding
    return structs.replace(finding, sentence=f"{finding.sentence} {remark}")


def _level_words(subject: Subject, level: float) -> str:
    """A level of refinement in words: a step with its unit, or a tolerance."""
    if subject.method.control == "step":
        return f"a step of {level:.2g} s"
    return f"a tolerance of {level:.2g}"


KINDS = ("r", "v", "omega")
"""Prefixes of the names of the truth's quantities: r1.x, v2.y, omega1.z, ..."""


def _equal_roundings(subject: Subject, level: float) -> float:
    """Relative round-off of L that adds up in proportion to the number of steps.

    A rotation that is repeated has the same rounding error at every step. The positions r of a body
    in flight, before and after a contact, are sums of equal terms h v, which have the same rounding
    error too, and r x v has it with them.
    """
    turned = turning(subject.instance, subject.method, level)
    flown = flight(subject.instance, subject.method, level)
    return turned + flown


def _spread(subject: Subject, run: Trajectory) -> Array:
    """The largest sum of m |r| |v| + |J omega| up to each sample (T,), in units of that of the
    start; 1 at least.

    L is a sum of these terms and is rounded on their scale: bodies that were hit from rest and fly
    apart have larger ones than the one that hit them had.
    """
    bodies = subject.instance.scene.bodies
    distance = np.linalg.norm(run.position, axis=-1)
    speed = np.linalg.norm(run.velocity, axis=-1)
    turning_rate = np.linalg.norm(run.omega, axis=-1)
    # max over s <= t of sum_i (m_i |r_i| |v_i| + max_k J_k |omega_i|)(s) / L_s.
    terms = (distance * speed) @ bodies.mass + turning_rate @ bodies.inertia.max(axis=1)
    largest: Array = np.maximum.accumulate(terms) / angular_scale(subject.instance)
    return np.maximum(1.0, largest)


def _conserved_parts(scene: Scene) -> tuple[str, ...]:
    """Names of the parts that are conserved: the total; where no element acts, also each part by
    itself.
    """
    if scene.elements or "rotation" not in scene.features:
        return ("total",)
    return ("total", "orbital", "spin")


def _judged_level(subject: Subject) -> Variant:
    """The coarsest level if the method claims conservation to round-off (a small step hides nothing
    there), else the finest.
    """
    if subject.keeps("angular-momentum"):
        return Variant(subject.levels[0])
    return subject.finest


def _law_changes_total(subject: Subject) -> bool:
    """True for spheres whose contact law changes total angular momentum, in a case that has truth
    for r, v, omega of all of them.

    The torques of friction have lever arms that add up to the centre distance only for R - d/2.
    """
    laws = subject.instance.scene.all(Contact)
    known = all(
        f"{kind}{body}.{axis}" in subject.instance.quantities
        for kind in KINDS
        for body in range(1, len(subject.instance.scene.bodies) + 1)
        for axis in "xyz"
    )
    return (
        known
        and len(subject.instance.scene.elements) == 1
        and any(law.friction > 0 and law.torque_shortening != 0.5 for law in laws)
    )


def _as_trajectory(truth: SampledTruth, count: int) -> Trajectory:
    """The certified states of `count` spheres as a trajectory; attitudes, which L does not depend
    on, are 1.
    """

    def vector(kind: str, body: int) -> Array:
        components = [truth.value(f"{kind}{body}.{axis}") for axis in "xyz"]
        return np.stack(components, axis=-1)

    # Columns (T, N, 3), as trajectories have them.
    numbers = range(1, count + 1)
    r, v, omega = (np.stack([vector(kind, body) for body in numbers], axis=1) for kind in KINDS)
    attitude = np.zeros((truth.until, count, 4))
    attitude[..., 0] = 1.0
    return Trajectory(
        t=np.array(truth.t[: truth.until]), position=r, velocity=v, attitude=attitude, omega=omega
    )


CHECK = AngularMomentum()
