"""Kinetic energy that appears going forward disappears coming back, where forces depend on place
and orientation alone.
"""

from collections.abc import Mapping

import numpy as np

from refdem.core.balance import kinetic
from refdem.core.check import Check, CompletedRun, Subject
from refdem.core.finding import Finding
from refdem.core.judgement import certified, judged, no_truth, undecided
from refdem.core.variant import Variant
from refdem.scene.elements.piecewise_field import PiecewiseField
from refdem.scene.elements.wedge import Wedge

TERMS = 2.0
"""Kinetic energy errs by twice the relative error of the velocity."""


class EnergyReturn(Check):
    """The gain of a run, against truth, and the gain of its way back, which undoes it."""

    name = "energy-return"
    title = "Gained energy is returned on the way back"
    kills = "a force law that depends on the sign of the velocity, a field that does different work"
    synchronous = True

    def applies(self, subject: Subject) -> str | None:
        """Scenes in which a field or a turn changes the kinetic energy, and methods whose end state
        is complete.
        """
        scene = subject.instance.scene
        if not scene.all(PiecewiseField) and not scene.all(Wedge):
            return "no asymmetric force changes the kinetic energy"
        if subject.method.complete_state:
            return None
        return "the final state of the method is incomplete, so a run cannot be continued from it"

    def needs(self, subject: Subject) -> tuple[Variant, ...]:
        """The run at the finest level, forward and backward."""
        return (subject.finest, Variant(subject.levels[-1], "reversed"))

    def judge(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> list[Finding]:
        """Gain against truth; gain and loss against each other."""
        truth = certified(subject)
        if truth is None or truth.until < len(subject.instance.times):
            return [undecided(self.name, "gain", no_truth(subject))]
        instance = subject.instance
        scene = subject.instance.scene
        there, back = (kinetic(scene, runs[variant].trajectory) for variant in self.needs(subject))
        speeds = truth.value("v")[[0, -1]]
        true = 0.5 * float(scene.bodies.mass[0]) * (speeds[1] ** 2 - speeds[0] ** 2)
        fastest = float(max(1.0, np.abs(truth.value("v")).max() / instance.scales.speed))
        unit = instance.scales.energy * fastest**2
        gained = there[-1] - there[0]
        lost = back[-1] - back[0]
        allowed = float(subject.bound(subject.levels[-1])[-1])
        growth = float(truth.growth()[-1])
        exact = subject.method.reversible or subject.method.control == "exact"
        if exact:
            back_off = 2 * subject.round_off(subject.levels[-1]) * growth**2
            reason = "round-off of the forward and the backward run"
        else:
            back_off = 2 * allowed * growth
            reason = "twice the error bound of the velocity, forward and backward"
        gain_error = judged(
            check=self.name,
            quantity="gain",
            value=abs(gained - true) / unit,
            bound=TERMS * allowed,
            unit="1",
            basis="twice the error bound of the velocity",
            what="The error of the gain in kinetic energy, relative to m v^2,",
        )
        return_defect = judged(
            check=self.name,
            quantity="return",
            value=abs(gained + lost) / unit,
            bound=TERMS * back_off,
            unit="1",
            basis=reason,
            what=(
                "The net gain in kinetic energy after running forward and backward,"
                " relative to m v^2,"
            ),
        )
        return [gain_error, return_defect]


CHECK = EnergyReturn()
