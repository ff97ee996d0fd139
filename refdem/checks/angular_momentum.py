"""Angular momentum about the origin: orbital, spin and total."""

from collections.abc import Mapping

import numpy as np

from refdem.core.balance import angular, angular_scale, torque_reason
from refdem.core.check import Check, Outcome, Trial
from refdem.core.finding import Finding
from refdem.core.judgement import worst
from refdem.core.variant import Variant


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
        return torque_reason(trial.instance.scene)

    def needs(self, trial: Trial) -> tuple[Variant, ...]:
        """The coarsest level."""
        return (Variant(trial.levels[0]),)

    def judge(self, trial: Trial, runs: Mapping[Variant, Outcome]) -> list[Finding]:
        """The total; for bodies on which nothing acts also orbital and spin part by itself."""
        scene, level = trial.instance.scene, trial.levels[0]
        allowed, basis = trial.kept("angular-momentum", level)
        parts = angular(scene, runs[Variant(level)].trajectory)
        names = ["total"] if scene.elements or "rotation" not in scene.features else ["total", "orbital", "spin"]
        scale = angular_scale(trial.instance)
        return [
            worst(
                check=self.name,
                quantity=name,
                t=trial.instance.times,
                values=np.linalg.norm(parts[name] - parts[name][0], axis=1) / scale,
                allowed=allowed,
                unit="1",
                basis=basis,
                what=f"The change of {name} angular momentum, in units of the sum of m|r||v| + |J omega| at the start,",
            )
            for name in names
        ]


CHECK = AngularMomentum()
