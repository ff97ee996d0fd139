"""Observed order of convergence: with an error C h^p, halving the step h divides the error by 2^p.

The order between levels h and h/2 is log2(e(h)/e(h/2)), e being the largest error of any quantity
in units of its scale. It deviates from p by terms of higher order, by round-off at small steps, and
by kinks of the motion (contacts, stick-slip), which scatter C from step to step.
"""

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import NamedTuple

import msgspec
import numpy as np

from refdem.checks._beside_impacts import errors_of
from refdem.checks._crossings import crossings, has_crossings, is_belt
from refdem.checks._impacts import is_sequence
from refdem.checks.contact_impulse import alternating_slip, slip_in_scales
from refdem.core.check import Check, CompletedRun, Subject
from refdem.core.finding import Finding
from refdem.core.judgement import (
    MIXED,
    SMALL,
    Array,
    certified,
    judged,
    moves,
    no_truth,
    observed_order,
    order_statement,
    predictable,
    signed,
    undecided,
)
from refdem.core.problem import Motion
from refdem.core.refinement import (
    MEMORY,
    SCATTER,
    bound,
    kinked,
    order_levels,
    scored,
    smoothness,
)
from refdem.core.truth import SampledTruth
from refdem.core.variant import Variant
from refdem.scene.elements.contact import Contact

SURE = 3.5
"""Standard deviations by which a mean order must miss the claimed one: 1 in 4000 by chance."""
STUDENT = (float("inf"), 318.3, 22.3, 10.2, 7.2)
"""The same if the deviation is estimated from the errors themselves: quantiles of Student's t
(1908) for 1 in 1000, by degrees of freedom.
"""

LINE = 0.8
"""Smallest deficit of a mean order at which errors on a line speak against the claim.

Halving a step doubles the relative position of a kink within it, so a position near the start of a
step moves on regularly, and errors that kinks scatter may lie on a line for some octaves. Measured:
of 3000 motions of velocity Verlet across fields with two random edges, a deficit of 0.5 or more on
a line fails 13 at six levels; 0.8 or more, 3. A method of first order is failed in all 3000.
"""

OCTAVES = 14
"""-log2 of the probability, 1 in 16,000, below which events are not taken to lie near samples by
chance.
"""

WHOLE = 0.9
"""Deficit, nearly a whole order, at which a single pair of levels contradicts the claim.

With a smaller deficit one pair does not distinguish a lower order from terms that cancel.
"""

CANCELLED = 0.1
"""Largest residual, relative to the errors, of a fit with terms of the claimed order and the next.

A term one order lower that makes a tenth of the errors leaves 0.04, one that makes all of them
0.38. Measured where leading terms cancel: 0.002 (RK4, Duffing's oscillator, pairs 5.6, 3.2, 3.5,
3.8).
"""

RISE = 0.25
"""Octaves by which an error must rise from level to level to count as growing: errors that cancel,
or scatter a little, rise once.
"""

STARTED = 8 * MEMORY
"""Steps of a multistep method among which those that start it change an order by less than its
tolerance.
"""
NEAR = 0.25
"""The largest deficit of a mean order for which the levels of the plan decide, if the errors lie on
a line.
"""
ON_A_LINE = 0.1
"""The largest standard deviation of a mean order, from the residuals, of errors that lie on a line.

Of errors that kinks scatter by an octave, four have residuals as small once in 20, and with an
order that is lower by 1 a mean as near to the claim once in 20 of these.
"""
FEWEST = 4
"""Levels that such a mean is taken over."""
WHOLE_ORDER = 0.25
"""Largest distance of an observed order from the whole number that it is taken for."""

ErrorsByLevel = Mapping[float, Mapping[str, Array]]
"""Scaled errors (until,) by level and quantity."""


def with_key(subject: Subject, finding: Finding) -> Finding:
    """The finding; if it failed and the observed lower order would agree with a claim, its sentence
    names the key to declare.
    """
    observed = finding.order_seen
    if finding.outcome != "fail" or observed is None or kinked(subject.instance, subject.method):
        return finding
    # Errors that are the same at two steps, or none at the coarser one, have no finite order.
    if not np.isfinite(observed):
        return finding
    order = round(observed)
    key = _lowering_key(subject)
    is_lower = 1 <= order < subject.order and abs(observed - order) <= WHOLE_ORDER
    if key is None or not is_lower:
        return finding
    sentence = (
        f"{finding.sentence} A method that is of order {order} by construction in scenes with"
        f' {key} may declare order_with = {{ "{key}" = {order} }}.'
    )
    return msgspec.structs.replace(finding, sentence=sentence)


