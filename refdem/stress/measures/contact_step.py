"""Steps as long as a contact lasts and longer: what an impact without loss gives back."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np

from refdem.campaign.plan import Task
from refdem.core.case import Canonical, Instance
from refdem.core.check import Check, CompletedRun, Subject
from refdem.core.engine import Engine, Method
from refdem.core.finding import Finding
from refdem.core.judgement import judged
from refdem.core.problem import Motion, Request
from refdem.core.variant import Variant
from refdem.stress.measures.measure import Measure

GAINED = 0.1
"""The largest part of the kinetic energy that an impact without loss may gain or lose: with more, a
heap of grains heats up or settles by the step and not by the law.
"""
AFTERWARDS = 3
"""The run lasts so many times as long as the contact, so that also one that steps prolong is over
at its end.
"""


@dataclass(frozen=True)
class ContactStep(Measure):
    """The rung is the step as a part of the time pi/omega = pi tau that the contact lasts."""

    needs_truth: bool = False

    def instance(self, case: Canonical, parameters: Mapping[str, str], x: Fraction) -> Instance:
        """The case as given: the rung changes only the step."""
        return case.at(**parameters)

    def levels(self, instance: Instance, method: Method, x: Fraction) -> tuple[float, ...]:
        """The one level, the step [s] of the rung."""
        return (_step(instance, x),)

    def unsupported(
        self, engine: Engine, method: Method, instance: Instance, x: Fraction
    ) -> str | None:
        """None if the method has a fixed step and supports the motion, else the reason."""
        if method.control != "step":
            return "the method does not have a fixed step"
        if not isinstance(instance.problem, Motion):
            return f"{instance.problem.words} does not have a step"
        return engine.unsupported(_impact(instance, x), method)

    def request(self, task: Task, variant: Variant, x: Fraction) -> Request:
        """A request in which each step is a sample."""
        return Request(
            problem=_impact(task.subject.instance, x), method=task.method.name, step=variant.level
        )

    def checks(self, subject: Subject, x: Fraction) -> tuple[Check, ...]:
        """The check of the energy that comes back."""
        return (GivesBack(),)


def _step(instance: Instance, x: Fraction) -> float:
    """The step [s]: x times the duration of the contact."""
    return float(x) * math.pi * instance.scales.tau


def _impact(instance: Instance, x: Fraction) -> Motion:
    """The impact from its first touch until well after it, a sample a step."""
    steps = math.ceil(AFTERWARDS / x) + 1
    return replace(
        instance.motion, times=np.arange(steps + 1, dtype=np.float64) * _step(instance, x)
    )


class GivesBack(Check):
    """The kinetic energy after an impact without loss is that before it, to a part GAINED."""

    name = "gives-back"
    title = "Energy after the impact"
    kills = "steps too long for the contact"

    def applies(self, subject: Subject) -> str | None:
        """None: the measure asks it only of impacts without loss."""
        return None

    def needs(self, subject: Subject) -> tuple[Variant, ...]:
        """The run with the step of the rung."""
        return (subject.finest,)

    def judge(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> list[Finding]:
        """One finding: |E_after/E_before - 1|, with E = sum of m v^2/2 over the bodies."""
        mass = subject.instance.scene.bodies.mass[None, :, None]
        velocity = runs[subject.finest].trajectory.velocity
        energy = (mass * velocity**2).sum(axis=(1, 2)) / 2
        change = abs(float(energy[-1] / energy[0]) - 1.0)
        return [
            judged(
                check=self.name,
                quantity="kinetic energy",
                value=change,
                bound=GAINED,
                unit="1",
                basis="the contact has no dashpot and no friction, so that all energy comes back",
                what="The change of kinetic energy across the impact, relative to itself,",
            )
        ]
