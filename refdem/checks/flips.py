"""Number of flips of a body that tumbles about its intermediate axis."""

from collections.abc import Mapping

import numpy as np

from refdem.core.check import Check, CompletedRun, Subject
from refdem.core.finding import Finding
from refdem.core.judgement import Array, Sight, certified, judged, no_truth, undecided
from refdem.core.refinement import scored
from refdem.core.variant import Variant


class Flips(Check):
    """The angular velocity about the intermediate axis changes sign as often as in truth (finest
    level).
    """

    name = "flips"
    title = "Number of flips"
    kills = "a missing or wrong gyroscopic term, exchanged principal axes"
    synchronous = True

    def applies(self, subject: Subject) -> str | None:
        """None for one tumbling body without elements, else the reason why not."""
        scene = subject.instance.scene
        if "tumbling" not in scene.features or scene.elements or len(scene.bodies) != 1:
            return "the scene has no free tumbling body"
        return None

    def needs(self, subject: Subject) -> tuple[Variant, ...]:
        """The plain run at the finest level."""
        return (subject.finest,)

    def judge(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> list[Finding]:
        """One finding: the difference of both numbers of sign changes, up to the predictability
        horizon.
        """
        truth = certified(subject)
        if truth is None:
            return [undecided(self.name, "flips", no_truth(subject))]
        bound = subject.bound(subject.levels[-1])
        count = scored(bound)
        # The axis with the second largest principal moment of inertia.
        axis = "xyz"[int(np.argsort(subject.instance.scene.bodies.inertia[0])[1])]
        name = f"omega_body.{axis}"
        true_omega = truth.value(name)[:count]
        # Where |omega| is within its bound the sign of a correct run is not known: samples count
        # only where |omega_true| > bound scale.
        has_sign = np.abs(true_omega) > bound[:count] * subject.instance.quantities[name].scale
        run_omega = subject.instance.observe(runs[subject.finest].trajectory)[name][:count]
        n_observed = _flips(run_omega[has_sign])
        n_true = _flips(true_omega[has_sign])
        until = f"up to t = {subject.instance.times[count - 1]:.4g} s"
        what = (
            f"The difference in the number of flips about axis {axis} (true: {n_true},"
            f" run: {n_observed}, {until})"
        )
        return [
            judged(
                check=self.name,
                quantity="flips",
                value=float(abs(n_observed - n_true)),
                bound=0.0,
                sight=Sight(0.0, float(n_true)),
                unit="1",
                basis="the number of flips is an integer, so it must agree exactly",
                what=what,
            )
        ]


def _flips(omega: Array) -> int:
    """The number of sign changes of omega (T,); zeros are skipped."""
    signs = np.sign(omega[omega != 0])
    return int(np.count_nonzero(signs[1:] != signs[:-1]))


CHECK = Flips()
