"""Self-convergence, without truth: halving the step changes a run by 2^p less than the halving
before.

With an error C h^p, runs at h and h/2 differ by C h^p (1 - 2^-p), so that the order p is log2 of
the ratio of two successive changes.
"""

from collections.abc import Mapping
from itertools import pairwise

import numpy as np

from refdem.core.check import Check, CompletedRun, Subject
from refdem.core.finding import Finding
from refdem.core.judgement import (
    difference,
    growth_shown,
    judged,
    observed_order,
    order_statement,
    perturbation,
    undecided,
)
from refdem.core.refinement import HORIZON, kinked
from refdem.core.variant import Variant

ORDER_TOLERANCE_FACTOR = 2.0
"""Factor on the tolerance of an observed order: successive changes converge as errors do one level
coarser, so their order deviates twice as much.
"""


class Convergence(Check):
    """The order from the finest three levels, where truth ends before the run and the check `order`
    cannot judge all of it.
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
        """The plain runs of the finest three levels; and the coarsest level with its start
        perturbed, which shows how errors grow.
        """
        # `judge` takes the last two, the plain and the perturbed run, from the end of this tuple.
        coarsest = subject.levels[0]
        return (
            *subject.plain[-3:],
            Variant(coarsest),
            Variant(coarsest, "perturbed", perturbation(subject.method)),
        )

    def judge(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> list[Finding]:
        """The deficit p - log2(change/next change) against its tolerance 2 max(0.15, 0.05 p).

        Undecided where the finest change is too large to show an order. A change within round-off
        counts as the claimed order.
        """
        finest_three = [runs[variant] for variant in subject.plain[-3:]]
        coarse, fine = (_change(subject, run, finer) for run, finer in pairwise(finest_three))
        *_, plain, perturbed = self.needs(subject)
        base = runs[plain].trajectory
        # An engine may refuse the perturbed start; then no growth is shown.
        neighbour = base
        if perturbed in runs:
            neighbour = runs[perturbed].trajectory
        growth = float(growth_shown(subject.instance, subject.method, neighbour, base)[-1])
        # Round-off of the finest run, grown to the end.
        floor = subject.floor(subject.levels[-1]) * growth
        if fine > HORIZON:
            why = (
                f"the two finest levels differ by {fine:.2g} of the scale; smaller steps are needed"
            )
            return [undecided(self.name, "state", why)]
        order = subject.order
        if fine > floor:
            # p_observed = log2(|x(4h) - x(2h)|/|x(2h) - x(h)|), with h the finest step.
            observed = observed_order(coarse, fine)
        else:
            observed = float(order)
        deficit = max(0.0, order - observed)
        tolerance = ORDER_TOLERANCE_FACTOR * max(0.15, 0.05 * order)
        if kinked(subject.instance, subject.method) and order - observed > tolerance:
            return [self._within(subject, fine, growth, observed)]
        return [
            judged(
                check=self.name,
                quantity="state",
                value=deficit,
                bound=tolerance,
                unit="1",
                basis=(
                    f"order {order} is claimed, so successive changes must fall with it,"
                    " within 2 max(0.15, 0.05 p)"
                ),
                statement=order_statement(
                    observed,
                    order,
                    deficit,
                    tolerance,
                    f"successive changes {coarse:.2g} and {fine:.2g} of the scale",
                ),
                order_seen=observed,
                order_claimed=float(order),
            )
        ]

    def _within(self, subject: Subject, fine: float, growth: float, observed: float) -> Finding:
        """The finest change against the error bounds of both levels, for motions with kinks.

        Kinks (contacts, stick-slip) scatter the error constant from step to step, so that the ratio
        of two changes is no order. The triangle inequality still holds: a change is at most the sum
        of both errors.
        """
        # |x(2h) - x(h)| <= S (truncation(2h) + resolution(2h) + truncation(h) + resolution(h)).
        allowed = growth * sum(
            float(subject.truncation(h)[-1]) + subject.resolution(h) for h in subject.levels[-2:]
        )
        if fine <= allowed:
            return undecided(
                self.name,
                "state",
                (
                    "kinks scatter the changes from level to level, so one pair of levels"
                    f" (observed order {observed:.2f}) is not conclusive"
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
    """Largest difference of any quantity at any sample between two levels, in units of its
    scale.
    """
    instance = subject.instance
    coarse_values = instance.observe(coarse.trajectory)
    fine_values = instance.observe(fine.trajectory)
    largest = 0.0
    for name, quantity in instance.quantities.items():
        if name in coarse_values and name in fine_values and not quantity.group:
            # max over quantities and samples of |x_fine - x_coarse|/scale.
            change = difference(fine_values[name], coarse_values[name], is_angle=quantity.angle)
            largest = max(largest, float(np.max(np.abs(change))) / quantity.scale)
    return largest


CHECK = Convergence()
