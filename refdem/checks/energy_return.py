"""Kinetic energy that appears going forward disappears coming back, where forces depend on place
and orientation alone.
"""

from collections.abc import Mapping

import numpy as np

from refdem.core.balance import kinetic
from refdem.core.check import Check, Outcome, Trial
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
    title = "Energy that appears disappears coming back"
    kills = "a law keyed to the sign of the velocity, a field whose work is another"
    synchronous = True

    def applies(self, trial: Trial) -> str | None:
        """Scenes in which a field or a turn changes the kinetic energy, and methods whose end state
        is complete.
        """
        scene = trial.instance.scene
        if not scene.all(PiecewiseField) and not scene.all(Wedge):
            return "no asymmetric force changes the kinetic energy"
        if trial.method.complete_state:
            return None
        return "the method's end state is not complete, so it cannot go on from there"

    def needs(self, trial: Trial) -> tuple[Variant, ...]:
        """The finest level, there and back."""
        return (trial.finest, Variant(trial.levels[-1], "reversed"))

    def judge(self, trial: Trial, runs: Mapping[Variant, Outcome]) -> list[Finding]:
        """Gain against truth; gain and loss against each other."""
        truth = certified(trial)
        if truth is None or truth.until < len(trial.instance.times):
            return [undecided(self.name, "gain", no_truth(trial))]
        instance = trial.instance
        scene = trial.instance.scene
        there, back = (kinetic(scene, runs[variant].trajectory) for variant in self.needs(trial))
        speeds = truth.value("v")[[0, -1]]
        true = 0.5 * float(scene.bodies.mass[0]) * (speeds[1] ** 2 - speeds[0] ** 2)
        fastest = float(max(1.0, np.abs(truth.value("v")).max() / instance.scales.speed))
        unit = instance.scales.energy * fastest**2
        gained = there[-1] - there[0]
        lost = back[-1] - back[0]
        allowed = float(trial.bound(trial.levels[-1])[-1])
        growth = float(truth.growth()[-1])
        exact = trial.method.reversible or trial.method.control == "exact"
        if exact:
            back_off = 2 * trial.round_off(trial.levels[-1]) * growth**2
        else:
            back_off = 2 * allowed * growth
        gain_error = judged(
            check=self.name,
            quantity="gain",
            value=abs(gained - true) / unit,
            bound=TERMS * allowed,
            unit="1",
            basis="twice the bound on the velocity",
            what="The error of the gain in kinetic energy, over m v^2,",
        )
        return_defect = judged(
            check=self.name,
            quantity="return",
            value=abs(gained + lost) / unit,
            bound=TERMS * back_off,
            unit="1",
            basis=(
                "round-off there and back"
                if exact
                else "twice the bound on the velocity there and back"
            ),
            what="The kinetic energy that a way there and back has gained, over m v^2,",
        )
        return [gain_error, return_defect]


CHECK = EnergyReturn()
