"""Time reversal: on from the end with velocities flipped, or with negative steps, back to the start."""

from collections.abc import Mapping

import numpy as np

from refdem.core.check import Check, Outcome, Trial
from refdem.core.finding import Finding
from refdem.core.judgement import certified, judged, no_truth, undecided
from refdem.core.refinement import scored
from refdem.core.trajectory import Trajectory
from refdem.core.variant import Change, Variant
from refdem.mechanics.quaternion import angle_between


class Reversal(Check):
    """A reversible method returns to round-off; any other to its truncation error."""

    name = "reversal"
    title = "Time reversal"
    kills = "a force taken at the wrong time level, hidden dissipation, state that is not in the state"

    def applies(self, trial: Trial) -> str | None:
        """Conservative scenes and methods whose end state is complete."""
        if not trial.instance.scene.is_conservative():
            return "the scene dissipates, so time has a direction"
        if "contact:rigid" in trial.instance.scene.features:
            return "rigid contact forces at rest are not part of the state"
        return None if trial.method.complete_state else "the method's end state is not complete, so it cannot go on from there"

    def needs(self, trial: Trial) -> tuple[Variant, ...]:
        """The finest level, reversed, and backward where the method can."""
        changes: tuple[Change, ...] = ("reversed", "backward") if trial.method.backward else ("reversed",)
        return (trial.finest, *(Variant(trial.levels[-1], change) for change in changes))

    def judge(self, trial: Trial, runs: Mapping[Variant, Outcome]) -> list[Finding]:
        """The distance from the start, in units of each quantity's scale."""
        truth = certified(trial)
        if truth is None:
            return [undecided(self.name, "return", no_truth(trial))]
        level = trial.levels[-1]
        allowed = trial.bound(level)
        if scored(allowed) < len(allowed):
            return [undecided(self.name, "return", "the run ends beyond its predictability horizon, so no return can be asked for")]
        growth = float(truth.growth()[-1])
        if trial.method.reversible or trial.method.control == "exact":
            size = 2 * np.sqrt(2.0) * trial.round_off(level) * growth**2
            basis = "a reversible method returns to round-off c u sqrt(n), there and back, times the sensitivity S both ways"
        else:
            size, basis = 2 * float(allowed[-1]) * growth, "the truncation error there and back, the first amplified on the way back"
        return [
            judged(
                check=self.name,
                quantity=variant.change,
                value=_defect(trial, runs[variant].trajectory, variant.change),
                bound=size,
                unit="1",
                basis=basis,
                what=f"The distance from the start after the way back ({variant.change}), in units of each scale,",
            )
            for variant in self.needs(trial)[1:]
        ]


def _defect(trial: Trial, back: Trajectory, change: Change) -> float:
    """Largest scaled difference between the start and the state that came back."""
    start, end, scales = trial.instance.scene.bodies, back.end(), trial.instance.scales
    sign = -1.0 if change == "reversed" else 1.0
    spin = np.max(np.linalg.norm(start.omega, axis=1)) or 1.0 / scales.tau
    return max(
        float(np.max(np.abs(end["position"] - start.position))) / scales.length,
        float(np.max(np.abs(sign * end["velocity"] - start.velocity))) / scales.speed,
        float(np.max(np.abs(sign * end["omega"] - start.omega))) / float(spin),
        float(np.max(angle_between(end["attitude"], start.attitude))) if "rotation" in trial.instance.scene.features else 0.0,
    )


CHECK = Reversal()
