"""Momentum of an isolated scene: action equals reaction, whatever the step."""

from collections.abc import Mapping

import numpy as np

from refdem.core.balance import linear, momentum_scale
from refdem.core.check import Array, Check, Outcome, Trial
from refdem.core.finding import Finding
from refdem.core.judgement import worst
from refdem.core.refinement import sweeping
from refdem.core.trajectory import Trajectory
from refdem.core.variant import Variant


class Momentum(Check):
    """Constant to round-off at the coarsest level, where nothing is hidden by a small step."""

    name = "momentum"
    title = "Momentum"
    kills = (
        "a contact force applied to one body only, a lost mass, a velocity mixed up between bodies"
    )

    def applies(self, trial: Trial) -> str | None:
        """Isolated scenes."""
        if trial.instance.scene.is_isolated():
            return None
        return "something acts from outside, so momentum is not kept"

    def needs(self, trial: Trial) -> tuple[Variant, ...]:
        """The coarsest level."""
        return (Variant(trial.levels[0]),)

    def judge(self, trial: Trial, runs: Mapping[Variant, Outcome]) -> list[Finding]:
        """The largest change of the vector."""
        level = trial.levels[0]
        run = runs[Variant(level)].trajectory
        total = linear(trial.instance.scene, run)
        return [
            worst(
                check=self.name,
                quantity="total",
                t=trial.instance.times,
                values=np.linalg.norm(total - total[0], axis=1) / momentum_scale(trial.instance),
                allowed=trial.round_off(level) * sweeping(trial.instance, trial.method),
                signal=_exchanged(trial, run),
                unit="1",
                basis=(
                    "action equals reaction at every step, so only round-off c u sqrt(n) may"
                    " change it"
                ),
                what="The change of total momentum, in units of the sum of m|v| at the start,",
            )
        ]


def _exchanged(trial: Trial, run: Trajectory) -> Array:
    """The largest change of any body's momentum since the start (T,), in units of the sum of m|v|:
    what action and reaction balance.
    """
    change = trial.instance.scene.bodies.mass[:, None] * (run.velocity - run.velocity[0])
    largest: Array = np.linalg.norm(change, axis=-1).max(axis=1) / momentum_scale(trial.instance)
    rounding = trial.round_off(trial.levels[0])
    if np.any(largest > rounding):
        return largest
    return np.zeros_like(largest)


CHECK = Momentum()
