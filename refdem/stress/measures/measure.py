"""Base class of measures: the instance of a point, the levels it runs at, its requests, and the
checks that judge it.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from fractions import Fraction

from refdem.core import discovery, refinement
from refdem.core.case import Canonical, Instance
from refdem.core.check import Check, Subject
from refdem.core.engine import Engine, Method
from refdem.core.problem import Request
from refdem.core.truth import SampledTruth
from refdem.core.variant import Variant
from refdem.planning import plan
from refdem.planning.plan import Task

LEVELS = 3
"""Levels of refinement, of which the last is run: its bound is tighter than the first level's."""
MOST_STEPS = 1e5
"""Largest number of steps of a run: the finest level with no more steps is run."""


class Measure(ABC):
    """One way to make a scene harder; `x` is the point as an exact number."""

    needs_truth: bool = True

    @abstractmethod
    def instance(self, case: Canonical, parameters: Mapping[str, str], x: Fraction) -> Instance:
        """The instance of a point; raises UsageError where the case has none."""

    def levels(self, instance: Instance, method: Method, x: Fraction) -> tuple[float, ...]:
        """Levels of a point, coarse to fine; empty if the method would need too many steps."""
        return refinement.levels(instance, method, LEVELS, MOST_STEPS)[-1:]

    def unsupported(
        self, engine: Engine, method: Method, instance: Instance, x: Fraction
    ) -> str | None:
        """None if the method supports the point, else the reason."""
        return engine.unsupported(instance.problem, method)

    def request(self, task: Task, variant: Variant, x: Fraction) -> Request:
        """The request of a variant of the point."""
        return plan.request(task, variant)

    @abstractmethod
    def checks(self, subject: Subject, x: Fraction) -> tuple[Check, ...]:
        """The checks that judge the point."""

    def task(
        self, engine: Engine, method: Method, instance: Instance, x: Fraction, truth: SampledTruth
    ) -> Task:
        """The task of a method on a point: its levels and checks, or the reason why it is
        unsupported.
        """
        unsupported = self.unsupported(engine, method, instance, x)
        levels: tuple[float, ...] = ()
        if not unsupported:
            levels = self.levels(instance, method, x)
        if not unsupported and not levels:
            unsupported = f"more than {MOST_STEPS:g} steps"
        subject = Subject(instance, method, levels, truth, truth.reason)
        checks: tuple[Check, ...] = ()
        if not unsupported:
            checks = self.checks(subject, x)
        return Task(engine, subject, unsupported, checks)


def with_samples(parameters: Mapping[str, str], count: int) -> dict[str, str]:
    """The parameters, with `count` sample intervals unless they set another number."""
    return {"samples": str(count), **parameters}


def plain_checks(subject: Subject) -> tuple[Check, ...]:
    """Every check that applies and needs only the plain run at the only level."""
    (level,) = subject.levels
    excluded = subject.instance.case.exclude_for(subject.instance.p)
    known = [discovery.check(name) for name in discovery.names("checks") if name not in excluded]
    return tuple(
        check
        for check in known
        if check.left_out(subject) is None and set(check.needs(subject)) == {Variant(level)}
    )
