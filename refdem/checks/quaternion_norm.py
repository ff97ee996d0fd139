"""Attitudes are unit quaternions: |q| = 1."""

from collections.abc import Mapping

import numpy as np

from refdem.core.check import Check, CompletedRun, Subject
from refdem.core.finding import Finding
from refdem.core.judgement import worst
from refdem.core.variant import Variant


class QuaternionNorm(Check):
    """|q| = 1 to round-off at every sample of the coarsest level."""

    name = "quaternion-norm"
    title = "Quaternion norm"
    kills = "an attitude quaternion that is integrated and never normalised"

    def applies(self, subject: Subject) -> str | None:
        """Scenes with rotation, and methods whose attitudes are not unit quaternions by
        construction.
        """
        if "rotation" not in subject.instance.scene.features:
            return "no body rotates"
        return subject.method.derived.get("attitude")

    def needs(self, subject: Subject) -> tuple[Variant, ...]:
        """The plain run at the coarsest level."""
        return (Variant(subject.levels[0]),)

    def judge(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> list[Finding]:
        """One finding: the largest | |q| - 1 | of any body."""
        level = subject.levels[0]
        norm = np.linalg.norm(runs[Variant(level)].trajectory.attitude, axis=-1)
        return [
            worst(
                check=self.name,
                quantity="norm",
                t=subject.instance.times,
                values=np.abs(norm - 1).max(axis=1),
                allowed=subject.round_off(level),
                unit="1",
                basis="an attitude is a unit quaternion at every step, to round-off c u sqrt(n)",
                what="The largest deviation of |q| from 1",
            )
        ]


CHECK = QuaternionNorm()
