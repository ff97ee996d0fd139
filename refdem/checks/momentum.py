"""Momentum of an isolated scene is constant, since action equals reaction at every step."""

from collections.abc import Mapping

import numpy as np

from refdem.core.balance import linear, momentum_scale
from refdem.core.check import Array, Check, CompletedRun, Subject
from refdem.core.finding import Finding
from refdem.core.judgement import worst
from refdem.core.refinement import sweeping
from refdem.core.trajectory import Trajectory
from refdem.core.variant import Variant


class Momentum(Check):
    """Total momentum is constant to round-off at the coarsest level, where a small step hides
    nothing.
    """

    name = "momentum"
    title = "Momentum"
    kills = (
        "a contact force applied to one body only, a lost mass, velocities exchanged between bodies"
    )

    def applies(self, subject: Subject) -> str | None:
        """None for isolated scenes, else the reason why not."""
        if subject.instance.scene.is_isolated():
            return None
        return "an external force acts, so momentum is not conserved"

    def needs(self, subject: Subject) -> tuple[Variant, ...]:
        """The plain run at the coarsest level."""
        return (Variant(subject.levels[0]),)

    def judge(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> list[Finding]:
        """One finding: the largest change of total momentum, in units of the initial sum of m
        |v|.
        """
        level = subject.levels[0]
        run = runs[Variant(level)].trajectory
        total = linear(subject.instance.scene, run)
        change = np.linalg.norm(total - total[0], axis=1)
        return [
            worst(
                check=self.name,
                quantity="total",
                t=subject.instance.times,
                values=change / momentum_scale(subject.instance),
                allowed=subject.round_off(level) * sweeping(subject.instance, subject.method),
                signal=_exchanged(subject, run),
                unit="1",
                basis=(
                    "action equals reaction at every step, so only round-off, c u sqrt(n),"
                    " may change momentum"
                ),
                what="The change of total momentum, relative to the initial sum of m|v|,",
            )
        ]


def _exchanged(subject: Subject, run: Trajectory) -> Array:
    """The largest change of any body's momentum since the start (T,), in units of the initial sum
    of m |v|; 0 if all of it is round-off.

    It is the signal: the momentum that action and reaction exchange.
    """
    change = subject.instance.scene.bodies.mass[:, None] * (run.velocity - run.velocity[0])
    largest: Array = np.linalg.norm(change, axis=-1).max(axis=1) / momentum_scale(subject.instance)
    rounding = subject.round_off(subject.levels[0])
    if np.any(largest > rounding):
        return largest
    return np.zeros_like(largest)


CHECK = Momentum()
