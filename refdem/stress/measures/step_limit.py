"""Steps up to and beyond the stability limit: many steps must stay bounded."""

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction

from refdem.campaign.plan import Task
from refdem.core import stability
from refdem.core.case import Canonical, Instance
from refdem.core.check import Check, CompletedRun, Subject
from refdem.core.engine import Engine, Method
from refdem.core.finding import Finding
from refdem.core.judgement import judged
from refdem.core.problem import Motion, Request
from refdem.core.variant import Variant
from refdem.stress.measures.measure import Measure


@dataclass(frozen=True)
class StepLimit(Measure):
    """The rung is the step in units of 2/omega = 2 tau, the stability limit of Verlet's method."""

    needs_truth: bool = False

    def instance(self, case: Canonical, parameters: Mapping[str, str], x: Fraction) -> Instance:
        """The case as given: the rung changes only the step."""
        return case.at(**parameters)

    def levels(self, instance: Instance, method: Method, x: Fraction) -> tuple[float, ...]:
        """The one level, the step [s] of the rung."""
        return (stability.probe(instance, float(x)).interval,)

    def unsupported(
        self, engine: Engine, method: Method, instance: Instance, x: Fraction
    ) -> str | None:
        """None if the method has a fixed step and supports the motion, else the reason."""
        if method.control != "step":
            return "the method does not have a fixed step"
        if not isinstance(instance.problem, Motion):
            return f"{instance.problem.words} does not have a step"
        return engine.unsupported(stability.probe(instance, float(x)), method)

    def request(self, task: Task, variant: Variant, x: Fraction) -> Request:
        """A request of many steps, each of which is a sample."""
        return Request(
            problem=stability.probe(task.subject.instance, float(x)),
            method=task.method.name,
            step=variant.level,
        )

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
        """The run with the step of the rung."""
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
