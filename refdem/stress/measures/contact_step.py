"""Steps as long as a contact and longer: the kinetic energy after an impact without loss."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np

from refdem.core.case import Instance
from refdem.core.check import Check, CompletedRun, Subject
from refdem.core.finding import Finding
from refdem.core.judgement import judged
from refdem.core.problem import Motion
from refdem.core.variant import Variant
from refdem.stress.measures.fixed_step import FixedStep

GAINED = 0.1
"""Largest relative change of the kinetic energy in an impact without loss. A larger one would make
a heap of grains heat up or settle because of the step and not because of the contact law.
"""
AFTERWARDS = 3
"""Duration of the run in units of that of the contact, so that a contact which long steps prolong
has also ended.
"""


@dataclass(frozen=True)
class ContactStep(FixedStep):
    """The point is the step as a part of the time pi/omega = pi tau that the contact lasts."""

    def motion(self, instance: Instance, x: Fraction) -> Motion:
        """The impact from its first touch until well after it, a sample a step."""
        # Step h = x T, with the duration T = pi tau of the contact.
        step = float(x) * math.pi * instance.scales.tau
        # AFTERWARDS T / h = AFTERWARDS / x, and one step more.
        steps = math.ceil(AFTERWARDS / x) + 1
        times = np.arange(steps + 1, dtype=np.float64) * step
        return replace(instance.motion, times=times)

    def checks(self, subject: Subject, x: Fraction) -> tuple[Check, ...]:
        """The check of the kinetic energy after the impact."""
        return (GivesBack(),)


class GivesBack(Check):
    """The kinetic energy after an impact without loss is that before it, to a part GAINED."""

    name = "gives-back"
    title = "Energy after the impact"
    kills = "steps too long for the contact"

    def applies(self, subject: Subject) -> str | None:
        """None: the measure asks it only of impacts without loss."""
        return None

    def needs(self, subject: Subject) -> tuple[Variant, ...]:
        """The run with the step of the point."""
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
