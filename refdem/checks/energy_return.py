"""Kinetic energy gained in the forward run is lost in the backward run, where forces depend on
position and orientation only.

    gain = K(T) - K(0) = m (v_T^2 - v_0^2)/2,   gain + return = 0
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
    """The gain of kinetic energy in a run against truth, and its sum with the change on the way
    back: 0.
    """

    name = "energy-return"
    title = "Gained energy is returned on the way back"
    kills = "a force law that depends on the sign of the velocity, a field that does different work"
    synchronous = True

    def applies(self, subject: Subject) -> str | None:
        """Scenes with an asymmetric field or contact, and methods whose final state is
        complete.
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
        """Two findings: the gain against m (v_T^2 - v_0^2)/2 of truth, and gain plus change in the
        backward run against 0.
        """
        truth = certified(subject)
        if truth is None or truth.until < len(subject.instance.times):
            return [undecided(self.name, "gain", no_truth(subject))]
        instance = subject.instance
        scene = subject.instance.scene
        forward, backward = (
            kinetic(scene, runs[variant].trajectory) for variant in self.needs(subject)
        )
        speeds = truth.value("v")[[0, -1]]
        # The gain that truth has: m (v_T^2 - v_0^2)/2.
        true_gain = 0.5 * float(scene.bodies.mass[0]) * (speeds[1] ** 2 - speeds[0] ** 2)
        fastest = float(max(1.0, np.abs(truth.value("v")).max() / instance.scales.speed))
        # A relative error of the velocity is scaled by its largest value.
        # E_s max(1, |v|/V)^2. An error e of the velocity at both ends changes the gain by at most
        # TERMS e of that.
        unit = instance.scales.energy * fastest**2
        # K(T) - K(0), forward and backward.
        gain = forward[-1] - forward[0]
        return_gain = backward[-1] - backward[0]
        allowed = float(subject.bound(subject.levels[-1])[-1])
        growth = float(truth.growth()[-1])
        is_exact = subject.method.reversible or subject.method.control == "exact"
        # Errors of the forward run grow in the backward run as well. A reversible method undoes its
        # own truncation there, so that only round-off remains.
        if is_exact:
            # 2 u_n S^2, for the growth S of errors in each direction.
            velocity_error = 2 * subject.round_off(subject.levels[-1]) * growth**2
            return_basis = "round-off of the forward and the backward run"
        else:
            # 2 bound S: the error of the forward run grows by S in the backward run.
            velocity_error = 2 * allowed * growth
            return_basis = "twice the error bound of the velocity, forward and backward"
        gain_error = judged(
            check=self.name,
            quantity="gain",
            value=abs(gain - true_gain) / unit,
            bound=TERMS * allowed,
            unit="1",
            basis="twice the error bound of the velocity",
            what="The error of the gain in kinetic energy, relative to m v^2,",
        )
        return_defect = judged(
            check=self.name,
            quantity="return",
            value=abs(gain + return_gain) / unit,
            bound=TERMS * velocity_error,
            unit="1",
            basis=return_basis,
            what=(
                "The net gain in kinetic energy after running forward and backward,"
                " relative to m v^2,"
            ),
        )
        return [gain_error, return_defect]


CHECK = EnergyReturn()
