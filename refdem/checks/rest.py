"""A body at rest on which no net force acts stays at rest: |r(t) - r(0)| = 0 and |v(t)| = 0."""

from collections.abc import Mapping

import numpy as np

from refdem.core.check import Check, CompletedRun, Subject
from refdem.core.finding import Finding
from refdem.core.judgement import certified, moves, no_truth, undecided, worst
from refdem.core.variant import Variant


class Rest(Check):
    """No displacement and no speed at the finest level, which has the most steps to creep in."""

    name = "rest"
    title = "Rest stays rest"
    kills = "sgn(0) = 0 in a friction law, a contact that sinks or jitters, unbalanced gravity"

    def applies(self, subject: Subject) -> str | None:
        """Scenes that start at rest and, as far as truth is certified, stay there."""
        bodies = subject.instance.scene.bodies
        if np.any(bodies.velocity) or np.any(bodies.omega):
            return "some body moves initially"
        if subject.truth is not None and moves(subject.truth):
            return "the case does not stay at rest"
        return None

    def needs(self, subject: Subject) -> tuple[Variant, ...]:
        """The plain run at the finest level."""
        return (subject.finest,)

    def judge(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> list[Finding]:
        """Two findings: the largest displacement and the largest speed of any body."""
        if certified(subject) is None:
            return [undecided(self.name, "rest", no_truth(subject))]
        run = runs[subject.finest].trajectory
        scales = subject.instance.scales
        # max over bodies of |r(t) - r(0)|/L and of |v(t)|/V.
        moved = run.position - subject.instance.scene.bodies.position
        displacement = np.linalg.norm(moved, axis=-1).max(axis=1)
        # The mean speed of creep over the second half, for the finding's sentence.
        half = len(displacement) // 2
        creep = (displacement[-1] - displacement[half]) / abs(run.t[-1] - run.t[half])
        measured = {
            "displacement": displacement / scales.length,
            "speed": np.linalg.norm(run.velocity, axis=-1).max(axis=1) / scales.speed,
        }
        return [
            worst(
                check=self.name,
                quantity=name,
                t=subject.instance.times,
                values=values,
                allowed=subject.round_off(subject.levels[-1]),
                unit="1",
                basis="a body at rest stays at rest at any step, to round-off c u sqrt(n)",
                what=(
                    f"The largest {name} of any body (mean creep over the second half"
                    f" {creep:.2g} m/s), relative to its scale,"
                ),
            )
            for name, values in measured.items()
        ]


CHECK = Rest()
