"""Base class of measures whose point sets the fixed step of a method: every step is a sample."""

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction

from refdem.core.case import Canonical, Instance
from refdem.core.engine import Engine, Method
from refdem.core.problem import Motion, Request
from refdem.core.variant import Variant
from refdem.planning.plan import Task
from refdem.stress.measures.measure import Measure


@dataclass(frozen=True)
class FixedStep(Measure):
    """The case stays as given; the step is the sample interval of the motion of the point."""

    needs_truth: bool = False

    @abstractmethod
    def motion(self, instance: Instance, x: Fraction) -> Motion:
        """The motion of point x, whose sample interval is the step [s]."""

    def instance(self, case: Canonical, parameters: Mapping[str, str], x: Fraction) -> Instance:
        """The case as given: the point changes only the step."""
        return case.at(**parameters)

    def levels(self, instance: Instance, method: Method, x: Fraction) -> tuple[float, ...]:
        """The one level, the step [s] of the point."""
        return (self.motion(instance, x).interval,)

    def unsupported(
        self, engine: Engine, method: Method, instance: Instance, x: Fraction
    ) -> str | None:
        """None if the method has a fixed step and supports the motion, else the reason."""
        if method.control != "step":
            return "the method does not have a fixed step"
        if not isinstance(instance.problem, Motion):
            return f"{instance.problem.words} does not have a step"
        return engine.unsupported(self.motion(instance, x), method)

    def request(self, task: Task, variant: Variant, x: Fraction) -> Request:
        """A request in which each step is a sample."""
        return Request(
            problem=self.motion(task.subject.instance, x),
            method=task.method.name,
            step=variant.level,
        )
