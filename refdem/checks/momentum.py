"""Momentum of an isolated scene: action equals reaction, whatever the step."""

from collections.abc import Mapping

import numpy as np

from refdem.core.balance import linear, momentum_scale
from refdem.core.check import Check, Outcome, Trial
from refdem.core.finding import Finding
from refdem.core.judgement import worst
from refdem.core.refinement import sweeping
from refdem.core.variant import Variant


class Momentum(Check):
    """Constant to round-off at the coarsest level, where nothing is hidden by a small step."""

    name = "momentum"
    title = "Momentum"
    kills = "a contact force applied to one body only, a lost mass, a velocity mixed up between bodies"

    def applies(self, trial: Trial) -> str | None:
        """Isolated scenes."""
        return None if trial.instance.scene.is_isolated() else "something acts from outside, so momentum is not kept"

    def needs(self, trial: Trial) -> tuple[Variant, ...]:
        """The coarsest level."""
        return (Variant(trial.levels[0]),)

    def judge(self, trial: Trial, runs: Mapping[Variant, Outcome]) -> list[Finding]:
        """The largest change of the vector."""
        level = trial.levels[0]
        total = linear(trial.instance.scene, runs[Variant(level)].trajectory)
        return [
            worst(
                check=self.name,
                quantity="total",
                t=trial.instance.times,
                values=np.linalg.norm(total - total[0], axis=1) / momentum_scale(trial.instance),
                allowed=trial.round_off(level) * sweeping(trial.instance, trial.method),
                unit="1",
                basis="action equals reaction at every step, so only round-off c u sqrt(n) may change it",
                what="The change of total momentum, in units of the sum of m|v| at the start,",
            )
        ]


CHECK = Momentum()
