"""Steps up to and beyond the stability limit: many steps must stay bounded."""

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction

from refdem.core import stability
from refdem.core.case import Instance
from refdem.core.check import Check, CompletedRun, Subject
from refdem.core.finding import Finding
from refdem.core.judgement import judged
from refdem.core.problem import Motion
from refdem.core.variant import Variant
from refdem.stress.measures.fixed_step import FixedStep


@dataclass(frozen=True)
class StepLimit(FixedStep):
    """The point is the step in units of 2/omega = 2 tau, the stability limit of Verlet's method."""

    def motion(self, instance: Instance, x: Fraction) -> Motion:
        """Many steps of 2 tau x, a sample a step."""
        return stability.probe(instance, float(x))

    def checks(self, subject: Subject, x: Fraction) -> tuple[Check, ...]:
        """The check that the motion stays bounded."""
        return (Bounded(),)


class Bounded(Check):
    """No position, velocity or angular velocity exceeds a hundred times its scale."""

    name = "bounded"
    title = "Bounded"
    kills = "a method whose stability limit is below that of the scheme it claims to implement"

    def applies(self, subject: Subject) -> str | None:
        """None: the check applies to every motion with a step."""
        return None

    def needs(self, subject: Subject) -> tuple[Variant, ...]:
        """The run with the step of the point."""
        return (subject.finest,)

    def judge(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> list[Finding]:
        """One finding: the largest number of the run, in units of its scale."""
        trajectory = runs[subject.finest].trajectory
        return [
            judged(
                check=self.name,
                quantity="size",
                value=stability.excess(subject.instance, trajectory),
                bound=stability.BEYOND,
                unit="1",
                basis=(
                    f"below the stability limit the motion stays bounded for {stability.STEPS}"
                    " steps; a step larger by 1/1000 does not"
                ),
                what=("The largest position, velocity or angular velocity, relative to its scale,"),
            )
        ]