def _lowering_key(subject: Subject) -> str | None:
    """The key of `order_with` for the first feature of a smooth scene that lowers the order of some
    methods by their construction: joints, forces that depend on velocities, bodies that turn. For
    kinks `_declaration_hint` gives the key.
    """
    problem = subject.instance.problem
    if "constraint" in problem.features:
        return "constraint"
    if isinstance(problem, Motion):
        for element in problem.scene.elements:
            if element.reads_velocity:
                return element.kind
    if "rotation" in problem.features:
        return "rotation"
    return None


ROUNDED = (
    "coarser pairs of levels show the claimed order, and rounding may be what the finest pair lacks"
)
"""Why a deficit of the finest pair alone decides nothing next to round-off."""
ALTERNATES = (
    "friction alternates in sign from step to step, and what one step of it leaves is more than the"
    " errors that grow"
)
"""Why errors that grow decide nothing where a slip of 0 is left by a rounding."""


class Order(Check):
    """Pairs of neighbouring levels reach the claimed order as the step falls; with kinks in the
    motion, the mean over all levels does.
    """

    name = "order"
    title = "Observed order"
    kills = "a wrong coefficient in the integrator, a force taken at the wrong time level"

    def applies(self, subject: Subject) -> str | None:
        """Methods with a fixed step."""
        if subject.method.control == "step":
            return None
        return f"the step control of the method is {subject.method.control}, not a fixed step"

    def needs(self, subject: Subject) -> tuple[Variant, ...]:
        """The plain run of every level."""
        return subject.plain

    def further(
        self, subject: Subject, runs: Mapping[Variant, CompletedRun]
    ) -> tuple[Variant, ...]:
        """Finer levels where kinks scatter the errors, unless the others show the order."""
        levels = order_levels(subject.instance, subject.method, subject.levels)
        finer = tuple(map(Variant, levels[len(subject.levels) :]))
        if not finer or certified(subject) is None or self._is_shown(subject, runs):
            return ()
        return finer

    def _is_shown(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> bool:
        """True if the levels of the plan pass, on a line of the claimed order or more."""
        findings = self._findings(subject, runs, subject.levels)
        is_passed = all(finding.outcome == "pass" for finding in findings)
        if not is_passed or findings[0].order_seen is None:
            return False
        errors_at = _errors_at_levels(subject, runs, subject.levels)
        counting, common = _counting_levels(subject, subject.levels)
        largest = [_largest(errors_at[h], common) for h in counting]
        if len(counting) < FEWEST or min(largest) <= 0.0:
            return False
        slope, _, from_residuals = mean_order(counting, largest)
        return slope >= subject.order - NEAR and from_residuals <= ON_A_LINE

    def judge(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> list[Finding]:
        """The finding `state`, of the observed order; and `growth`, if errors are large enough to
        show whether they grow.
        """
        if certified(subject) is None:
            return [undecided(self.name, "state", no_truth(subject))]
        levels = order_levels(subject.instance, subject.method, subject.levels)
        made = tuple(level for level in levels if Variant(level) in runs)
        return self._findings(subject, runs, made)

    def _findings(
        self,
        subject: Subject,
        runs: Mapping[Variant, CompletedRun],
        levels: tuple[float, ...],
    ) -> list[Finding]:
        """The findings from the runs of these levels; the subject has truth."""
        truth = certified(subject)
        assert truth is not None
        errors_at = _errors_at_levels(subject, runs, levels)
        if not errors_at[subject.levels[0]]:
            return [undecided(self.name, "state", MIXED)]
        state = self._state(subject, runs, truth, errors_at)
        return [with_key(subject, state), *self._growth(subject, runs, errors_at)]

    def _state(
        self,
        subject: Subject,
        runs: Mapping[Variant, CompletedRun],
        truth: SampledTruth,
        errors_at: ErrorsByLevel,
    ) -> Finding:
        """The finding on the observed order against the claimed one.

        Three levels must have bounds between 20 x round-off and 0.1 of the scale. Depending on the
        errors the order is that of the last pairs (`_deficit`), the mean over all levels where
        kinks scatter them (`_mean`), or none, where all are round-off (`_nothing_left`).
        """
        counting, common = _counting_levels(subject, tuple(errors_at))
        if len(counting) < 3:
            why = (
                f"only {len(counting)} of {len(errors_at)} refinement levels are usable (bound"
                " between 20 x round-off and 0.1 of the scale, step shorter than the motion);"
                " 3 are needed"
            )
            return undecided(self.name, "state", why)
        floor = [_floor(subject, h) for h in counting]
        largest = [_largest(errors_at[h], common) for h in counting]
        if all(error <= low for error, low in zip(largest[1:], floor[1:], strict=True)):
            return self._nothing_left(largest, floor)
        if kinked(subject.instance, subject.method):
            above = [k for k in range(len(largest)) if largest[k] > floor[k]]
            return self._mean(subject, [counting[k] for k in above], [largest[k] for k in above])
        pairs = list(zip(pairwise(largest), floor[1:], strict=True))
        # log2(e(h)/e(h/2)) of every pair whose finer error is above round-off.
        orders = [observed_order(a, b) for (a, b), low in pairs if b > low]
        resolved = [
            h for h, error, low in zip(counting, largest, floor, strict=True) if error > low
        ][-3:]
        # A relative rounding error r of the finer error b of a pair changes log2 b by r/ln 2, and
        # the coarser error, which is larger, has a smaller one. So the order is off by at most
        # 2 r/ln 2.
        rounded = max(
            _rounding(subject, h) / b
            for h, (_, b), low in zip(counting[1:], pairwise(largest), floor[1:], strict=True)
            if b > low
        )
        # Orders of the levels too coarse to count, which show how fast the deficit falls.
        coarser = [_largest(errors_at[h], common) for h in subject.levels if h > counting[0]]
        coarser_orders = [
            observed_order(a, b) for a, b in pairwise([*coarser, largest[0]]) if b > 0 and a < SMALL
        ]
        expected = expected_deficit(
            [*coarser_orders, *orders], subject.order
        ) + 2 * rounded / float(np.log(2.0))
        misfits = _misfits(subject, runs, truth, resolved, common)
        next_order = _order_at_most(subject, counting, largest, floor)
        finding = self._deficit(subject, orders, expected, misfits, next_order)
        shift = 2 * rounded / float(np.log(2.0))
        if finding.outcome == "fail" and _may_be_rounding(subject, orders, shift):
            return undecided(self.name, "state", ROUNDED)
        return finding

    def _growth(
        self, subject: Subject, runs: Mapping[Variant, CompletedRun], errors_at: ErrorsByLevel
    ) -> list[Finding]:
        """The finding that errors at the three finest levels do not rise as the step falls,
        whatever their bound.

        The value is the rise in octaves, log2(e(h/4)/e(h)), if the error rises by more than RISE at
        both halvings, else 0. Errors are compared up to the first sample at which one of them is no
        longer small, since beyond it they have no order. Where kinks scatter errors, the mean slope
        of all levels must be below -RISE and miss the claimed order by more than SURE standard
        deviations. Undecided where the errors are within those that alternating friction causes.
        """
        levels = sorted(errors_at, reverse=True)
        if len(levels) < 3:
            return []
        common = min(predictable(errors_at[h]) for h in levels[-3:])
        if common < 2:
            return []
        largest = [_largest(errors_at[h], common) for h in levels]
        all_resolved = all(
            error > _floor(subject, h) for h, error in zip(levels[-3:], largest[-3:], strict=True)
        )
        if not all_resolved:
            return []
        # Octaves by which the error rises at each halving.
        rises = [float(np.log2(fine / coarse)) for coarse, fine in pairwise(largest[-3:])]
        rises_throughout = min(rises) > RISE
        if kinked(subject.instance, subject.method):
            slope, deviation, _ = mean_order(levels, largest)
            is_beyond_chance = slope < -RISE and subject.order - slope > SURE * deviation
            rises_throughout = rises_throughout and is_beyond_chance
        rise = 0.0
        if rises_throughout:
            rise = max(0.0, sum(rises))
        if rise > 0 and _alternates(subject, runs, levels[-3:], largest[-3:]):
            return [undecided(self.name, "growth", ALTERNATES)]
        listed = ", ".join(f"{error:.2g}" for error in largest)
        return [
            judged(
                check=self.name,
                quantity="growth",
                value=rise,
                bound=0.0,
                unit="octaves",
                basis=(
                    "the error of a convergent method cannot grow over three levels above"
                    " round-off as the step falls"
                ),
                what=(
                    "The growth of the error over the three finest levels (errors, coarse to"
                    f" fine: {listed})"
                ),
            )
        ]

    def _nothing_left(self, largest: list[float], floor: list[float]) -> Finding:
        """The finding where the error is round-off at every level but perhaps the coarsest: no
        order can be observed.
        """
        first = 0
        what = "The error at every level"
        if not largest[0] <= floor[0]:
            first = 1
            what = "The error at every level but the coarsest"
        return judged(
            check=self.name,
            quantity="state",
            value=max(largest[first:]),
            bound=max(floor[first:]),
            unit="1",
            basis=(
                "20 times round-off, so no truncation error is left from which to observe an order"
            ),
            what=what,
        )

    def _deficit(
        self,
        subject: Subject,
        orders: list[float],
        expected: float,
        misfits: "Misfits | None",
        next_order: float = float("-inf"),
    ) -> Finding:
        """The finding that the deficit d = p - (observed order) vanishes in the limit of small
        steps, within the tolerance max(0.15, 0.05 p).

        There are four outcomes, tried in this order:

        - Undecided: there is one pair of levels above round-off, and its order may still rise. It
          may if d < WHOLE, or if the next pair, whose order is at most `next_order` because of its
          rounding, may have at most half of d, or a deficit within the tolerance. (A deficit due to
          the next term of the error halves with the step; one due to a term of lower order does
          not fall.)
        - `_cancelled` judges it: d exceeds the tolerance, but orders p and p + 1 fit the errors at
          least as well as p - 1 and p do.
        - The deficit of the finest pair is compared with `expected`, if that is less than the
          tolerance, and if d is within `expected` or a term of lower order fits the errors better.
        - Otherwise d is compared with the tolerance.

        `orders` are those of the pairs above round-off, coarse to fine; `expected` bounds the
        deficit of the finest pair (`expected_deficit`); `misfits` is None for fewer than three
        levels.
        """
        claimed = subject.order
        tolerance = max(0.15, 0.05 * claimed)
        listed = ", ".join(f"{order:.2f}" for order in orders)
        # d in the limit of small steps, from the last two pairs.
        deficit = order_deficit(orders, claimed)
        first_deficit = claimed - orders[0]
        is_alone = len(orders) == 1 and first_deficit > tolerance
        # p - next_order <= max(tolerance, d/2): the next pair may have half the deficit.
        falls = claimed - next_order <= max(tolerance, first_deficit / 2.0)
        may_rise = first_deficit < WHOLE or falls
        if is_alone and may_rise:
            why = (
                f"only one pair of levels is above round-off; its observed order {listed}"
                f" may still rise to the claimed {claimed}"
            )
            return undecided(self.name, "state", why)
        if deficit > tolerance and misfits is not None and not misfits.is_lower:
            return self._cancelled(subject, orders, misfits)
        basis = (
            f"order {claimed} is claimed, and pairs of levels must reach it within"
            " max(0.15, 0.05 p) as the step falls"
        )
        if expected < tolerance and (
            deficit <= expected or (misfits is not None and misfits.is_lower)
        ):
            tolerance = expected
            # `expected` bounds the deficit of the finest pair, not its limit for small steps, so
            # that deficit is the value compared. It is at least the limit, and exceeds the limit
            # only where the deficit falls from the pair before.
            deficit = max(0.0, claimed - orders[-1])
            basis = (
                f"order {claimed} is claimed, and the deficit of pairs of levels must fall with the"
                " step"
            )
        return judged(
            check=self.name,
            quantity="state",
            value=deficit,
            bound=tolerance,
            unit="1",
            basis=basis,
            statement=order_statement(
                orders[-1], claimed, deficit, tolerance, f"by pairs of levels: {listed}"
            ),
            order_seen=orders[-1],
            order_claimed=float(claimed),
        )

    def _cancelled(self, subject: Subject, orders: list[float], misfits: "Misfits") -> Finding:
        """The finding on low observed orders whose cause may be that leading terms cancel: the
        relative residual of a fit of a h^p + b h^(p+1) to the signed errors is at most CANCELLED.

        Undecided if the residual is larger: the errors then do not distinguish the orders p and
        p - 1.
        """
        claimed = subject.order
        listed = ", ".join(f"{order:.2f}" for order in orders)
        if misfits.claimed > CANCELLED:
            why = (
                f"the observed orders are {listed}, and error terms of order"
                f" {claimed - 1:g} fit the errors as well as those of order {claimed}"
            )
            return undecided(self.name, "state", why)
        return judged(
            check=self.name,
            quantity="state",
            value=misfits.claimed,
            bound=CANCELLED,
            unit="1",
            basis=(
                f"leading terms cancel here; a fit with orders {claimed - 1:g} and"
                f" {claimed:g} leaves {misfits.lower:.2g}"
            ),
            what=(
                f"The relative residual of the errors after a fit of a h^{claimed:g} + b"
                f" h^{claimed + 1:g} (observed orders {listed})"
            ),
            order_seen=orders[-1],
            order_claimed=float(claimed),
        )

    def _mean(self, subject: Subject, steps: list[float], largest: list[float]) -> Finding:
        """The finding on the mean order, where kinks scatter the error constant: it is within 0.5
        of the claimed one.

        A mean order further off than 0.5 fails only if the miss exceeds what the scatter explains.
        """
        claimed = subject.order
        limit = smoothness(subject.instance, subject.method)
        basis = (
            f"order {claimed} is claimed; kinks in the motion scatter the errors by a factor of 2,"
            " so the mean order is compared"
        )
        if limit is not None and claimed < subject.method.order_for(
            subject.instance.problem.features
        ):
            basis = (
                f"a force that varies as |s|^{limit.exponent:g} limits fixed steps to"
                f" order {claimed:g}; the method may declare {limit.key}"
            )
        if len(steps) < 2:
            return undecided(self.name, "state", "only one level is above round-off")
        # `deviation` is the one expected of errors that kinks scatter, `from_residuals` that of
        # the observed errors.
        slope, deviation, from_residuals = mean_order(steps, largest)
        deficit = claimed - slope
        # The deficit that scatter explains: min(SURE sigma, max(LINE, t s)), where sigma is the
        # expected deviation of the slope, s that from the residuals, and t Student's quantile for
        # n - 2 degrees of freedom.
        quantile = STUDENT[min(len(steps) - 2, len(STUDENT) - 1)]
        scatter = min(SURE * deviation, max(LINE, quantile * from_residuals))
        # Kinks may make the error small at a coarse step, so that it rises to the next level, but
        # they do not make it rise over all levels. With two levels, the coarser error may be small
        # by chance.
        may_rise = len(steps) == 2 or _best_tail(steps, largest) >= -RISE
        is_by_kinks = may_rise and _kinks_explain(subject, steps, largest)
        if deficit > 0.5 and (deficit <= scatter or is_by_kinks):
            why = (
                f"kinks scatter the errors; {len(steps)} levels above round-off cannot"
                f" distinguish the mean order {slope:.2f} from {claimed}"
            )
            return undecided(self.name, "state", why)
        if deficit > 0.5:
            basis += "; " + _declaration_hint(subject, slope)
        return judged(
            check=self.name,
            quantity="state",
            value=max(0.0, deficit),
            bound=0.5,
            unit="1",
            basis=basis,
            statement=order_statement(
                slope,
                claimed,
                max(0.0, deficit),
                0.5,
                f"mean over {len(steps)} levels, standard deviation {deviation:.2f}",
            ),
            order_seen=slope,
            order_claimed=float(claimed),
        )


def _kinks_explain(subject: Subject, steps: list[float], largest: list[float]) -> bool:
    """True if kinks may explain errors that do not fall with the step: every error is within the
    bound that the claim gives at the finest step, and chance may have placed the kinks near samples
    (K n <= OCTAVES).

    A kink at the fraction f of a step makes an error C h^p g(f) with |g| <= 1, and halving the step
    changes f to 2 f, or to 2 f - 1. Near a sample f < 2^-n, and if g varies as f^m there, the
    errors of n levels lie on a line of the order p - m. So impacts that are detected at the ends of
    steps (m = p = 1) are late by the same time, and a force |s|s that passes zero (p = 3, m = 2)
    shows the order 1. A body at rest, as a box on a slope, has no kink.

    Of K events, each lies within 2^-n of a sample once in 2^n times, and all of them once in
    2^(K n). Of impacts in sequence the first may make most of the error. The force of a soft
    contact is small where it begins and ends, so that a constant error there is a wrong number.
    """
    truth = subject.truth
    scene = subject.instance.scene
    if truth is None or subject.method.locates_events or not moves(truth):
        return False
    if any(law.law != "rigid" for law in scene.all(Contact)):
        return False
    has_reported_events = has_crossings(scene) and not is_sequence(scene)
    if has_reported_events and _count_of_events(subject, truth) * len(steps) > OCTAVES:
        return False
    of_finest = bound(subject.instance, subject.method, min(steps), truth)
    return max(largest) <= float(of_finest.max())


def _alternates(
    subject: Subject,
    runs: Mapping[Variant, CompletedRun],
    levels: list[float],
    errors: list[float],
) -> bool:
    """True if at each of these levels friction may alternate in sign from step to step, and the
    error (in units of scales) is within the slip that one step of friction produces.

    A rounding then decides in which direction a slip of exactly 0 changes.
    """
    for level, error in zip(levels, errors, strict=True):
        slip = alternating_slip(subject, runs[Variant(level)].trajectory, level)
        if not slip or error > slip_in_scales(subject, slip):
            return False
    return True


def _count_of_events(subject: Subject, truth: SampledTruth) -> int:
    """Number of certified events, and of turns of a body that rubs, up to the last certified
    sample.
    """
    known = crossings(subject, truth).values()
    end = float(subject.instance.times[truth.until - 1])
    events = {crossing.time for of_kind in known for crossing in of_kind if crossing.time <= end}
    if not is_belt(subject.instance.scene) or "v" not in truth.values:
        return len(events)
    direction = np.sign(truth.value("v"))
    return len(events) + int(np.count_nonzero(direction[1:] * direction[:-1] < 0))


def _best_tail(steps: list[float], largest: list[float]) -> float:
    """The largest mean order over all levels, or over the finest three or more: a coarse step that
    ends near a kink makes a small error, from which no order follows. Of three levels the coarsest
    may have such an error, and the finest two count.
    """
    fewest = min(3, len(steps) - 1)
    tails = range(len(steps) - fewest + 1)
    return max(mean_order(steps[first:], largest[first:])[0] for first in tails)


def mean_order(steps: list[float], errors: list[float]) -> tuple[float, float, float]:
    """Slope of log2 error over log2 step by least squares, with two standard deviations of it.

    The first is that of errors that scatter by SCATTER octaves, the second follows from the
    residuals: errors on a line of a wrong slope have no residuals that would excuse it. Two points
    have no residuals: infinity.
    """
    x = np.log2(steps) - np.mean(np.log2(steps))
    y = np.log2(errors) - np.mean(np.log2(errors))
    # With the deviations x, y from the means:
    #   slope = sum x y / sum x^2,   standard deviation of the slope = s / sqrt(sum x^2),
    # where s is SCATTER, or from the residuals s^2 = sum (y - slope x)^2 / (n - 2).
    spread = float(x @ x)
    slope = float(x @ y) / spread
    degrees_of_freedom = len(x) - 2
    residual = float(np.sum((y - slope * x) ** 2))
    expected = SCATTER / float(np.sqrt(spread))
    from_residuals = float("inf")
    if degrees_of_freedom:
        from_residuals = float(np.sqrt(residual / (degrees_of_freedom * spread)))
    return slope, expected, from_residuals


def order_deficit(orders: list[float], claimed: float) -> float:
    """Deficit of the orders of all pairs, coarse to fine, in the limit of small steps; at least 0.

    With d_k the deficit of pair k, the last one d_n, it is

        max(0, min(d_n, 2 d_n - d_(n-1)))   if d_n < 0.5,   else   max(0, d_n).

    A term of lower order dominates the error at the finest pair, so the finest pair decides. Where
    terms of higher order still cancel part of the leading one, d_k = d + A 2^-k to first order in
    the step, and d = 2 d_n - d_(n-1) is Richardson's extrapolation. It is used only where the
    finest order is nearer to the claimed one than to the order below.
    """
    last_deficit = claimed - orders[-1]
    if len(orders) > 1 and last_deficit < 0.5:
        deficit_before = claimed - orders[-2]
        last_deficit = min(last_deficit, 2 * last_deficit - deficit_before)
    return max(0.0, last_deficit)


def expected_deficit(orders: Sequence[float], claimed: float) -> float:
    """Largest |deficit| expected at the finest of three or more pairs, from those at the two pairs
    before; infinite for fewer.

    The error a h^p + b h^(p+1) has at the steps h, h/2 the deficit -b h/(2 a ln 2) to first order
    in h, which halves from pair to pair. With one more term d_k = A 2^-k + B 4^-k, so that

        d_3 = 3/4 d_2 - 1/8 d_1,   |d_3| <= max(|d_2|, |d_1|/2),

    also where d_1 or d_2 is nearly 0 because both terms cancel. A term of order p - 1 doubles the
    deficit from pair to pair instead, until it reaches 1.
    """
    if len(orders) < 3:
        return float("inf")
    # max(|d_2|, |d_1|/2), where d_2 is the pair before the finest, and d_1 the one before d_2.
    deficits = [abs(claimed - order) for order in orders]
    return max(deficits[-2], deficits[-3] / 2.0)


def _order_at_most(
    subject: Subject, levels: Sequence[float], largest: Sequence[float], floor: Sequence[float]
) -> float:
    """The largest order that the errors allow for the first pair whose finer error is within the
    floor; minus infinity without such a pair.

    With the round-off r of the finer error it is log2(e(h)/(e(h/2) - r)), and infinite if r is at
    least e(h/2).
    """
    for k in range(1, len(levels)):
        if largest[k] <= floor[k]:
            unrounded = largest[k] - _rounding(subject, levels[k])
            if unrounded <= 0:
                return float("inf")
            return observed_order(largest[k - 1], unrounded)
    return float("-inf")


class Misfits(NamedTuple):
    """Relative residuals of the errors at the finest level after fits with two powers of the step:
    p and p + 1 (`claimed`), or p - 1 and p (`lower`).
    """

    claimed: float
    lower: float

    @property
    def is_lower(self) -> bool:
        """True if powers of a lower order fit the errors better."""
        return self.lower < self.claimed


def _misfits(
    subject: Subject,
    runs: Mapping[Variant, CompletedRun],
    truth: SampledTruth,
    levels: Sequence[float],
    common: int,
) -> Misfits | None:
    """Residuals of two-term fits to the signed errors at three levels.

    None for fewer levels.
    """
    if len(levels) < 3:
        return None
    errors = [
        signed(subject, runs[Variant(h)].trajectory, truth, common, subject.method.delay(h))
        for h in levels
    ]
    if not errors[-1].size:
        return None
    order = subject.order
    return Misfits(
        claimed=_fit_residual(errors, order, order + 1),
        lower=_fit_residual(errors, order - 1, order),
    )


def _fit_residual(errors: Sequence[Array], first: float, second: float) -> float:
    """Largest relative residual at h/4 of a h^first + b h^second, fitted to the errors at h and
    h/2.

    `errors` are the signed errors at h, h/2 and h/4, arrays of one shape, in units of scales.
    """
    # e(h/4) = (x + y) e(h/2) - x y e(h),  with x = 2^-first, y = 2^-second:
    # both x^k and y^k satisfy this recurrence.
    coarse, middle, fine = errors
    x = 2.0**-first
    y = 2.0**-second
    fitted = (x + y) * middle - x * y * coarse
    return float(np.max(np.abs(fine - fitted)) / np.max(np.abs(fine)))


def _declaration_hint(subject: Subject, slope: float) -> str:
    """What the author of a method may declare in `refdem.toml` if its order is known to be lower
    here.

    `slope` is the mean order observed. A declaration is named only if it would lower the claim,
    and if the observed order would meet the lowered one within 0.5.
    """
    limits = [limit for _, limit in subject.instance.scene.singularities()]
    if not limits:
        return "no force in the scene explains a lower order"
    limit = min(limits)
    declared = math.floor(limit.order)
    claimed = subject.method.order_for(subject.instance.problem.features)
    if declared >= claimed:
        return f"{limit.feature} explains no order below the claimed {claimed}"
    if slope < declared - 0.5:
        return f"{limit.feature} explains an order of {declared}, none as low as {slope:.2f}"
    return f"if the method has a lower order here, declare {limit.key}"


def _errors_at_levels(
    subject: Subject, runs: Mapping[Variant, CompletedRun], levels: tuple[float, ...]
) -> ErrorsByLevel:
    """Scaled errors of every quantity at these levels, coarse to fine; beside an impact those of a
    velocity against either side of it.
    """
    return {h: errors_of(subject, h, runs[Variant(h)].trajectory) for h in levels}


def _largest(scaled: Mapping[str, Array], common: int) -> float:
    """The largest error of any quantity over the first `common` samples."""
    return max(float(np.max(error[:common])) for error in scaled.values())


def _may_be_rounding(subject: Subject, orders: list[float], shift: float) -> bool:
    """True if only the finest pair of levels has a deficit above the tolerance, and above it by at
    most `shift`, the error of an order by rounding.
    """
    claimed = subject.order
    tolerance = max(0.15, 0.05 * claimed)
    *coarser, finest = orders
    missing = claimed - finest
    if not coarser or order_deficit(coarser, claimed) > tolerance or missing <= tolerance:
        return False
    return missing - shift <= tolerance


def _counting_levels(subject: Subject, levels: tuple[float, ...]) -> tuple[list[float], int]:
    """The levels among these, coarse to fine, whose bound lies between 20 x round-off and a tenth
    of the scale; and the number of samples that all of them score.

    Where the sensitivity S makes every bound exceed a tenth of the scale before the end, levels are
    compared on the samples that the third finest level scores, or the fourth finest where kinks
    scatter the errors. Multistep methods make their first steps by another rule, so a level counts
    only if a run has at least STARTED steps. Steps longer than the whole motion do not count.
    """
    truth = subject.truth
    assert truth is not None
    scored_samples = {h: scored(subject.bound(h)) for h in levels}
    if kinked(subject.instance, subject.method):
        n_finer = 3
    else:
        n_finer = 2
    longest_first = sorted(scored_samples.values(), reverse=True)
    last_needed = longest_first[min(n_finer, len(longest_first) - 1)]
    common = min(len(truth.growth()), max(last_needed, 0))
    if common < 2:
        return [], 0
    allowed: dict[float, Array] = {h: subject.bound(h)[:common] for h in levels}
    longest_step = moving_time(truth)
    if not subject.method.complete_state:
        times = subject.instance.times
        longest_step = min(longest_step, abs(float(times[common - 1] - times[0])) / STARTED)
    counting = [
        h
        for h in levels
        if scored_samples[h] >= common and allowed[h][-1] >= _floor(subject, h) and h < longest_step
    ]
    return counting, common


def moving_time(truth: SampledTruth) -> float:
    """Time [s] after which nothing moves any more; infinite where no end is certified.

    Steps longer than the whole motion all have the same error: the distance over which friction
    stops the body.
    """
    time, _ = truth.scalars.get("stop_time", (math.inf, 0.0))
    return time


def _floor(subject: Subject, level: float) -> float:
    """20 x round-off times the sensitivity S at the end: smaller errors have no order."""
    assert subject.truth is not None
    return subject.floor(level) * float(subject.truth.growth()[-1])


def _rounding(subject: Subject, level: float) -> float:
    """Round-off of a level times the sensitivity S at the end; it includes that of a summed clock
    and of positions far from the origin.
    """
    assert subject.truth is not None
    return subject.resolution(level) * float(subject.truth.growth()[-1])


CHECK = Order()
