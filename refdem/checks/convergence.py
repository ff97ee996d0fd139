"""Convergence without truth: from level to level a run changes by 2^p less, whatever it converges
to.
"""

from collections.abc import Mapping
from itertools import pairwise

import numpy as np

from refdem.core.check import Check, CompletedRun, Subject
from refdem.core.finding import Finding
from refdem.core.judgement import growth_shown, judged, order_statement, perturbation, undecided
from refdem.core.refinement import COUNTING_FLOOR, HORIZON, kinked
from refdem.core.variant import Variant

FURTHER = 2.0
"""Changes between three levels are as far from the limit as errors one level coarser: the order
lacks twice as much there.
"""


class Convergence(Check):
    """The finest three levels, where truth does not reach to the end of the run and so cannot show
    the order.
    """

    name = "convergence"
    title = "Self-convergence"
    kills = (
        "a velocity or a spring force of the previous step where no truth is"
        " certified, results that never converge"
    )

    def applies(self, subject: Subject) -> str | None:
        """Fixed steps, at least three levels, and samples that are not certified."""
        if subject.method.control != "step":
            return f"the step control of the method is {subject.method.control}, not a fixed step"
        if subject.truth is not None and subject.truth.until == len(subject.instance.times):
            return "truth is certified to the end of the run, and the check `order` is stricter"
        if len(subject.levels) >= 3:
            return None
        return f"only {len(subject.levels)} refinement levels are planned; 3 are needed"

    def needs(self, subject: Subject) -> tuple[Variant, ...]:
        """The plain runs of the finest three levels, and two that show how errors grow: the
        coarsest one, and moved a little.
        """
        coarsest = subject.levels[0]
        return (
            *subject.plain[-3:],
            Variant(coarsest),
            Variant(coarsest, "perturbed", perturbation(subject.method)),
        )

    def judge(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> list[Finding]:
        """What the order lacks that two changes show; undecided where they are round-off or too
        large to show one.
        """
        coarse, fine = (_change(subject, runs[a], runs[b]) for a, b in pairwise(subject.plain[-3:]))
        *_, plain, perturbed = self.needs(subject)
        base = runs[plain].trajectory  # a code may refuse the moved start
        if perturbed in runs:
            moved = runs[perturbed].trajectory
        else:
            moved = base
        growth = float(growth_shown(subject.instance, subject.method, moved, base)[-1])
        floor = COUNTING_FLOOR * subject.noise(subject.levels[-1]) * growth
        if fine > HORIZON:
            why = (
                f"the two finest levels differ by {fine:.2g} of the scale; smaller steps are needed"
            )
            return [undecided(self.name, "state", why)]
        order = subject.order
        if fine > floor:
            seen = float(np.log2(coarse / fine))
        else:
            seen = float(order)
        if kinked(subject.instance) and order - seen > FURTHER * max(0.15, 0.05 * order):
            return [self._within(subject, fine, growth, seen)]
        return [
            judged(
                check=self.name,
                quantity="state",
                value=max(0.0, order - seen),
                bound=FURTHER * max(0.15, 0.05 * order),
                unit="1",
                basis=(
                    f"order {order} is claimed, so successive changes must fall with it,"
                    " within 2 max(0.15, 0.05 p)"
                ),
                statement=order_statement(
                    seen,
                    order,
                    max(0.0, order - seen),
                    FURTHER * max(0.15, 0.05 * order),
                    f"successive changes {coarse:.2g} and {fine:.2g} of the scale",
                ),
                order_seen=seen,
                order_claimed=float(order),
            )
        ]

    def _within(self, subject: Subject, fine: float, growth: float, seen: float) -> Finding:
        """Where kinks scatter the changes a pair shows no order; the finest change is still no
        larger than the errors allowed.
        """
        allowed = growth * sum(
            float(subject.truncation(h)[-1]) + subject.noise(h) for h in subject.levels[-2:]
        )
        if fine <= allowed:
            return undecided(
                self.name,
                "state",
                (
                    "kinks scatter the changes from level to level, so one pair of levels"
                    f" (observed order {seen:.2f}) is not conclusive"
                ),
            )
        return judged(
            check=self.name,
            quantity="state",
            value=fine,
            bound=allowed,
            unit="1",
            basis="the sum of the error bounds of both levels",
            what="The change between the two finest levels, relative to each scale,",
        )


def _change(subject: Subject, coarse: CompletedRun, fine: CompletedRun) -> float:
    """Largest scaled difference of any quantity at any sample between two levels."""
    instance = subject.instance
    first = instance.observe(coarse.trajectory)
    second = instance.observe(fine.trajectory)
    found = 0.0
    for name, quantity in instance.quantities.items():
        if name in first and name in second and not quantity.group:
            difference = second[name] - first[name]
            if quantity.angle:
                difference = np.remainder(difference + np.pi, 2 * np.pi) - np.pi
            found = max(found, float(np.max(np.abs(difference))) / quantity.scale)
    return found


CHECK = Convergence()
