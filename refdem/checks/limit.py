"""The limit of small steps: errors at several steps, extrapolated to step 0, must vanish."""

from collections.abc import Mapping
from itertools import pairwise

import numpy as np

from refdem.core.check import Check, CompletedRun, Subject
from refdem.core.finding import Finding
from refdem.core.judgement import (
    PREDICTION_FACTOR,
    certified,
    judged,
    no_truth,
    observed_order,
    rounding_of_truth,
    signed,
    undecided,
)
from refdem.core.refinement import kinked, scored
from refdem.core.variant import Variant

SETTLED = 0.3
"""Largest deficit of the observed order for which errors count as a power of the step: twice the
tolerance of the check `order`.
"""


class Limit(Check):
    """Richardson's extrapolation of the error to step 0 (1911) is a part of its own last change.

    From errors e(h) and e(h/2) of order p, E(h) = (2^p e(h/2) - e(h))/(2^p - 1) removes the term
    h^p. E falls by a factor f = 2^(p+1) or more from one pair of levels to the next, so the
    remaining E is 1/(f - 1) of its last change. PREDICTION_FACTOR times that is allowed, because
    terms of higher order still count, and at most all of it. Measured on a hundred motions of
    correct methods: 1/3, 1/15 and 1/31 of it for orders 1, 2 and 4. An error that does not depend
    on the step, as of a stiffness or a clock wrong by 1e-7, does not fall, and is detected far
    below the truncation error.
    """

    name = "limit"
    title = "Limit of small steps"
    kills = (
        "a wrong constant or clock hidden below the truncation error: runs that"
        " converge to another solution"
    )

    def applies(self, subject: Subject) -> str | None:
        """Smooth motions integrated with at least three fixed steps, with positions and velocities
        at the same times.
        """
        if subject.method.control != "step":
            return f"the step control of the method is {subject.method.control}, not a fixed step"
        if kinked(subject.instance, subject.method):
            return "kinks scatter the errors, so they do not follow a power of the step"
        if _extrapolates_a_kink(subject):
            return "a singular force leaves errors that scatter, where extrapolation needs a power"
        if subject.method.delay(subject.levels[0]) != 0:
            return "velocities lag by a time that depends on the step"
        if len(subject.levels) > 2:
            return None
        return "at least three steps are needed"

    def needs(self, subject: Subject) -> tuple[Variant, ...]:
        """The plain runs of the three finest levels."""
        return tuple(Variant(level) for level in subject.levels[-3:])

    def judge(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> list[Finding]:
        """One finding: the largest extrapolated error of any quantity, in units of its scale."""
        truth = certified(subject)
        if truth is None:
            return [undecided(self.name, "state", no_truth(subject))]
        coarse, middle, fine = (runs[variant].trajectory for variant in self.needs(subject))
        count = min(truth.until, scored(subject.bound(subject.levels[-3])))
        if count < 2:
            why = "the predictability horizon of the third finest step is before the second sample"
            return [undecided(self.name, "state", why)]
        order = subject.order
        errors = [signed(subject, run, truth, count) for run in (coarse, middle, fine)]
        # floor = 3 max over t of resolution(h) S(t), plus the rounding of truth: the weights
        # 2^p/(2^p - 1) and 1/(2^p - 1) of two errors sum to at most 3, for p = 1.
        of_run = float(np.max(subject.resolution(subject.levels[-1]) * truth.growth()[:count]))
        floor = 3 * of_run + rounding_of_truth(subject, truth, count)
        largest = [float(np.max(np.abs(error), initial=0.0)) for error in errors]
        if largest[1] > floor and observed_order(*largest[:2]) < order - SETTLED:
            why = f"errors do not yet fall with order {order}; see the check `order`"
            return [undecided(self.name, "state", why)]
        # E(h) = (2^p e(h/2) - e(h))/(2^p - 1) of both pairs of neighbouring levels.
        coarse_limit, fine_limit = (
            (2**order * b - a) / (2**order - 1) for a, b in pairwise(errors)
        )
        last_change = float(np.max(np.abs(coarse_limit - fine_limit), initial=0.0))
        # f = 2^(p+1);   |E(h/2)| <= min(1, PREDICTION_FACTOR/(f - 1)) |E(h) - E(h/2)| + floor.
        ratio = 2.0 ** (order + 1)
        share = min(1.0, PREDICTION_FACTOR / (ratio - 1))
        return [
            judged(
                check=self.name,
                quantity="state",
                value=float(np.max(np.abs(fine_limit), initial=0.0)),
                bound=share * last_change + floor,
                unit="1",
                basis=(
                    f"extrapolated errors fall by a factor of {ratio:g} per level, so that"
                    f" {share:.2g} of their last change, plus 3 times round-off, holds the rest"
                ),
                what=(
                    f"The error extrapolated to zero step (Richardson, order {order}, two"
                    " finest levels), relative to each scale,"
                ),
            )
        ]


def _extrapolates_a_kink(subject: Subject) -> bool:
    """True if a force |s|^n causes an error of order n + 1 <= p + 1.

    Extrapolation with the order p does not remove it, and it scatters from step to step.
    """
    if subject.method.locates_events:
        return False
    found = subject.instance.scene.singularities()
    return any(singularity.order <= subject.order + 1 for _, singularity in found)


CHECK = Limit()
