"""Angular momentum about the origin: orbital, spin and total; where a contact law itself changes it, against truth."""

from collections.abc import Mapping

import numpy as np

from refdem.core.balance import angular, angular_scale, torque_reason
from refdem.core.check import Check, Outcome, Trial
from refdem.core.finding import Finding
from refdem.core.judgement import Array, certified, no_truth, undecided, worst
from refdem.core.refinement import sweeping
from refdem.core.trajectory import Trajectory
from refdem.core.truth import SampledTruth
from refdem.core.variant import Variant
from refdem.scene.elements.contact import Contact


class AngularMomentum(Check):
    """Constant to round-off where the method claims it, else to its truncation error."""

    name = "angular-momentum"
    title = "Angular momentum"
    kills = "a wrong lever arm, a torque left out, body axes taken for space axes"
    synchronous = True

    def applies(self, trial: Trial) -> str | None:
        """Scenes in which something can turn and no torque about the origin acts from outside."""
        if {"dimension:1"} == trial.instance.scene.features & {"dimension:1", "rotation"}:
            return "all motion is along one line through the origin"
        return None if _law_turns(trial) else torque_reason(trial.instance.scene)

    def needs(self, trial: Trial) -> tuple[Variant, ...]:
        """The coarsest level, where it is kept; the finest, where it is compared with truth."""
        return (trial.finest if _law_turns(trial) else Variant(trial.levels[0]),)

    def judge(self, trial: Trial, runs: Mapping[Variant, Outcome]) -> list[Finding]:
        """The total; for bodies on which nothing acts also orbital and spin part by itself."""
        if _law_turns(trial):
            return [self._against_truth(trial, runs[trial.finest].trajectory)]
        scene, level = trial.instance.scene, trial.levels[0]
        allowed, basis = trial.kept("angular-momentum", level)
        allowed = allowed + trial.round_off(level) * (sweeping(trial.instance, trial.method) - 1.0)
        parts = angular(scene, runs[Variant(level)].trajectory)
        names = ["total"] if scene.elements or "rotation" not in scene.features else ["total", "orbital", "spin"]
        scale = angular_scale(trial.instance)
        straight = (
            trial.round_off(level),
            "nothing acts, and every method moves on in a straight line, so only round-off c u sqrt(n) may change it",
        )
        kept: dict[str, tuple[Array | float, str]] = {"total": (allowed, basis), "orbital": straight, "spin": (allowed, basis)}
        return [
            worst(
                check=self.name,
                quantity=name,
                t=trial.instance.times,
                values=np.linalg.norm(parts[name] - parts[name][0], axis=1) / scale,
                allowed=kept[name][0],
                unit="1",
                basis=kept[name][1],
                what=f"The change of {name} angular momentum, in units of the sum of m|r||v| + |J omega| at the start,",
            )
            for name in names
        ]

    def _against_truth(self, trial: Trial, run: Trajectory) -> Finding:
        """Levers that do not sum to the centre distance change the total by the integral of overlap times friction: that of truth."""
        truth, scene, level = certified(trial), trial.instance.scene, trial.levels[-1]
        if truth is None:
            return undecided(self.name, "law", no_truth(trial))
        found, expected = angular(scene, run)["total"][: truth.until], angular(scene, _as_trajectory(truth))["total"]
        sizes = {name: trial.instance.quantities[f"{name}1.x"].scale for name in KINDS}
        place, speed = (np.linalg.norm(scene.bodies.position, axis=1), np.linalg.norm(scene.bodies.velocity, axis=1))
        spun = scene.bodies.inertia.max(axis=1).sum() * sizes["omega"]
        share = (scene.bodies.mass @ (place * sizes["v"] + speed * sizes["r"]) + spun) / angular_scale(trial.instance)
        return worst(
            check=self.name,
            quantity="law",
            t=trial.instance.times[: truth.until],
            values=np.linalg.norm(found - expected, axis=1) / angular_scale(trial.instance),
            allowed=float(share) * trial.bound(level),
            unit="1",
            basis="the bounds on places, velocities and spins, each in units of the sum of m|r||v| + |J omega| at the start",
            what="The total angular momentum against truth, which the law changes by the integral of overlap times friction,",
        )


KINDS = ("r", "v", "omega")


def _law_turns(trial: Trial) -> bool:
    """Two spheres under a law that changes their total angular momentum, and a case that says where they are."""
    laws = trial.instance.scene.all(Contact)
    known = all(f"{kind}{body}.{axis}" in trial.instance.quantities for kind in KINDS for body in (1, 2) for axis in "xyz")
    return known and len(trial.instance.scene.elements) == 1 and any(law.friction > 0 and law.branch != "R-d/2" for law in laws)


def _as_trajectory(truth: SampledTruth) -> Trajectory:
    """The certified states of two spheres; their attitudes make no difference."""
    r, v, omega = (
        np.stack([np.stack([truth.value(f"{kind}{body}.{axis}") for axis in "xyz"], axis=-1) for body in (1, 2)], axis=1) for kind in KINDS
    )
    attitude = np.zeros((truth.until, 2, 4))
    attitude[..., 0] = 1.0
    return Trajectory(t=np.array(truth.t[: truth.until]), position=r, velocity=v, attitude=attitude, omega=omega)


CHECK = AngularMomentum()
